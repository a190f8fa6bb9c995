"""Trace files of PEAK's tools (.trc), versions 1.0 to 1.3 and 2.0 to 2.1.

Format: PEAK CAN TRC File Format 5.0 (PEAK-System). Times are milliseconds since the start, which the line $STARTTIME
states as days since 30 December 1899, and a comment in the header as a date.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta

from drivers.can.logs.dates import UnknownDate, read_date
from drivers.can.logs.frame import LogClock, LogFrame

_COLUMNS: dict[str, tuple[str, ...]] = {
    "1.0": ("N", "O", "I", "L", "D"),
    "1.1": ("N", "O", "T", "I", "L", "D"),
    "1.2": ("N", "O", "B", "T", "I", "L", "D"),
    "1.3": ("N", "O", "B", "T", "I", "R", "L", "D"),
}
"""Number, offset, bus, type, identifier, reserved, length (L: DLC), data."""
_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
DATA_TYPES = frozenset(("RX", "TX", "DT", "FD", "FB", "FE", "BI"))
OTHER_TYPES = frozenset(("RR", "WARNG", "ERROR", "ST", "ER", "EC", "EV"))
NO_BUS = "FFFFFFFF"
"""Identifier of the lines that tell of the bus instead of a frame."""
_START = re.compile(r"^;\s*Start time:\s*(.+?)\s*$", re.IGNORECASE)


class TrcReader:
    """Reads a trace line by line."""

    def __init__(self, clock: LogClock) -> None:
        self._clock = clock
        self._columns = _COLUMNS["1.0"]
        self._version = "1.0"
        self.unknown_date = ""

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line; None for a line that holds none. Raises ValueError with what is wrong."""
        text = line.strip()
        if not text:
            return None
        if text.startswith(";"):
            self._header(text)
            return None
        return self._frame(text)

    def _header(self, text: str) -> None:
        key, _, value = text.partition("=")
        if key == ";$FILEVERSION":
            self._version = value.strip()
            self._columns = _COLUMNS.get(self._version, self._columns)
        elif key == ";$STARTTIME":
            self._clock.begin(_from_days(value.strip()), f"$STARTTIME {value.strip()}, taken as UTC")
        elif key == ";$COLUMNS":
            self._columns = tuple(one.strip() for one in value.split(","))
        elif (found := _START.match(text)) and self._clock.start is None:
            try:
                moment, zoned = read_date(found.group(1))
            except UnknownDate as error:
                self.unknown_date = str(error)
            else:
                says = f"the comment Start time: {found.group(1)}{'' if zoned else ', taken as UTC'}"
                self._clock.begin(moment, says)

    def _frame(self, text: str) -> LogFrame | None:
        columns = self._columns
        parts = dict(zip(columns, text.split(maxsplit=len(columns) - 1), strict=False))
        kind = parts.get("T", "Rx").upper()
        identifier = parts.get("I", "")
        if kind in OTHER_TYPES or identifier.upper() == NO_BUS:
            return self._other(parts, identifier)
        if kind not in DATA_TYPES:
            raise ValueError(f"{kind[:20]!r} is no type of a line of version {self._version}")
        if "O" not in parts or ("L" not in parts and "l" not in parts):
            raise ValueError("it has too few parts")
        at = self._clock.tick(_number(parts["O"]) / 1000.0)
        number, extended = _identifier(identifier), len(identifier) > 4
        if parts.get("D", "").upper().startswith("RTR"):
            return LogFrame(at, number, extended, b"", False)
        length = self._length(parts)
        data = parts.get("D", "").split()
        if len(data) < length:
            raise ValueError(f"it has {len(data)} bytes of data where {length} are announced")
        try:
            return LogFrame(at, number, extended, bytes(int(one, 16) for one in data[:length]))
        except ValueError:
            raise ValueError(f"its data {' '.join(data)[:40]!r} are no bytes") from None

    def _other(self, parts: dict[str, str], identifier: str) -> LogFrame | None:
        """A remote request; the state of the bus is no frame."""
        if parts.get("T", "").upper() != "RR":
            return None
        return LogFrame(
            self._clock.tick(_number(parts["O"]) / 1000.0), _identifier(identifier), len(identifier) > 4, b"", False
        )

    def _length(self, parts: dict[str, str]) -> int:
        text = parts.get("l", parts.get("L", ""))
        length = int(text) if text.isdigit() else -1
        if "l" not in parts and 0 <= length < len(_LENGTHS):
            length = _LENGTHS[length]
        if not 0 <= length <= 64:
            raise ValueError(f"length {text[:20]!r} is none of a frame")
        return length


def _from_days(text: str) -> datetime:
    """A date as days since 30 December 1899, which spreadsheets count."""
    days = _number(text.replace(",", "."))
    if not 20_000.0 <= days <= 100_000.0:
        raise ValueError(f"$STARTTIME {text[:40]!r} is no date in days since 1899")
    moment = datetime(1899, 12, 30, tzinfo=UTC) + timedelta(days=days)
    return moment + timedelta(microseconds=500 - (moment.microsecond + 500) % 1000)  # written to a tenth of it


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{text[:40]!r} is no number") from None


def _identifier(text: str) -> int:
    try:
        found = int(text, 16)
    except ValueError:
        raise ValueError(f"{text[:40]!r} is no hexadecimal number") from None
    if not 0 <= found <= 0x1FFFFFFF:
        raise ValueError(f"identifier {text[:40]!r} is too great")
    return found
