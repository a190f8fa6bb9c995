"""Logs that are tables: a line of names, then a line for each frame, separated by comma, semicolon or tab.

python-can, CSS Electronics, Kvaser, SavvyCAN and others name and write their columns in their own ways. A column is
known by its name; how numbers are written is known by the names of those tools, else seen in the lines themselves.
"""

from __future__ import annotations

import base64
import binascii
import csv
import re
from dataclasses import dataclass, field
from datetime import datetime, timedelta

from drivers.can.logs.dates import UnknownDate, read_date
from drivers.can.logs.frame import EARLIEST_S, LogClock, LogFrame, Times

ROLES: dict[str, str] = {
    "time": "timestampepoch timestamp time timestamps timeoffset reltime relativetime offset",
    "date": "abstime datetime date localtime systemtime absolutetime timeabs",
    "id": "id arbitrationid canid identifier msgid messageid frameid idhex iddec",
    "extended": "extended ide ext isextended isextendedid extendedid xtd",
    "remote": "remote rtr isremote isremoteframe",
    "error": "error iserror iserrorframe err",
    "flags": "flags flag",
    "length": "datalength len length bytes datalen",
    "dlc": "dlc",
    "data": "data databytes payload datahex datafield bytesdata",
}
"""Names of columns, in lower case without signs, by what they hold."""
_BYTE = re.compile(r"^(?:data|d|b|byte|db)(\d{1,2})$")
_UNITS = {"us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ns": 1e-9}
_TRUE = frozenset(("1", "true", "yes", "x", "t"))
_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
KVASER_REMOTE, KVASER_EXTENDED, KVASER_ERROR = 0x1, 0x4, 0x20


@dataclass(slots=True)
class Columns:
    """Which column is what, and how its numbers are written; per_s: seconds of one unit of time."""

    separator: str
    roles: dict[str, int]
    data_bytes: list[int] = field(default_factory=list)
    per_s: float = 1.0
    id_base: int = 16
    data_base: int = 16
    is_base64: bool = False


def columns_of(header: str, lines: list[str]) -> Columns | None:
    """The columns that a line of names states; None where it names no time, no identifier or no data.

    lines: some that follow, to see how numbers are written.
    """
    separator = max(",;\t", key=header.count)
    titles = next(csv.reader([header], delimiter=separator), [])
    roles: dict[str, int] = {}
    found = Columns(separator, roles)
    for place, title in enumerate(titles):
        plain = re.sub(r"[^a-z0-9]", "", re.split(r"[(\[]", title.casefold())[0])
        if _BYTE.match(plain):
            found.data_bytes.append(place)
            continue
        for role, names in ROLES.items():
            if plain in names.split():
                roles.setdefault(role, place)
    if "id" not in roles or not ({"time", "date"} & roles.keys()) or not ("data" in roles or found.data_bytes):
        return None
    _written(found, titles, [row for row in csv.reader(lines, delimiter=separator) if len(row) >= len(roles)])
    return found


def _written(found: Columns, titles: list[str], rows: list[list[str]]) -> None:
    """How the numbers of the rows are written."""
    plain = [title.strip().casefold() for title in titles]
    unit = re.search(r"[(\[]\s*([a-zµ]+)\s*[)\]]", plain[found.roles.get("time", 0)])
    if unit and unit.group(1) in _UNITS:
        found.per_s = _UNITS[unit.group(1)]
    elif "time stamp" in plain and "bus" in plain:
        found.per_s = 1e-6  # SavvyCAN: microseconds, without saying so
    ids = [row[found.roles["id"]].strip() for row in rows if len(row) > found.roles["id"]]
    found.id_base = 16 if "arbitration_id" in plain or _looks_hexadecimal(ids) else 10
    if found.data_bytes:
        cells = [row[at].strip() for row in rows for at in found.data_bytes if len(row) > at and row[at].strip()]
        found.data_base = 16 if _looks_hexadecimal(cells) else 10
    else:
        cells = [row[found.roles["data"]].strip() for row in rows if len(row) > found.roles["data"]]
        found.is_base64 = "arbitration_id" in plain or not all(_is_hexadecimal(one) for one in cells)
    if "timestampepoch" in plain:
        found.id_base = 16  # CSS Electronics: hexadecimal without a mark


