"""What candump writes: its log (`-l`, `-L`) and its lines for people, with any of its ways to tell the time (`-t`).

Log: `(time) bus identifier#data`, `##` and a digit of flags for FD, `#R` for a remote request. For people: `(time) bus
[RX B E] identifier [length] bytes`, with the text of the bytes (`-a`), as bits (`-i`) or in reverse order (`-S`).
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from itertools import pairwise

from drivers.can.logs.frame import EARLIEST_S, LogClock, LogFrame, Times

ERROR_FLAG = 0x20000000
_TIME = re.compile(r"^\s*\(\s*(?:(\d{4}-\d\d-\d\d)[ T](\d\d):(\d\d):(\d\d\.\d+)|(-?\d+(?:[.,]\d+)?))\s*\)\s+")
_LOGGED = re.compile(r"^(\S+)\s+([0-9A-Fa-f]{1,8})#(#?)(\S*)(?:\s+[RT])?\s*$")
_SHOWN = re.compile(r"^(\S+)\s+((?:(?:RX|TX|[BE-])\s+)*)([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})\s+\[(\d{1,2})\]\s*(.*)$")
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
NO_TIME = "its lines have no time: record with `candump -l`, `candump -L` or `candump -ta`"


def times_of(lines: list[str]) -> Times:
    """What the times of the first lines count from: small ones from the start, or from the line before if they fall."""
    found = [float(time.group(5).replace(",", ".")) for line in lines if (time := _TIME.match(line)) and time.group(5)]
    if not found or max(found) >= EARLIEST_S:
        return Times.EPOCH
    falls = any(later < before for before, later in pairwise(found))
    same = len(found) > 2 and found[-1] == found[1] > 0.0
    return Times.LINE_BEFORE if falls or same else Times.START


class CandumpReader:
    """Reads a log line by line."""

    def __init__(self, clock: LogClock) -> None:
        self._clock = clock

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line; None for an empty one. Raises ValueError with what is wrong."""
        line = _COLOUR.sub("", line).strip()
        if not line or line.startswith(("#", "interface = ")):
            return None
        time = _TIME.match(line)
        rest = line if time is None else line[time.end() :]
        if not (found := _LOGGED.match(rest)) and not (shown := _SHOWN.match(rest)):
            if rest.lstrip().startswith(("ERRORFRAME", "\t")) or "ERRORFRAME" in rest:
                return LogFrame(self._at(time), 0, False, b"", False)
            raise ValueError("it is no line of candump")
        at = self._at(time)
        return _logged(at, found) if found else _shown(at, shown)

    def _at(self, time: re.Match[str] | None) -> float:
        if time is None:
            raise ValueError(NO_TIME)
        if (day := time.group(1)) is None:
            if "," in time.group(5):
                raise ValueError(f"time {time.group(5)!r} has a decimal comma: candump writes a point")
            return self._clock.tick(float(time.group(5)))
        seconds = float(time.group(4))
        moment = datetime.fromisoformat(f"{day}T{time.group(2)}:{time.group(3)}:00").replace(tzinfo=UTC)
        self._clock.says = "its dates, taken as UTC"
        return moment.timestamp() + seconds


def _logged(at: float, found: re.Match[str]) -> LogFrame:
    _bus, name, fd, data = found.groups()
    identifier, extended = int(name, 16), len(name) > 3
    if extended and identifier & ERROR_FLAG:
        return LogFrame(at, identifier & 0x1FFFFFFF, True, b"", False)
    if data[:1] in ("R", "r") and not fd:
        return LogFrame(at, identifier, extended, b"", False)
    if fd:
        data = data[1:]  # bit rate switch and error state
    else:
        data = data.split("_")[0]  # a DLC of 9 to 15 is put behind
        if ":" in data:
            return LogFrame(at, identifier, extended, b"", False)  # CAN XL
    try:
        contents = bytes.fromhex(data.replace(".", ""))
    except ValueError:
        raise ValueError(f"its data {data[:40]!r} are no hexadecimal digits") from None
    return _checked(LogFrame(at, identifier, extended, contents), 64 if fd else 8)


def _shown(at: float, found: re.Match[str] | None) -> LogFrame:
    assert found is not None  # noqa: S101
    _bus, _marks, name, length_text, rest = found.groups()
    identifier, extended, length = int(name, 16), len(name) == 8, int(length_text)
    if rest.startswith("remote request") or (extended and identifier & ERROR_FLAG):
        return LogFrame(at, identifier & 0x1FFFFFFF, extended, b"", False)
    swapped = "`" in rest.split("'")[0]
    parts = rest.replace("`", " ").split()[:length]
    base = 2 if parts and all(len(one) == 8 and set(one) <= {"0", "1"} for one in parts) else 16
    if len(parts) < length or not all(len(one) == (8 if base == 2 else 2) for one in parts):
        raise ValueError(f"it has not the {length} bytes of data that it announces")
    try:
        contents = bytes(int(one, base) for one in parts)
    except ValueError:
        raise ValueError(f"its data {rest[:40]!r} are no bytes") from None
    return _checked(LogFrame(at, identifier, extended, contents[::-1] if swapped else contents), 64)


def _checked(frame: LogFrame, most: int) -> LogFrame:
    if len(frame.data) > most:
        raise ValueError(f"it has {len(frame.data)} bytes of data; {most} are the most")
    return frame
