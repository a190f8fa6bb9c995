"""`drumtrue bridge`: a source of readings kept until the service has it. It needs no database and no web framework."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from drivers.bridge.bridge import Bridge
from drivers.bridge.delivery import HttpSender, Patience
from drivers.bridge.http import HttpOut
from drivers.bridge.spool import Spool
from drivers.can.bus import BusAddress, parse_bus
from drivers.can.driver import CanDriver
from drivers.can.mapping import CanMapping
from drivers.clock import SystemClock
from drivers.files.replay import is_can_log
from drivers.protocol import Driver
from drivers.reading import Mark
from service.cli.support.can_options import mapping_of
from service.cli.support.signals import on_stop
from service.cli.support.sources import Recorded, StandIn, Waveform, named, require_read, stand_in, tell_of

DEFAULT_SPOOL = Path.home() / ".local" / "share" / "drumtrue" / "spool"


@dataclass(frozen=True)
class BusChoice:
    """A CAN bus and what its messages mean."""

    address: BusAddress
    mapping: CanMapping


def bus_choice(bus: str, mapping: Path | None, sensors: str, planes: str, *, j1939: bool) -> BusChoice:
    """Read the options of a command. Raises `InvalidSetting`."""
    return BusChoice(parse_bus(bus), mapping_of(mapping, sensors, planes, j1939=j1939))


def bridge_until_stopped(
    read: BusChoice | StandIn,
    *,
    url: str,
    token: str | None,
    source: str,
    spool: Path | None,
    max_bytes: int,
    status_s: float,
    send_again: bool,
    wait_s: float | None = None,
) -> None:
    """Bridge a bus, a simulated drum, or a file to its end, until SIGINT or SIGTERM.

    wait_s: how long a file is gone on with while the service is away or refuses; None: as `Patience` says. A bus and a
    simulated drum are gone on with for good. Raises what opening bus, file or spool raises, and `DeliveryGivenUp`.
    """
    stop, clock = threading.Event(), SystemClock()
    on_stop(stop.set)
    # A file has a spool of its own: an older one, read later, has lower numbers than what the source sent before.
    file = read.file if isinstance(read, Waveform | Recorded) else None
    own = file is not None and (isinstance(read, Waveform) or is_can_log(file))
    path = spool or spool_of(f"{source}-{file.name}" if file is not None and own else source)
    with Spool(path, max_bytes=max_bytes) as kept:
        if send_again:
            tell(f"{kept.send_again()} readings that were set aside are sent again")
        highest = kept.highest(source)
        first = max(highest + 1, first_sequence())
        driver: Driver
        describe: Callable[[], str] = str
        bridges: list[Bridge] = []
        if isinstance(read, BusChoice):
            driver = can = can_driver(read, source, first, kept.mark(source), bridges)
            describe = can.bus_state
        else:
            driver = stand_in(read, source, first, highest)
        bridge = Bridge(
            driver,
            kept,
            HttpSender(HttpOut(url, token=token)),
            stop=stop,
            clock=clock,
            rng=random.Random(),  # noqa: S311
            report=tell,
            live=isinstance(read, BusChoice),
            status_s=status_s,
            patience=patience_with(read, wait_s),
            describe=describe,
        )
        bridges.append(bridge)
        tell(f"bridge: {read.address if isinstance(read, BusChoice) else named(read)} as {source!r} -> {path} -> {url}")
        if kept.waiting():
            tell(f"{kept.waiting()} readings wait from before")
        try:
            bridge.run()
        finally:
            tell_of(driver)
        require_read(driver)


def patience_with(read: BusChoice | StandIn, wait_s: float | None) -> Patience | None:
    """How long is gone on with a source whose readings are not taken; None: for good."""
    if not isinstance(read, Waveform | Recorded):
        return None
    return Patience() if wait_s is None else Patience(away_s=wait_s, refused_s=wait_s)


def spool_of(source: str, folder: Path = DEFAULT_SPOOL) -> Path:
    """Where the readings of a source wait, unless another file is named."""
    return folder / f"{''.join(c if c.isalnum() or c in '-_.' else '_' for c in source)}.db"


def can_driver(bus: BusChoice, source: str, first: int, resume: Mark | None, bridges: list[Bridge]) -> CanDriver:
    """Build the driver of a bus that goes on from the last mark of its counters.

    bridges: holds, once the driver runs, the bridge that takes the balancer's own corrections and the marks.
    """
    return CanDriver(
        bus.address,
        bus.mapping,
        clock=SystemClock(),
        source=source,
        sequence_start=first,
        on_answer=lambda answer: bridges[0].offer(answer),
        on_mark=lambda mark: bridges[0].mark(mark),
        resume=resume,
    )


def first_sequence() -> int:
    """A number above all that a source used before, unless the clock was set back; its spool knows better."""
    return int(SystemClock().now().timestamp() * 1_000_000)


def tell(line: str) -> None:
    """Say a line at once."""
    print(line, flush=True)