def _looks_hexadecimal(cells: list[str]) -> bool:
    """Whether one has a letter or 0x, or is filled up with noughts, as decimal numbers never are."""
    return any(re.search(r"[a-fA-FxX]", one) or (len(one) > 1 and one.startswith("0")) for one in cells)


def _is_hexadecimal(cell: str) -> bool:
    return re.fullmatch(r"(0x)?[0-9A-Fa-f\s.\-]*", cell) is not None


class TableReader:
    """Reads a table line by line; its first line of names has been looked at."""

    def __init__(self, clock: LogClock, columns: Columns, lines: list[str]) -> None:
        self._clock, self._columns, self._begun = clock, columns, False
        rows = list(csv.reader(lines, delimiter=columns.separator))
        times = [time for row in rows if (time := self._time_of(row)) is not None]
        if times and max(times) >= EARLIEST_S:
            clock.times = Times.EPOCH
        elif "time" in columns.roles and "date" in columns.roles:
            _begin_within(clock, self._pairs(rows))

    def read(self, line: str) -> LogFrame | None:
        """The frame of a line; None for an empty one and for the names. Raises ValueError with what is wrong."""
        if not line.strip() or line.startswith(("#", "sep=")):
            return None
        if not self._begun:
            self._begun = True
            return None
        row = next(csv.reader([line], delimiter=self._columns.separator), [])
        roles = self._columns.roles
        most = max([*roles.values(), *self._columns.data_bytes[:1]])
        if len(row) <= max(roles["id"], roles.get("time", 0)) or (len(row) <= most and not self._columns.data_bytes):
            raise ValueError("it has too few parts")
        at = self._at(row)
        identifier, extended, is_data = self._identifier(row)
        return LogFrame(at, identifier, extended, self._data(row) if is_data else b"", is_data)

    # ------------------------------------------------------------ time
    def _time_of(self, row: list[str]) -> float | None:
        place = self._columns.roles.get("time")
        try:
            return None if place is None or place >= len(row) else float(row[place]) * self._columns.per_s
        except ValueError:
            return None

    def _pairs(self, rows: list[list[str]]) -> list[tuple[float, datetime]]:
        """Time and date of the rows that have both."""
        found = []
        for row in rows:
            time, place = self._time_of(row), self._columns.roles["date"]
            if time is not None and place < len(row):
                try:
                    found.append((time, read_date(row[place])[0]))
                except UnknownDate:
                    continue
        return found

    def _at(self, row: list[str]) -> float:
        text = row[self._columns.roles.get("time", self._columns.roles.get("date", 0))].strip()
        try:
            seconds = float(text) * self._columns.per_s
        except ValueError:
            try:
                moment, zoned = read_date(text)
            except UnknownDate:
                raise ValueError(f"{text[:40]!r} is no time") from None
            self._clock.says = f"its dates{'' if zoned else ', taken as UTC'}"
            return moment.timestamp()
        return self._clock.tick(seconds)

    # ------------------------------------------------------------ frame
    def _identifier(self, row: list[str]) -> tuple[int, bool, bool]:
        """Identifier, whether it is extended, whether the frame has data."""
        columns = self._columns
        text = row[columns.roles["id"]].strip()
        marked = text[-1:] in "xXhH" and not text.lower().startswith("0x")
        digits = text[:-1] if marked else text
        try:
            number = int(digits, 16 if digits.lower().startswith("0x") else columns.id_base)
        except ValueError:
            raise ValueError(f"{text[:40]!r} is no {'hexadecimal ' * (columns.id_base == 16)}number") from None
        if not 0 <= number <= 0x1FFFFFFF:
            raise ValueError(f"identifier {text[:40]!r} is too great")
        flags = self._flags(row)
        extended = number > 0x7FF or text[-1:] in "xX" or bool(flags & KVASER_EXTENDED) or self._is(row, "extended")
        other = self._is(row, "remote") or self._is(row, "error") or bool(flags & (KVASER_REMOTE | KVASER_ERROR))
        return number, extended, not other

    def _flags(self, row: list[str]) -> int:
        place = self._columns.roles.get("flags")
        text = "" if place is None or place >= len(row) else row[place].strip()
        return int(text) if text.isdigit() else 0

    def _is(self, row: list[str], role: str) -> bool:
        place = self._columns.roles.get(role)
        return place is not None and place < len(row) and row[place].strip().casefold() in _TRUE

    def _data(self, row: list[str]) -> bytes:
        columns = self._columns
        length = self._length(row)
        if columns.data_bytes:
            cells = [row[at].strip() for at in columns.data_bytes if at < len(row) and row[at].strip()]
            if len(columns.data_bytes) == 1 and len(cells) == 1 and len(cells[0]) > 3:
                cells = re.findall(r"[0-9A-Fa-f]{2}", cells[0])
            data = _bytes(cells if length is None else cells[:length], columns.data_base)
        else:
            data = _packed(row[columns.roles["data"]].strip(), columns.is_base64)
        if length is not None and len(data) < length:
            raise ValueError(f"it has {len(data)} bytes of data where {length} are announced")
        if len(data) > 64:
            raise ValueError(f"it has {len(data)} bytes of data; 64 are the most")
        return data if length is None else data[:length]

    def _length(self, row: list[str]) -> int | None:
        for role in ("length", "dlc"):
            place = self._columns.roles.get(role)
            text = "" if place is None or place >= len(row) else row[place].strip()
            if text.isdigit():
                found = int(text)
                # python-can writes the length under the name dlc; more than 15 is a length in any case
                return _LENGTHS[found] if role == "dlc" and 8 < found < 16 and not self._columns.is_base64 else found
        return None


