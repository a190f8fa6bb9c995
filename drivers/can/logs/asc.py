"""ASCII logs of Vector's tools, and of all that write them alike (CANoe, CANalyzer, BusMaster, CANgaroo, python-can).

A frame is `time channel identifier Rx|Tx d|r length data`; of an FD channel `time CANFD channel Rx|Tx identifier
[name] brs esi dlc length data ... flags`, where bit 12 of the flags says that the frame is FD. All other lines that
begin with a time are events. Headers are taken wherever they come, in any order, and none is needed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from drivers.can.logs.dates import UnknownDate, read_date
from drivers.can.logs.frame import LogClock, LogFrame, Times

Names = Mapping[str, tuple[int, bool]]
"""Identifier of a message by its name, and whether it is extended."""

_DATE = re.compile(r"^\s*(date|begin\s+trigger\s*block)\s+(\S.*)$", re.IGNORECASE)
_BASE = re.compile(r"^\s*base\s+(hex|dec)\b(?:.*\btimestamps\s+(absolute|relative))?", re.IGNORECASE)
_TIMED = re.compile(r"^\s*(-?\d+(?:[.,]\d+)?)\s+(\S+)\s*(.*)$")
_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
"""Bytes for each DLC of CAN FD (ISO 11898-1)."""
STANDARD_MOST, EXTENDED_MOST = 0x7FF, 0x1FFFFFFF


class AscReader:
    """Reads a log line by line. names: of messages, for logs that hold them instead of identifiers."""

    def __init__(self, clock: LogClock, names: Names) -> None:
        self._clock, self._names = clock, names
        self._base = 16
        self._seen: float | None = None
        self._later: str | None = None
        self.unknown_date = ""

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line; None for a line that holds none. Raises ValueError with what is wrong."""
        timed = _TIMED.match(line)
        if timed is None:
            self._header(line)
            return None
        time, first, rest = timed.groups()
        frame = self._frame(first, rest)
        if "," in time:
            if frame is None:
                return None
            raise ValueError(f"time {time!r} has a decimal comma: this format has a point; write the log again")
        at = self._tick(float(time), frame is not None)
        return None if frame is None or at is None else frame._replace(timestamp=at)

    # ------------------------------------------------------------ headers
    def _header(self, line: str) -> None:
        if found := _BASE.match(line):
            self._base = 16 if found.group(1).lower() == "hex" else 10
            if (found.group(2) or "").lower() == "relative":
                self._clock.times = Times.LINE_BEFORE
        elif found := _DATE.match(line):
            if self._seen is None or self._clock.start is None:
                self._begin(found.group(2), found.group(1).lower())
            else:
                self._later = found.group(2)

    def _begin(self, text: str, what: str) -> None:
        try:
            moment, zoned = read_date(text)
        except UnknownDate as error:
            self.unknown_date = self.unknown_date or str(error)
            return
        self._clock.begin(moment, f"{what} {text.strip()}{'' if zoned else ', taken as UTC'}")

    def _tick(self, time: float, needed: bool) -> float | None:
        if self._later is not None and self._seen is not None and time < self._seen:
            self._begin(self._later, "begin triggerblock")  # the times count anew from a later trigger
        self._later, self._seen = None, time
        if self._clock.start is None and not self._clock.from_user and not needed:
            return None
        return self._clock.tick(time)

    # ------------------------------------------------------------ frames
    def _frame(self, first: str, rest: str) -> LogFrame | None:
        """The frame behind a time; its own time is put in later."""
        if first.upper() == "CANFD":
            return self._fd(rest.split())
        if not first.isdigit():
            return None
        return self._classic(rest.split())

    def _classic(self, parts: list[str]) -> LogFrame | None:
        if parts and parts[0].lower().startswith("errorframe"):
            return LogFrame(0.0, 0, False, b"", False)
        if len(parts) < 3 or parts[1].lower() not in ("rx", "tx", "txrq") or parts[2].lower() not in ("d", "r"):
            return None if len(parts) < 2 or parts[1].lower() not in ("rx", "tx") else _too_short(parts)
        identifier, extended = self._identifier(parts[0])
        if parts[2].lower() == "r":
            return LogFrame(0.0, identifier, extended, b"", False)
        if len(parts) < 4:
            return _too_short(parts)
        length = min(8, _whole(parts[3], self._base))
        return LogFrame(0.0, identifier, extended, self._data(parts[4 : 4 + length], length))

    def _fd(self, parts: list[str]) -> LogFrame | None:
        """Channel Rx identifier [name] brs esi dlc length data ..."""
        if len(parts) < 3 or not parts[0].isdigit() or parts[1].lower() not in ("rx", "tx"):
            return None
        if parts[2].lower().startswith("errorframe"):
            return LogFrame(0.0, 0, False, b"", False)
        at = 3 if len(parts) > 3 and parts[3] in ("0", "1") and _numbers(parts[3:7]) else 4
        if len(parts) < at + 4:
            return _too_short(parts)
        identifier, extended = self._identifier(parts[2])
        dlc, length = _whole(parts[at + 2], 16), _whole(parts[at + 3], 10)
        if not 0 <= dlc < len(_LENGTHS) or not 0 <= length <= 64:
            raise ValueError(f"length {parts[at + 3]!r} with DLC {parts[at + 2]!r} is none of a frame")
        if length == 0 and dlc > 0:
            return LogFrame(0.0, identifier, extended, b"", False)  # a remote request
        return LogFrame(0.0, identifier, extended, self._data(parts[at + 4 : at + 4 + length], length))

    def _identifier(self, text: str) -> tuple[int, bool]:
        extended = text[-1:] in "xX"
        digits = text[:-1] if extended else text
        try:
            found = int(digits, self._base)
        except ValueError:
            if text in self._names:
                return self._names[text]
            kind = "hexadecimal number" if self._base == 16 else "number"
            raise ValueError(
                f"{text[:40]!r} is no {kind}, nor a message of the mapping's DBC: log identifiers, or name that DBC"
            ) from None
        if not 0 <= found <= (EXTENDED_MOST if extended else STANDARD_MOST):
            raise ValueError(f"identifier {text[:40]!r} is too great")
        return found, extended

    def _data(self, parts: list[str], length: int) -> bytes:
        if len(parts) < length:
            raise ValueError(f"it has {len(parts)} bytes of data where {length} are announced")
        try:
            return bytes(int(one, self._base) for one in parts)
        except ValueError:
            raise ValueError(f"its data {' '.join(parts)[:40]!r} are no bytes") from None


def _numbers(parts: list[str]) -> bool:
    """Whether brs, esi, dlc and length stand here, so that no name does."""
    return len(parts) == 4 and parts[1] in ("0", "1") and len(parts[2]) <= 2 and parts[3].isdigit()


def _whole(text: str, base: int) -> int:
    try:
        return int(text, base)
    except ValueError:
        raise ValueError(f"{text[:40]!r} is no whole number") from None


def _too_short(parts: list[str]) -> LogFrame:
    raise ValueError(f"it has {len(parts)} parts behind its channel, too few for a frame")
