"""`drumtrue serve --can`: a bus read into the database by the service itself, through the bridge's own code."""

from __future__ import annotations

import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from drivers.bridge.bridge import Bridge
from drivers.bridge.spool import Spool
from drivers.clock import SystemClock
from service.cli.commands.bridge import BusChoice, can_driver, first_sequence, spool_of, tell
from service.runtime.context import Work
from service.usecases.readings import ingest
from service.usecases.readings.local_delivery import IntoDatabase, last_mark


@dataclass(frozen=True)
class Ear:
    """A bus to listen to, the source it is stored as, and where its readings wait; None: beside an SQLite database."""

    bus: BusChoice
    source: str
    spool: Path | None = None
    max_bytes: int = 256 * 1024 * 1024


@contextmanager
def listening(work: Work, ear: Ear, status_s: float = 60.0) -> Iterator[None]:
    """Read a bus into the database for the length of a block. Raises what opening bus and spool raises."""
    stop, source = threading.Event(), ear.source
    bridges: list[Bridge] = []
    with Spool(ear.spool or _beside(work, source), max_bytes=ear.max_bytes) as spool:
        highest = max(ingest.highest_sequence(work, source), spool.highest(source))
        marks = [mark for mark in (spool.mark(source), last_mark(work, source)) if mark is not None]
        resume = max(marks, key=lambda mark: mark.number, default=None)
        driver = can_driver(ear.bus, source, max(highest + 1, first_sequence()), resume, bridges)
        way = IntoDatabase(work)
        bridge = Bridge(
            driver,
            spool,
            way,
            stop=stop,
            clock=SystemClock(),
            rng=random.Random(),  # noqa: S311
            report=tell,
            status_s=status_s,
            describe=driver.bus_state,
            direct=way,
        )
        bridges.append(bridge)
        driver.open()
        tell(f"listening on {ear.bus.address} as {source!r} -> {spool.path}")
        if spool.waiting():
            tell(f"{spool.waiting()} readings wait from before")
        thread = threading.Thread(target=_run, args=(bridge,), name="listener", daemon=True)
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()


def _beside(work: Work, source: str) -> Path:
    """A spool goes where its database goes; that of a server, where a bridge's goes."""
    url = work.database.url
    if not work.database.embedded or not url.database:
        return spool_of(f"serve-{source}")
    file = Path(url.database)
    return spool_of(f"{file.stem}.{source}.spool", file.parent)


def _run(bridge: Bridge) -> None:
    try:
        bridge.run()
    except Exception as error:
        tell(f"the listener ended: {error}")