def _bytes(cells: list[str], base: int) -> bytes:
    try:
        return bytes(int(one, 16 if one.lower().startswith("0x") else base) for one in cells)
    except ValueError:
        raise ValueError(f"its data {' '.join(cells)[:40]!r} are no bytes") from None


def _packed(text: str, is_base64: bool) -> bytes:
    if is_base64:
        try:
            return base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError):
            raise ValueError(f"its data {text[:40]!r} are no base64") from None
    try:
        return bytes.fromhex(re.sub(r"^0x|[.\-\s]", "", text))
    except ValueError:
        raise ValueError(f"its data {text[:40]!r} are no hexadecimal digits") from None


def _begin_within(clock: LogClock, pairs: list[tuple[float, datetime]]) -> None:
    """Start of a log whose dates are cut to whole seconds: all of them together tell it to less than one.

    Of what they leave open, the whole second is taken, else the middle. Dates that stay as they are tell the start.
    """
    if not pairs:
        return
    if len({date for _, date in pairs}) == 1 and pairs[-1][0] - pairs[0][0] >= 1.0:
        clock.begin(pairs[0][1], "its column of dates, taken as UTC")
        return
    whole = all(date.microsecond == 0 for _, date in pairs)
    starts = [date - timedelta(seconds=time) for time, date in pairs]
    if not whole:
        clock.begin(starts[0], "its column of dates, taken as UTC")
        return
    first, last = max(starts), min(starts) + timedelta(seconds=1)
    even = last.replace(microsecond=0)
    start = even if first <= even < last else first + (last - first) / 2 if first < last else first
    clock.begin(start, f"its column of dates, taken as UTC, within {max((last - first).total_seconds(), 0.0):.3f} s")
