"""Waveforms in a CSV file: a line of names, then a line of numbers for each moment.

Separated by comma, semicolon or tab; with the latter two a comma may be the decimal point. Lines that are empty or
begin with # are passed over. An empty cell, or nan, is a lost sample.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from drivers.errors import UnreadableFile
from drivers.files.recording import Recording, read_bytes
from drivers.signal.block import Floats

OFF_TIME = 0.5
"""Share of a sample by which a written time may differ from the even grid: rounded times do."""
MOST_FILLED = 0.2
"""Share of moments that may be lacking."""


def read_csv(path: Path, *, time: str | None = None, sample_rate_hz: float | None = None) -> Recording:
    """Read a file; time: the column of seconds, from which the rate is taken and gaps are seen.

    Raises `UnreadableFile`, with the line, for what breaks the format, a time that is not even, or a rate that neither
    the file nor the caller states.
    """
    name = str(path)
    try:
        text = read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UnreadableFile(f"is not text in UTF-8 (byte {error.start}): export it as CSV", path=name) from error
    lines = _lines(text)
    header_line, header = next(lines, (0, ""))
    separator = max(",;\t", key=header.count)
    titles = [title.strip().strip('"').strip() for title in header.split(separator)]
    if "" in titles or len(set(titles)) < len(titles):
        raise UnreadableFile(f"has names {titles}: give each column one name", path=name, line=header_line or None)
    numbers = array("d")  # a list of numbers would take four times the room
    for number, line in lines:
        numbers.extend(_numbers(line, number, separator, len(titles), name))
    rows = np.array(numbers, float).reshape(-1, len(titles))
    if len(rows) < 2:
        raise UnreadableFile(f"has {len(rows)} lines of numbers: record for longer", path=name)
    columns = dict(zip(titles, rows.T, strict=True))
    if time is None:
        if sample_rate_hz is None:
            raise UnreadableFile("does not state its sample rate: name the column of time, or the rate", path=name)
        return Recording(name, sample_rate_hz, columns)
    seconds = Recording(name, 1.0, columns).column(time)
    return _on_grid(name, seconds, {title: values for title, values in columns.items() if title != time})


def _lines(text: str) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(text.split("\n"), start=1):
        stripped = line.strip(" \r")
        if stripped.strip() and not stripped.startswith("#"):
            yield number, stripped


def _numbers(line: str, number: int, separator: str, count: int, path: str) -> list[float]:
    cells = line.split(separator)
    if len(cells) != count:
        raise UnreadableFile(f"has {len(cells)} cells where {count} columns are named", path=path, line=number)
    return [_number(cell.strip(), number, separator, path) for cell in cells]


def _number(cell: str, line: int, separator: str, path: str) -> float:
    if not cell:
        return np.nan
    try:
        value = float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        value = np.inf
    if np.isinf(value) or "_" in cell:
        raise UnreadableFile(f"has {cell[:40]!r} where a finite number must be", path=path, line=line)
    return value


def _on_grid(path: str, seconds: Floats, columns: dict[str, Floats]) -> Recording:
    """Put the rows on an even grid of time; moments that are lacking become NaN."""
    steps = np.diff(seconds)
    if not (np.isfinite(seconds).all() and (steps > 0.0).all()):
        bad = int(np.argmin(np.append(np.isfinite(seconds[1:]) & (steps > 0.0), False)))
        raise UnreadableFile(
            f"row {bad + 2} has the time {seconds[bad + 1]}, not after the row before: sort the rows", path=path
        )
    whole = np.round(steps / np.median(steps))
    places = np.concatenate([[0.0], np.cumsum(whole)])
    count = places[-1] + 1.0
    step = (seconds[-1] - seconds[0]) / max(places[-1], 1.0)
    off = np.abs(seconds - seconds[0] - places * step).max() / step
    if whole.min() < 1.0 or off > OFF_TIME or count > len(seconds) * (1.0 + MOST_FILLED):
        raise UnreadableFile(
            f"its times are not even: off by up to {off:.2g} samples, {len(seconds)} rows for {count:.0f} moments; "
            "record at a constant rate",
            path=path,
        )
    index = places.astype(np.intp)
    spread = {}
    for name, values in columns.items():
        spread[name] = np.full(int(count), np.nan)
        spread[name][index] = values
    return Recording(path, float(1.0 / step), spread)
