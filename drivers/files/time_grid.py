"""Times of rows put on an even grid: any unit, dates, rounded times, and gaps where rows are lacking."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np

from drivers.errors import UnreadableFile
from drivers.signal.block import Floats

OFF_TIME = 0.5
"""Share of a sample by which a written time may differ from the even grid: rounded times do."""
MAX_FILLED = 0.2
"""Share of moments that may be lacking."""
SLOW_HZ, FAST_HZ = 20.0, 1e6
"""Rates that a machine's vibration is sampled at; as seconds, times in another unit give less."""
PER_SECOND = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in each unit."""
MIN_ROUNDED = 50
"""Rows from which on a rate can be taken from rounded times."""
MAX_RATE_ERROR = 1e-3
"""Share by which such a rate may be off: the standard error of the line through evenly rounded times."""
_SPELLINGS = {"s": "s sec secs second seconds sek", "ms": "ms msec millisecond milliseconds", "us": "us µs μs usec",
              "ns": "ns nsec"}  # fmt: skip


def seconds_of(cells: Sequence[str] | Floats, title: str, unit_cell: str, unit: str | None) -> tuple[Floats, list[str]]:
    """Times in seconds, and notes for the user; NaN for a cell that is no time.

    unit: as the layout says; None: as the column's title or its row of units says; else seconds, or the one unit in
    which the rate is one of a machine's vibration where it is none in seconds.
    """
    values = np.array([_time(str(cell)) for cell in cells], float)
    if unit is not None:
        return values * PER_SECOND[unit], []
    found = _stated(title) or _stated(f"({unit_cell.strip('()[]')})")
    if found is not None:
        return values * PER_SECOND[found], []
    span = values[-1] - values[0]
    rate = (len(values) - 1) / span if span > 0.0 else np.nan
    if not 0.0 < rate < SLOW_HZ:
        return values, []
    fitting = [one for one, size in PER_SECOND.items() if SLOW_HZ <= rate / size <= FAST_HZ]
    if len(fitting) != 1:
        return values, []
    note = f"its times are taken as {fitting[0]}: as seconds it would be sampled at {rate:.3g} Hz; state time_unit"
    return values * PER_SECOND[fitting[0]], [note]


def _stated(text: str) -> str | None:
    """The unit in brackets, or behind an underscore, at the end of a title."""
    found = re.search(r"[(\[{]\s*([^)\]}]*?)\s*[)\]}]\s*$|_([a-zµμ]+)\s*$", text.casefold())
    if found is None:
        return None
    word = found.group(1) if found.group(1) is not None else found.group(2)
    return next((unit for unit, spellings in _SPELLINGS.items() if word in spellings.split()), None)


def is_date(cell: str) -> bool:
    """Whether a cell is a date with time of day, or a time of day, and no plain number."""
    return ":" in cell and not np.isnan(_time(cell))


def _time(cell: str) -> float:
    """A number, a date with time of day, or a time of day, in seconds."""
    try:
        return float(cell)
    except ValueError:
        pass
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        pass
    try:
        moment = datetime.fromisoformat(cell.replace("/", "-"))
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    except ValueError:
        pass
    if found := re.match(r"^(?:.*[ T])?(\d{1,2}):(\d\d):(\d\d)(?:[.,:](\d+))?$", cell):
        hours, minutes, seconds, fraction = found.groups()
        return int(hours) * 3600.0 + int(minutes) * 60.0 + int(seconds) + float(f"0.{fraction or 0}")
    return float("nan")


def on_grid(path: str, seconds: Floats, columns: dict[str, Floats]) -> tuple[float, dict[str, Floats], list[str]]:
    """Sample rate, Hz, and the columns on an even grid of time, where moments that are lacking are NaN; and notes.

    Raises `UnreadableFile` for times that do not increase, or not evenly.
    """
    steps = np.diff(seconds)
    finite = bool(np.isfinite(seconds).all())
    if finite and (steps <= 0.0).any() and (rate := _rounded(seconds)) is not None:
        return rate, columns, [f"its times are rounded; the rate {rate:.6g} Hz is that of the whole file"]
    if not finite or not (steps > 0.0).all():
        good = np.isfinite(seconds[1:]) & (steps > 0.0)
        bad = int(np.argmin(np.append(good, False))) if np.isfinite(seconds[0]) else -1
        raise UnreadableFile(
            f"row {bad + 2} has the time {seconds[bad + 1]}, not after the row before: if its times are rounded, state "
            "sample_rate_hz and leave `time` out of the layout; else sort the rows",
            path=path,
        )
    whole = np.round(steps / np.median(steps))
    places = np.concatenate([[0.0], np.cumsum(whole)])
    count = places[-1] + 1.0
    step = (seconds[-1] - seconds[0]) / max(places[-1], 1.0)
    off = np.abs(seconds - seconds[0] - places * step).max() / step
    if whole.min() < 1.0 or off > OFF_TIME or count > len(seconds) * (1.0 + MAX_FILLED):
        rate = _rounded(seconds)
        if rate is not None:
            return rate, columns, [f"its times are rounded; the rate {rate:.6g} Hz is that of the whole file"]
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
    return float(1.0 / step), spread, []


def _rounded(seconds: Floats) -> float | None:
    """The rate of rows whose times are rounded coarser than a sample; None where they are off by more than that.

    A straight line through them must leave each within one step of the rounding.
    """
    steps = np.diff(seconds)
    positive = steps[steps > 0.0]
    if len(seconds) < MIN_ROUNDED or (steps < 0.0).any() or not positive.size:
        return None
    quantum = float(positive.min())
    rows = np.arange(len(seconds), dtype=float)
    middle = rows - rows.mean()
    step = float((middle * (seconds - seconds.mean())).sum() / (middle * middle).sum())
    off = np.abs(seconds - seconds.mean() - step * middle).max()
    grain = np.abs(steps / quantum - np.round(steps / quantum)).max()
    if step <= 0.0 or off > 1.01 * quantum or grain > 0.01 or step > 2.0 * quantum:
        return None
    if quantum > MAX_RATE_ERROR * step * len(seconds) ** 1.5:
        return None
    return 1.0 / step
