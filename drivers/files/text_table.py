"""Text of a waveform file as rows of cells: its alphabet, its separator, and the line that names the columns.

Only what the layout names has to be in order: other columns may hold anything, and lines above the names, a row of
units below them and a last line that is cut off are passed over.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from drivers.errors import UnreadableFile

SEPARATORS = (",", ";", "\t", "|", " ")
"""Blank: any number of blanks and tabs."""
LOOKED_AT = 300
"""Lines in which the names are looked for."""
MAX_UNIT_ROWS = 5
LOST = frozenset(("", "nan", "-", "--", "null", "none", "n/a", "na"))
"""What stands in a cell where a sample was lost."""
SHOWN = 12
"""Names and characters of a cell that an error shows."""

_NUMBER = re.compile(r"^[+-]?\s*(\d+([.,]\d*)?|[.,]\d+)([eEdD][+-]?\d+)?$")


@dataclass(frozen=True, slots=True)
class Table:
    """titles: names of the columns. rows: line numbers and cells below the names. places: of the wanted columns.

    units: the cells of the row of units, if there is one. complete: the last line was not cut off.
    """

    titles: list[str]
    places: dict[str, int]
    units: list[str]
    separator: str
    first: int
    lines: list[str]

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line number, from 1, and cells of each line below the names that is no comment."""
        for number in range(self.first, len(self.lines)):
            line = self.lines[number]
            if line.strip() and not line.lstrip().startswith("#"):
                yield number + 1, cells_of(line, self.separator)


def decoded(contents: bytes, encoding: str | None, path: str) -> str:
    """The text of a file: in the stated alphabet, else by its mark, UTF-8, or Windows' Western one (cp1252).

    Raises `UnreadableFile`.
    """
    if encoding is None:
        encoding = _encoding(contents)
    try:
        return contents.decode(encoding)
    except LookupError as error:
        raise UnreadableFile(f"cannot be read as {encoding!r}: {error}; leave encoding out", path=path) from error
    except UnicodeError as error:
        place = getattr(error, "start", 0)
        if encoding == "utf-8-sig":
            return contents.decode("cp1252", errors="replace")
        raise UnreadableFile(f"is no text in {encoding} (byte {place}): save it as UTF-8", path=path) from error


def _encoding(contents: bytes) -> str:
    if contents[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    if contents[:200].count(0) * 3 > len(contents[:200]):  # every other byte of Western text in UTF-16 without a mark
        return "utf-16-le" if contents[1:2] == b"\0" else "utf-16-be"
    return "utf-8-sig"


def find_table(text: str, wanted: Sequence[str], path: str, separator: str | None = None) -> Table:
    """The table in a text whose names hold all wanted ones; wanted empty: the first line's.

    A name may be written in other cases, with its unit behind in brackets, or be a number, as #3. Raises
    `UnreadableFile` naming the columns there are.
    """
    lines = re.split(r"\r\n|\r|\n", text)
    stated = re.match(r"\s*sep=(.)\s*$", lines[0], re.IGNORECASE) if lines else None
    skip = 1 if stated else 0
    tried = (stated.group(1),) if stated else SEPARATORS if separator is None else (separator,)
    best: tuple[int, str, list[str]] | None = None
    near = range(skip, min(len(lines), LOOKED_AT))
    seen = [n for n in near if _is_content(lines[n])]
    commented = [n for n in near if wanted and lines[n].lstrip().startswith("#")]  # as numpy.savetxt writes its names
    for number in seen + commented:
        for one in tried:
            titles = cells_of(lines[number].lstrip("# \t") if number in commented else lines[number], one)
            if wanted and all(_places(titles, name) for name in wanted):
                return _table(lines, number, one, titles, wanted, path)
            if best is None or _like_names(titles) > _like_names(best[2]):
                best = (number, one, titles)
        if not wanted and best is not None and best[0] == number:
            break
    if best is None:
        raise UnreadableFile("has no line of names: export it with one", path=path)
    if all(is_number(one) for one in best[2]) and all(re.fullmatch(r"#?\d+", name) for name in wanted):
        number, one, titles = best
        names = [str(place) for place in range(1, len(titles) + 1)]
        places = {name: _place(names, name.removeprefix("#"), path, number + 1) for name in wanted or names}
        return Table(names, places, [], one, number, lines)
    return _table(lines, *best, wanted, path)


def _like_names(titles: list[str]) -> tuple[bool, int]:
    """How much a line looks like the names of columns: words, and many of them."""
    return (len(titles) > 1 and not any(is_number(one) for one in titles), len(titles))


def _is_content(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _table(lines: list[str], number: int, separator: str, titles: list[str], wanted: Sequence[str], path: str) -> Table:
    if not wanted and "" in titles:
        raise UnreadableFile(f"has names {titles[:SHOWN]}: give each column one", path=path, line=number + 1)
    places = {name: _place(titles, name, path, number + 1) for name in wanted or titles}
    first = number + 1
    units: list[str] = []
    for row in range(first, min(len(lines), first + MAX_UNIT_ROWS)):
        cells = cells_of(lines[row], separator)
        asked = [cells[place] for place in places.values() if place < len(cells)]
        if not lines[row].strip() or not asked or any(not one or is_number(one) or one[0].isdigit() for one in asked):
            break
        first, units = row + 1, units or cells
    return Table(titles, places, units, separator, first, lines)


def _place(titles: list[str], name: str, path: str, line: int) -> int:
    found = _places(titles, name)
    if len(found) > 1:
        raise UnreadableFile(f"names {len(found)} columns {name!r}: give each one name", path=path, line=line)
    if found:
        return found[0]
    if all(is_number(one) for one in titles):
        raise UnreadableFile(
            f"has no column {name!r}: its columns are not named, line {line} holds {len(titles)} numbers; put a line "
            f"with {len(titles)} names above them, as the layout calls them, or name columns by number in the layout, "
            "from '1' on",
            path=path,
        )
    known = ", ".join(one[:40] for one in titles[:SHOWN]) + (" ..." if len(titles) > SHOWN else "")
    raise UnreadableFile(f"has no column {name!r}: its columns are {known or 'none'}", path=path)


def _places(titles: list[str], name: str) -> list[int]:
    """Columns of a name: written as it is, else in other cases, else with something in brackets behind."""
    plain = " ".join(name.casefold().split())
    folded = [" ".join(title.casefold().split()) for title in titles]
    bare = [re.sub(r"\s*[(\[{][^)\]}]*[)\]}]\s*$", "", one) for one in folded]
    for written, asked in ((titles, name), (folded, plain), (bare, plain)):
        found = [place for place, title in enumerate(written) if title == asked]
        if found:
            return found
    number = re.fullmatch(r"#(\d+)", name)
    return [int(number.group(1)) - 1] if number and 1 <= int(number.group(1)) <= len(titles) else []


def cells_of(line: str, separator: str) -> list[str]:
    """Cells of a line, without quotes and blanks around."""
    if separator == " ":
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    except csv.Error:
        return [cell.strip().strip('"') for cell in line.split(separator)]


def is_lost(cell: str) -> bool:
    """Whether a cell says that there is no value."""
    return cell.casefold() in LOST


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma."""
    return _NUMBER.match(cell) is not None or cell.casefold() in ("nan", "inf", "-inf")
