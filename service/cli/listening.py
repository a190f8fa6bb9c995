"""`drumtrue serve --can`: a bus read into the database by the service itself, through the bridge's own code."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from sqlalchemy.exc import OperationalError

from db.documents.run import BalancerAnswer, MassOnRotor
from drivers.bridge import Bridge
from drivers.clock import SystemClock
from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.reading import Answer, Entry, Reading
from drivers.spool import MemorySpool
from service.cli.bridging import BusChoice, can_driver, first_sequence, tell
from service.errors import DrumtrueError
from service.usecases import readings
from service.usecases.work import Work


@contextmanager
def listening(work: Work, bus: BusChoice, source: str, status_s: float = 60.0) -> Iterator[None]:
    """Read a bus into the database for the length of a block. Raises what opening the bus raises."""
    stop = threading.Event()
    answers: list[Callable[[Answer], None]] = []
    driver = can_driver(bus, source, max(readings.highest_sequence(work, source) + 1, first_sequence()), answers)
    bridge = Bridge(
        driver,
        MemorySpool(),
        IntoDatabase(work),
        stop=stop,
        clock=SystemClock(),
        rng=random.Random(),  # noqa: S311
        report=tell,
        status_s=status_s,
        describe=driver.bus_state,
    )
    answers.append(bridge.offer)
    tell(f"listening on {bus.address} as {source!r}")
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
        tell(f"the listener ended: {error}")


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
