"""Run the simulated drum: rounds of readings in batches, until stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from typing import Protocol

from drivers.bridge.http import Outlet
from drivers.checks import require
from drivers.clock import Clock
from drivers.errors import DeliveryFailed
from drivers.reading import Reading
from drivers.simulator.control_schema import ControllableDrum
from drivers.simulator.control_server import ControlPort

FIRST_PAUSE_S = 1.0
MAX_PAUSE_S = 30.0


class Drum(ControllableDrum, Protocol):
    """A simulated drum that is measured in rounds."""

    @property
    def clock(self) -> Clock:
        """Its clock."""
        ...

    @property
    def interval_s(self) -> float:
        """Seconds between rounds."""
        ...

    def measure(self, readings_per_sensor: int) -> list[Reading]:
        """Take rounds at once."""
        ...


@dataclass(frozen=True, slots=True)
class Totals:
    """What a simulation did. unsent: readings that the service had not acknowledged when it stopped."""

    rounds: int = 0
    posted: int = 0
    retries: int = 0
    unsent: int = 0


def silent(line: str) -> None:
    """Say nothing."""


def run_simulation(
    drum: Drum,
    out: Outlet,
    *,
    stop: threading.Event,
    control: ControlPort | None = None,
    batch_size: int = 100,
    batch_s: float = 1.0,
    rounds: int | None = None,
    report: Callable[[str], None] = silent,
) -> Totals:
    """Run the drum until `stop` is set, or for this many rounds; opens and closes drum, outlet and control port.

    A round of readings is taken every drum.interval_s. They are posted when batch_size of them wait, or the first has
    waited batch_s. While the service cannot take them the drum is not read, so no more than one batch and one round
    ever waits; the pause doubles from 1 s to 30 s. report: called with a line of text for each thing worth knowing.

    Raises `DeliveryRefused` when the service refuses a batch for good, `PortUnavailable` for a control port in use.
    """
    require(batch_size >= 1, f"batch_size {batch_size}", "be 1 or more")
    require(batch_s >= 0.0, f"batch_s {batch_s}", "be >= 0")
    with ExitStack() as stack:
        stack.enter_context(closing(out))
        stack.enter_context(drum)
        if control is not None:
            stack.enter_context(control)
            report(f"control port {control.url}")
        loop = _Loop(drum, out, stop, report)
        while not stop.is_set() and (rounds is None or loop.totals.rounds < rounds):
            if loop.totals.rounds and drum.clock.wait(stop, drum.interval_s):
                break
            loop.take_round()
            if len(loop.waiting) >= batch_size or loop.waited_s() >= batch_s:
                loop.post()
        loop.post()
        report(f"stopped after {loop.totals.posted} readings")
        return replace(loop.totals, unsent=len(loop.waiting))


class _Loop:
    """One running simulation: what waits to be posted, and what was done so far."""

    def __init__(self, drum: Drum, out: Outlet, stop: threading.Event, report: Callable[[str], None]) -> None:
        self.drum, self.out, self.stop, self.report = drum, out, stop, report
        self.waiting: list[Reading] = []
        self.totals = Totals()

    def take_round(self) -> None:
        self.waiting.extend(self.drum.measure(1))
        self.totals = replace(self.totals, rounds=self.totals.rounds + 1)

    def waited_s(self) -> float:
        """How long the oldest waiting reading waits."""
        return (self.drum.clock.now() - self.waiting[0].taken_at).total_seconds() if self.waiting else 0.0

    def post(self) -> None:
        """Post what waits, again and again until it is taken; once only when the stop is set."""
        pause = FIRST_PAUSE_S
        while self.waiting:
            try:
                posted = self.out.post(self.waiting)
            except DeliveryFailed as error:
                if self.stop.is_set():
                    return
                self.report(f"{error} Next attempt in {pause:g} s.")
                self.totals = replace(self.totals, retries=self.totals.retries + 1)
                self.drum.clock.wait(self.stop, pause)
                pause = min(2.0 * pause, MAX_PAUSE_S)
            else:
                self.waiting.clear()
                self.totals = replace(self.totals, posted=self.totals.posted + posted)
                self.report(f"posted {self.totals.posted} readings")
