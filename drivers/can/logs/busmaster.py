"""Logs of BUSMASTER: `time Rx|Tx channel identifier s|x[r] length bytes` below a header between asterisks."""

from __future__ import annotations

import re
from datetime import datetime, timedelta

from drivers.can.logs.dates import UnknownDate, read_date
from drivers.can.logs.frame import LogClock, LogFrame, Times

MARK = "***BUSMASTER"
_START = re.compile(r"\*\*\*\s*START DATE AND TIME\s+(.*?)\s*\*\*\*", re.IGNORECASE)
_FRAME = re.compile(
    r"^(\d+):(\d+):(\d+):(\d+)\s+(Rx|Tx)\s+(\d+)\s+(?:0x)?([0-9A-Fa-f]+)\s+(\S+)\s+(\d+)\s*(.*)$", re.IGNORECASE
)


class BusmasterReader:
    """Reads a log line by line."""

    def __init__(self, clock: LogClock) -> None:
        self._clock, self._base, self._of_day = clock, 16, False
        self._started: datetime | None = None
        self.unknown_date = ""

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line; None for a line that holds none. Raises ValueError with what is wrong."""
        text = line.strip()
        if not text:
            return None
        if text.startswith("***"):
            self._header(text)
            return None
        found = _FRAME.match(text)
        if found is None:
            raise ValueError("it is no line of BUSMASTER")
        hours, minutes, seconds, fraction = found.group(1, 2, 3, 4)
        time = int(hours) * 3600.0 + int(minutes) * 60.0 + int(seconds) + float(f"0.{fraction}")
        at = self._clock.tick(time)
        kind, length = found.group(8).lower(), int(found.group(9))
        identifier = int(found.group(7), self._base)
        if identifier > 0x1FFFFFFF:
            raise ValueError(f"identifier {found.group(7)[:20]!r} is too great")
        if "r" in kind:
            return LogFrame(at, identifier, kind.startswith("x"), b"", False)
        data = found.group(10).split()
        if len(data) < length:
            raise ValueError(f"it has {len(data)} bytes of data where {length} are announced")
        try:
            return LogFrame(at, identifier, kind.startswith("x"), bytes(int(one, self._base) for one in data[:length]))
        except ValueError:
            raise ValueError(f"its data {found.group(10)[:40]!r} are no bytes") from None

    def _header(self, text: str) -> None:
        if found := _START.match(text):
            try:
                self._started, _ = read_date(found.group(1))
            except UnknownDate as error:
                self.unknown_date = str(error)
        elif text.strip("* ").upper() == "DEC":
            self._base = 10
        elif "RELATIVE MODE" in text.upper():
            self._clock.times = Times.LINE_BEFORE
        self._of_day = self._of_day or "SYSTEM MODE" in text.upper()
        if self._started is not None:
            start = self._started
            if self._of_day:
                start -= timedelta(hours=start.hour, minutes=start.minute, seconds=start.second)
                start = start.replace(microsecond=0)
            self._clock.begin(start, "START DATE AND TIME, taken as UTC")
