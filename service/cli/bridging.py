"""`drumtrue bridge` and `serve --can`: a source of readings kept until the service has it."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy.exc import OperationalError

from db.documents.run import BalancerAnswer, MassOnRotor
from drivers.bridge import Bridge, HttpSender
from drivers.can_bus import BusAddress, parse_bus
from drivers.can_driver import CanDriver
from drivers.can_mapping import CanMapping
from drivers.clock import SystemClock
from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.http_out import HttpOut
from drivers.protocol import Driver
from drivers.reading import Answer, Entry, Reading
from drivers.replay import ReplayDriver
from drivers.simulated import SimulatedDrum, threshing_drum_example
from drivers.spool import MemorySpool, Spool
from service.cli.canbus import mapping_of
from service.cli.signals import on_stop
from service.errors import DrumtrueError
from service.usecases import readings
from service.usecases.work import Work

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
    bus: BusChoice | None,
    *,
    url: str,
    source: str,
    spool: Path | None,
    max_bytes: int,
    replay: Path | None,
    seed: int,
    interval_s: float,
    status_s: float,
    send_again: bool,
) -> None:
    """Bridge a bus, else a recording to its end, else a simulated drum, until SIGINT or SIGTERM.

    Raises what opening bus, recording or spool raises.
    """
    stop, clock = threading.Event(), SystemClock()
    on_stop(stop.set)
    path = spool or DEFAULT_SPOOL / f"{''.join(c if c.isalnum() or c in '-_.' else '_' for c in source)}.db"
    with Spool(path, max_bytes=max_bytes) as kept:
        if send_again:
            _tell(f"{kept.send_again()} readings that were set aside are sent again")
        highest = kept.highest(source)
        first = max(highest + 1, first_sequence())
        driver: Driver
        describe: Callable[[], str] = str
        answers: list[Callable[[Answer], None]] = []
        if bus is not None:
            driver = can = _can_driver(bus, source, first, answers)
            describe = can.bus_state
        elif replay is not None:
            driver = ReplayDriver(replay, clock=clock, source=source, after=highest)
        else:
            drum = threshing_drum_example(seed)
            driver = SimulatedDrum(
                drum, seed=seed, clock=clock, source=source, sequence_start=first, interval_s=interval_s
            )
        bridge = Bridge(
            driver,
            kept,
            HttpSender(HttpOut(url)),
            stop=stop,
            clock=clock,
            rng=random.Random(),  # noqa: S311
            report=_tell,
            live=bus is not None,
            status_s=status_s,
            describe=describe,
        )
        answers.append(bridge.offer)
        _tell(f"bridge: {bus.address if bus else replay or 'simulated drum'} as {source!r} -> {path} -> {url}")
        if kept.waiting():
            _tell(f"{kept.waiting()} readings wait from before")
        bridge.run()


def _can_driver(bus: BusChoice, source: str, first: int, answers: list[Callable[[Answer], None]]) -> CanDriver:
    """answers: holds, once the driver runs, who takes the balancer's own corrections."""
    return CanDriver(
        bus.address,
        bus.mapping,
        clock=SystemClock(),
        source=source,
        sequence_start=first,
        on_answer=lambda answer: answers[0](answer),
    )


def first_sequence() -> int:
    """A number above all that a source used before, unless the clock was set back; its spool knows better."""
    return int(SystemClock().now().timestamp() * 1_000_000)


@contextmanager
def listening(work: Work, bus: BusChoice, source: str, status_s: float = 60.0) -> Iterator[None]:
    """Read a bus into the database for the length of a block. Raises what opening the bus raises."""
    stop = threading.Event()
    answers: list[Callable[[Answer], None]] = []
    driver = _can_driver(bus, source, max(readings.highest_sequence(work, source) + 1, first_sequence()), answers)
    bridge = Bridge(
        driver,
        MemorySpool(),
        IntoDatabase(work),
        stop=stop,
        clock=SystemClock(),
        rng=random.Random(),  # noqa: S311
        report=_tell,
        status_s=status_s,
        describe=driver.bus_state,
    )
    answers.append(bridge.offer)
    _tell(f"listening on {bus.address} as {source!r}")
    thread = threading.Thread(target=_run, args=(bridge,), name="listener", daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def _run(bridge: Bridge[Entry]) -> None:
    try:
        bridge.run()
    except Exception as error:
        _tell(f"the listener ended: {error}")


class IntoDatabase:
    """The way into the database of this very process."""

    def __init__(self, work: Work) -> None:
        self._work = work

    def send(self, items: Sequence[Entry]) -> None:
        """Store items; raises a `DeliveryError` as the way over HTTP does."""
        values = [item for item in items if isinstance(item, Reading)]
        try:
            if values:
                readings.ingest(self._work, values)
            for item in items:
                if isinstance(item, Answer):
                    readings.ingest_answer(self._work, _answer(item))
        except DrumtrueError as error:
            if error.status >= 500:
                raise DeliveryFailed(error.message) from error
            raise DeliveryRefused(error.message, status=error.status, detail=error.advice or "") from error
        except OperationalError as error:
            raise DeliveryFailed(f"the database does not take them now ({error.orig})") from error

    def close(self) -> None:
        """Nothing to let go of: the database is the service's."""


def _answer(answer: Answer) -> BalancerAnswer:
    masses = tuple(MassOnRotor(plane=plane, mass_g=mass, angle_deg=angle) for plane, mass, angle in answer.masses)
    return BalancerAnswer(source=answer.source, sequence=answer.sequence, taken_at=answer.taken_at, masses=masses)


def _tell(line: str) -> None:
    print(line, flush=True)
