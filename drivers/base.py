"""Base of all drivers: opening and closing, counters, the promises of the protocol."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Literal

from drivers.closeable import Openable
from drivers.errors import BrokenSource, DriverClosed, InvalidSetting
from drivers.protocol import Health
from drivers.reading import Reading


class BaseDriver(Openable):
    """Template of a driver: a child writes `_next`, and `_connect` and `_disconnect` where it holds something.

    `_closed` is set while the driver is closed: a child that waits, waits on it.
    """

    def __init__(self, source: str, *, sequence_start: int = 1) -> None:
        if not source:
            raise InvalidSetting("the source has an empty name: name it, readings are told apart by it")
        self._source = source
        self._closed = threading.Event()
        self._closed.set()
        self._lock = threading.RLock()
        self._state: Literal["open", "closed"] = "closed"
        self._delivered = self._refused = self._missed = 0
        self._last_taken_at: datetime | None = None
        self._last_sequence = sequence_start - 1

    @property
    def source(self) -> str:
        """Name of the source."""
        return self._source

    def open(self) -> None:
        """Connect; raises `DriverClosed` when open already."""
        with self._lock:
            if not self._closed.is_set():
                raise DriverClosed(f"{self._source!r} is open already: close it first, one reader at a time")
            self._connect()
            self._closed.clear()
            self._state = "open"

    def close(self) -> None:
        """Disconnect; a running iteration ends. Harmless when closed."""
        self._closed.set()
        with self._lock:
            if self._state == "open":
                self._state = "closed"
                self._disconnect()

    def __iter__(self) -> Iterator[Reading]:
        self._require_open()
        return self._deliver()

    def health(self) -> Health:
        """State and counters."""
        return Health(self._state, self._delivered, self._refused, self._missed, self._last_taken_at)

    def _deliver(self) -> Iterator[Reading]:
        while not self._closed.is_set():
            reading = self._next()
            if reading is None or self._closed.is_set():
                return
            yield self._accept(reading)

    def _accept(self, reading: Reading) -> Reading:
        """Hold the source to its promises and count the reading; raises `BrokenSource`."""
        if reading.sequence <= self._last_sequence:
            raise BrokenSource(
                f"{self._source!r} gave sequence {reading.sequence} after {self._last_sequence}: numbers must "
                "increase, or a reading is lost or stored twice; start the source above its last number"
            )
        moment = reading.taken_at
        if moment.tzinfo is not UTC and moment.utcoffset() != timedelta(0):
            raise BrokenSource(f"{self._source!r} gave the time {reading.taken_at.isoformat()}: state it in UTC")
        with self._lock:
            self._last_sequence = reading.sequence
            self._delivered += 1
            self._last_taken_at = moment
        return reading

    def _count(self, *, refused: int = 0, missed: int = 0) -> None:
        with self._lock:
            self._refused += refused
            self._missed += missed

    def _require_open(self) -> None:
        if self._closed.is_set():
            raise DriverClosed(f"{self._source!r} is not open: call open() or use it in a with block")

    def _connect(self) -> None:
        """Take hold of the source; nothing by default."""
        return

    def _disconnect(self) -> None:
        """Let go of the source; nothing by default."""
        return

    @abstractmethod
    def _next(self) -> Reading | None:
        """Wait for the next reading; None at the end of the source or when closed meanwhile."""
