"""`drumtrue serve --can`: read a bus into the database, through the bridge's own code."""

from __future__ import annotations

import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from drivers.bridge.bridge import Bridge
from drivers.bridge.delivery import Backoff
from drivers.bridge.spool import Spool
from drivers.can.driver import CanDriver
from drivers.can.refusals import counted
from drivers.clock import SystemClock
from service.cli.commands.bridge import BusChoice, can_driver, first_sequence, spool_of, tell
from service.runtime.context import AppContext
from service.runtime.listeners import ListenerState
from service.usecases.readings import ingest
from service.usecases.readings.local_delivery import IntoDatabase, last_mark


@dataclass(frozen=True)
class CanListener:
    """A bus to listen to, the source it is stored as, and where its readings wait; None: beside an SQLite database."""

    bus: BusChoice
    source: str
    spool: Path | None = None
    max_bytes: int = 256 * 1024 * 1024


@contextmanager
def listening(work: AppContext, ear: CanListener, status_s: float = 60.0) -> Iterator[None]:
    """Read a bus into the database for the length of a block. Raises what opening bus and spool raises.

    Once it runs, it goes on whatever happens: a lost bus is opened again, and a reader that ends is started again.
    """
    stop = threading.Event()
    with Spool(ear.spool or _beside(work, ear.source), max_bytes=ear.max_bytes) as spool:
        listener = _Listener(work, ear, spool, stop, status_s)
        listener.open()
        tell(f"listening on {ear.bus.address} as {ear.source!r} -> {spool.path}")
        if spool.waiting():
            tell(f"{spool.waiting()} readings wait from before")
        thread = threading.Thread(target=listener.run, name="listener", daemon=True)
        thread.start()
        work.listeners.add(ear.source, listener.state)
        try:
            yield
        finally:
            work.listeners.remove(ear.source)
            stop.set()
            listener.bridge.stop()
            thread.join()


class _Listener:
    """One bus: a bridge into the database, built anew when it ended with an error."""

    def __init__(
        self, work: AppContext, ear: CanListener, spool: Spool, stop: threading.Event, status_s: float
    ) -> None:
        self._work, self._ear, self._spool, self._stop, self._status_s = work, ear, spool, stop, status_s
        self._clock = SystemClock()
        self._pauses = Backoff(random.Random())  # noqa: S311
        self._restarts = 0
        self._ended: str | None = None
        self.driver, self.bridge = self._built()

    def open(self) -> None:
        """Open the bus for the first time. Raises `BusUnavailable`."""
        self.driver.open()

    def run(self) -> None:
        """Run the bridge until stopped, and again after whatever ended it."""
        while not self._stop.is_set():
            try:
                self.bridge.run()
            except Exception as error:
                self._ended = str(error) or type(error).__name__
            while not self._stop.is_set():
                tell(f"the listener ended: {self._ended or 'its bus has no more'}; it is started again")
                if self._clock.wait(self._stop, self._pauses.next_s()) or self._restarted():
                    break

    def _restarted(self) -> bool:
        try:
            self.driver, self.bridge = self._built()
        except Exception as error:  # the database may be away
            self._ended = str(error) or type(error).__name__
            return False
        self._restarts += 1
        self._ended = None
        return True

    def state(self) -> ListenerState:
        """How it is now."""
        trouble = self.bridge.trouble
        return ListenerState(
            source=self._ear.source,
            state="restarting" if self._ended else "reopening" if trouble else "listening",
            reason=self._ended or trouble,
            reopened=self.bridge.reopened,
            restarts=self._restarts,
            refused=counted(self.driver.decoder.counts),
        )

    def _built(self) -> tuple[CanDriver, Bridge]:
        work, source, spool = self._work, self._ear.source, self._spool
        highest = max(ingest.highest_sequence(work, source), spool.highest(source))
        marks = [mark for mark in (spool.mark(source), last_mark(work, source)) if mark is not None]
        resume = max(marks, key=lambda mark: mark.number, default=None)
        bridges: list[Bridge] = []
        driver = can_driver(self._ear.bus, source, max(highest + 1, first_sequence()), resume, bridges)
        way = IntoDatabase(work)
        bridge = Bridge(
            driver,
            spool,
            way,
            stop=threading.Event(),
            clock=self._clock,
            rng=random.Random(),  # noqa: S311
            report=tell,
            status_s=self._status_s,
            describe=driver.bus_state,
            direct=way,
        )
        bridges.append(bridge)
        return driver, bridge


def _beside(work: AppContext, source: str) -> Path:
    """A spool goes where its database goes; that of a server, where a bridge's goes."""
    url = work.database.url
    if not work.database.embedded or not url.database:
        return spool_of(f"serve-{source}")
    file = Path(url.database)
    return spool_of(f"{file.stem}.{source}.spool", file.parent)
