"""`drumtrue serve --can`: a bus read into the database by the service itself, through the bridge's own code."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from drivers.bridge import Bridge
from drivers.clock import SystemClock
from drivers.reading import Answer, Entry
from drivers.spool import MemorySpool
from service.cli.bridging import BusChoice, can_driver, first_sequence, read_closely, tell
from service.usecases import readings
from service.usecases.delivery import IntoDatabase
from service.usecases.work import Work


@contextmanager
def listening(work: Work, bus: BusChoice, source: str, status_s: float = 60.0) -> Iterator[None]:
    """Read a bus into the database for the length of a block. Raises what opening the bus raises."""
    read_closely()
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
