"""Time as an argument: the wall clock in the shed, a clock moved by hand in tests."""

from __future__ import annotations

import threading
import time
from datetime import UTC, datetime, timedelta
from typing import Protocol

from drivers.errors import InvalidSetting


class Clock(Protocol):
    """What a driver may know of time."""

    def now(self) -> datetime:
        """Present time, aware, UTC."""
        ...

    def sleep(self, seconds: float) -> None:
        """Let `seconds` pass; zero or less returns at once."""
        ...

    def wait(self, event: threading.Event, seconds: float) -> bool:
        """Let `seconds` pass, or less if `event` is set before; True if it is set."""
        ...


class SystemClock:
    """The machine's own clock."""

    def now(self) -> datetime:
        """Present time, aware, UTC."""
        return datetime.now(UTC)

    def sleep(self, seconds: float) -> None:
        """Sleep for `seconds`; zero or less returns at once."""
        if seconds > 0.0:
            time.sleep(seconds)

    def wait(self, event: threading.Event, seconds: float) -> bool:
        """Wait for `event`, at most `seconds`; True if it is set."""
        return event.wait(max(seconds, 0.0))


class ManualClock:
    """A clock that moves only when told to; sleeping moves it, nothing blocks. Safe between threads."""

    def __init__(self, start: datetime = datetime(2026, 1, 1, tzinfo=UTC)) -> None:
        if start.tzinfo is None:
            raise InvalidSetting(f"start {start.isoformat()} has no time zone: give an aware time, e.g. in UTC")
        self._now = start.astimezone(UTC)
        self._lock = threading.Lock()

    def now(self) -> datetime:
        """Present time of this clock, aware, UTC."""
        with self._lock:
            return self._now

    def advance(self, seconds: float) -> None:
        """Move the clock; negative `seconds` set it back, as a corrected wall clock does."""
        with self._lock:
            self._now += timedelta(seconds=seconds)

    def sleep(self, seconds: float) -> None:
        """Move the clock forward by `seconds`; zero or less does nothing."""
        if seconds > 0.0:
            self.advance(seconds)

    def wait(self, event: threading.Event, seconds: float) -> bool:
        """Move the clock forward unless `event` is set; True if it is set."""
        if not event.is_set():
            self.sleep(seconds)
        return event.is_set()
