"""A frame as a log holds it, and what turns the times of a log into times of day."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from enum import Enum, auto
from typing import NamedTuple

EARLIEST_S, LATEST_S = 946_684_800.0, 4_102_444_800.0
"""2000 and 2100: a time outside is no time of day but counts from some start."""


class LogFrame(NamedTuple):
    """One frame: seconds since 1970, identifier, data. is_data: neither a remote request nor an error frame."""

    timestamp: float
    arbitration_id: int
    is_extended_id: bool
    data: bytes
    is_data: bool = True


class Times(Enum):
    """What the times of a log count from."""

    EPOCH = auto()
    START = auto()
    LINE_BEFORE = auto()


class StartUnknown(ValueError):
    """The times count from a start that the log does not state."""


class LogClock:
    """Turns the times of a log's lines into seconds since 1970.

    start: seconds since 1970 at which the log began, where it says so. stated: what the user says it is, which goes
    before. says: where the start was taken from, for a line to the user.
    """

    def __init__(self, stated: datetime | None = None) -> None:
        self.times = Times.START
        self.start: float | None = None
        self.says = ""
        self._stated = None if stated is None else stated.timestamp()
        self._passed = 0.0

    @property
    def from_user(self) -> bool:
        """Whether the user said when the log began."""
        return self._stated is not None

    def begin(self, moment: datetime, says: str) -> None:
        """The log says when it began."""
        self.start, self.says = moment.timestamp(), says

    def tick(self, seconds: float) -> float:
        """Time of a line that states this one. Every line with a time must come by: a relative time adds up.

        Raises `StartUnknown`, and ValueError for what is no time.
        """
        if not math.isfinite(seconds):
            raise ValueError(f"time {seconds} is none")
        if self.times is Times.EPOCH:
            if not EARLIEST_S <= seconds <= LATEST_S:
                raise ValueError(f"time {seconds} s is not after the year 2000, as the times before it are")
            return seconds
        start = self.start if self._stated is None else self._stated
        if start is None:
            raise StartUnknown("its times do not say when it was recorded")
        if self.times is Times.LINE_BEFORE:
            self._passed += seconds
            seconds = self._passed
        at = start + seconds
        if not EARLIEST_S <= at <= LATEST_S:
            raise ValueError(f"time {datetime.fromtimestamp(start, UTC):%Y-%m-%d} and {seconds:.9g} s is none")
        return at
