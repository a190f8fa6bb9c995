"""Waveforms in a text file: a line of names, then a line of numbers for each moment, as loggers and tables write them.

See `text_table` for what is passed over. An empty cell, or nan, is a lost sample. Where the separator is no comma, a
comma may be the decimal point.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.began import moment_in, moment_of_seconds
from drivers.files.recording import Recording, Stated, read_bytes
from drivers.files.text_table import Table, decoded, find_table, is_lost
from drivers.files.time_grid import on_grid, seconds_of
from drivers.signal.block import Floats
from drivers.units import level_of

MIN_BEFORE_CUT = 10
"""Rows that must be in order before a last one that is not is taken to be cut off."""


def read_csv(
    path: Path,
    wanted: Sequence[str] = (),
    *,
    time: str | None = None,
    sample_rate_hz: float | None = None,
    time_unit: str | None = None,
    encoding: str | None = None,
) -> Recording:
    """Read a file; time: the column of times, from which the rate is taken and gaps are seen.

    wanted: the columns that are read, besides; none: all. time_unit: s, ms, us or ns; None: as the file says, else
    seconds, unless no machine could be sampled so slowly. encoding: of the text; None: as it looks.

    Raises `UnreadableFile`, with the line, for what breaks the format, times that are not even, or a rate that neither
    the file nor the caller states.
    """
    name = str(path)
    text = decoded(read_bytes(path), encoding, name)
    asked = list(dict.fromkeys([*([] if time is None else [time]), *wanted])) if wanted else []
    table = find_table(text, asked, name)
    if time is not None and time not in table.places:
        known = ", ".join(table.titles[:12])
        raise UnreadableFile(f"has no column {time!r}: its columns are {known}", path=name)
    return read_table(table, name, time=time, sample_rate_hz=sample_rate_hz, time_unit=time_unit, whole=not wanted)


def read_table(
    table: Table, name: str, *, time: str | None, sample_rate_hz: float | None, time_unit: str | None, whole: bool
) -> Recording:
    """The columns of a table, see `read_csv`; whole: no row may have cells that no name has."""
    columns, times, notes = _columns(table, name, time, whole=whole)
    count = len(next(iter(columns.values()), times))
    if count < 2:
        raise UnreadableFile(f"has {count} lines of numbers: record for longer", path=name)
    stated: Stated = {title: (None, unit) for title in columns if (unit := _unit_of(table, title)) is not None}
    if time is None:
        if sample_rate_hz is None:
            raise UnreadableFile("does not state its sample rate: name the column of time, or the rate", path=name)
        return Recording(
            name, sample_rate_hz, columns, stated, began=moment_in(table.lines[: table.first]), notes=tuple(notes)
        )
    title = table.titles[table.places[time]]
    cell = table.units[table.places[time]] if table.places[time] < len(table.units) else ""
    seconds, more = seconds_of(times, title, cell, time_unit)
    rate, spread, rounded = on_grid(name, seconds, columns)
    began = moment_of_seconds(float(seconds[0])) or moment_in(table.lines[: table.first])
    return Recording(name, rate, spread, stated, began=began, notes=(*notes, *more, *rounded))


def _columns(
    table: Table, path: str, time: str | None, *, whole: bool
) -> tuple[dict[str, Floats], list[str] | Floats, list[str]]:
    """Values of each wanted column, the cells of the time, and notes."""
    places = {title: place for title, place in table.places.items() if title != time}
    most = max(table.places.values(), default=0)
    values = {title: array("d") for title in places}  # a list of numbers would take four times the room
    times: list[str] = []
    comma = table.separator != ","
    cut: UnreadableFile | None = None
    for number, cells in table.rows():
        if cut is not None:
            raise cut
        try:
            if len(cells) <= most or (whole and len(cells) != len(table.titles)):
                raise UnreadableFile(
                    f"has {len(cells)} cells where {len(table.titles)} columns are named", path=path, line=number
                )
            row = [_number(cells[place], number, path, comma=comma) for place in places.values()]
        except UnreadableFile as error:
            cut = error
            continue
        for one, value in zip(values.values(), row, strict=True):
            one.append(value)
        if time is not None:
            times.append(cells[table.places[time]])
    notes = []
    if cut is not None:
        if len(next(iter(values.values()), times)) < MIN_BEFORE_CUT:
            raise cut
        notes.append(f"its last line ({cut.line}) is cut off and passed over")
    return {title: np.array(one, float) for title, one in values.items()}, times, notes


def _number(cell: str, line: int, path: str, *, comma: bool) -> float:
    if is_lost(cell):
        return math.nan
    text = cell.replace(",", ".") if comma else cell
    if text[:1] in "+-":
        text = text[0] + text[1:].lstrip()
    try:
        value = float(text)
    except ValueError:
        try:
            value = float(re.sub("[dD]", "e", text))  # as Fortran writes it
        except ValueError:
            value = math.inf
    if math.isinf(value) or "_" in cell:
        raise UnreadableFile(f"has {cell[:40]!r} where a finite number must be", path=path, line=line)
    return value


def _unit_of(table: Table, title: str) -> str | None:
    """The unit of a column by the row of units, or in brackets behind its name, if it is one of vibration."""
    place = table.places[title]
    in_brackets = re.search(r"[(\[{]([^)\]}]*)[)\]}]\s*$", table.titles[place])
    cell = table.units[place] if place < len(table.units) else ""
    return level_of(in_brackets.group(1) if in_brackets else cell.strip("()[]{}"))[0]
