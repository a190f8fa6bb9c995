"""The shape of a table in a text that nothing is asked of yet: its separator, names, and which columns hold numbers.

The table is the longest run of lines with the same number of cells of which most are numbers; its names are the nearest
line above with as many cells, none of them a number, at most a row of units between.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from drivers.errors import UnreadableFile
from drivers.files.text_table import LOOKED_AT, MAX_UNIT_ROWS, SEPARATORS, cells_of, is_lost, is_number
from drivers.files.time_grid import is_date

MIN_ROWS = 5
"""Lines of numbers that make a table."""
ALMOST = 0.9
"""Share of the lines looked at in which a cell of a column must be a number, or lost."""
LOOKED_AT_BYTES = 4_000_000
_UNIT = re.compile(
    r"^[\[({]?(-*|[nmuµ]?s|sec|min|[mkuµ]?V|gn?|m/s.*|mm/s.*|[mµu]?m|in/s|ips|mils?|rpm|r/min|1/min|k?Hz|°C?|deg|rad|%|"
    r"[mk]?N|m?A|bar|k?Pa|raw|counts?|none|n/a|bool)[\])}]?$",
    re.IGNORECASE,
)


@dataclass(frozen=True, slots=True)
class Shape:
    """names: as a layout names the columns. units: of the row of units, as many as names; empty without one.

    numbers, dates: places of the columns that hold numbers, and times of day or dates. head: the lines above the names.
    rows: the first rows of cells.
    """

    separator: str
    names: list[str]
    units: list[str]
    numbers: list[int]
    dates: list[int]
    head: list[str]
    rows: list[list[str]]


def shape_of(text: str, path: str) -> Shape:
    """The table's shape. Raises `UnreadableFile` where there is none."""
    lines = re.split(r"\r\n|\r|\n", text[:LOOKED_AT_BYTES])[: 2 * LOOKED_AT]
    stated = re.match(r"\s*sep=(.)\s*$", lines[0], re.IGNORECASE)
    runs = [_longest_run(lines, one) for one in ((stated.group(1),) if stated else SEPARATORS)]
    best = max(runs, key=lambda run: run.worth)
    if len(best.rows) < MIN_ROWS:
        raise UnreadableFile(
            f"has no {MIN_ROWS} lines of numbers one below the other in its first {len(lines)} lines: export it as a "
            "table, a line for each moment",
            path=path,
        )
    names, units, above = _names(lines, best)
    columns = list(zip(*best.rows, strict=True))
    numbers = [place for place, cells in enumerate(columns) if _share(map(_is_value, cells)) >= ALMOST]
    dates = [
        place for place, cells in enumerate(columns) if place not in numbers and _share(map(is_date, cells)) >= ALMOST
    ]
    return Shape(best.separator, names, units, numbers, dates, lines[:above], best.rows)


@dataclass(slots=True)
class _Run:
    """Lines from `first` on with as many cells each; worth: how much it looks like a table."""

    separator: str
    first: int
    rows: list[list[str]]
    worth: float = 0.0


def _longest_run(lines: list[str], separator: str) -> _Run:
    best = now = _Run(separator, 0, [])
    for number, line in enumerate(lines):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = cells_of(line, separator)
        values = sum(map(is_number, cells))
        fits = values > 0 and 2 * (values + sum(map(is_date, cells)) + sum(map(is_lost, cells))) >= len(cells)
        if not fits or (now.rows and len(cells) != len(now.rows[0])):
            now = _Run(separator, number, [])
        if fits:
            now.first = number if not now.rows else now.first
            now.rows.append(cells)
            now.worth += values * values / len(cells)
        best = max(best, now, key=lambda run: run.worth)
    return best


def _names(lines: list[str], run: _Run) -> tuple[list[str], list[str], int]:
    """Names of the columns, the row of units, and how many lines stand above; numbers where there are no names."""
    count, units = len(run.rows[0]), []
    candidates = [
        (number, cells_of(lines[number].lstrip("# "), run.separator))
        for number in range(run.first - 1, max(run.first - 2 - MAX_UNIT_ROWS, -1), -1)
        if lines[number].strip()
    ]
    named = [(n, cells) for n, cells in candidates if len(cells) == count and not any(map(is_number, cells))]
    if named and not lines[named[0][0]].lstrip().startswith("#"):
        upper = [one for one in named[1:] if one[0] == named[0][0] - 1]
        number, names = upper[0] if upper and _like_units(named[0][1]) else named[0]
        units = named[0][1] if number != named[0][0] else []
        return names, units, number
    return [str(place) for place in range(1, count + 1)], [], run.first


def _like_units(cells: list[str]) -> bool:
    """Whether a line is a row of units."""
    return 2 * sum(_UNIT.match(cell) is not None for cell in cells) >= len(cells)


def _is_value(cell: str) -> bool:
    return is_number(cell) or is_lost(cell)


def _share(found: Iterable[bool]) -> float:
    told = list(found)
    return sum(told) / len(told)
