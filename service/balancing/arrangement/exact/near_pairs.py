"""Pairs of rows of two tables, in the same group, whose sum lies in a box: the join of two halves of a problem."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import FloatArray, IntArray

MAX_CELLS = 4096
"""Cells that one axis is cut into."""
MAX_PAIRS = 500_000
"""Pairs that are looked at in one step."""
WIDEN = 1e-7
"""Part of the extent of the data by which a box is widened, so that rounding of the sort key loses nothing."""


@dataclass(frozen=True)
class Table:
    """Rows (n,) with their group (n,) and real coordinates (n, d)."""

    group: IntArray
    points: FloatArray

    def __len__(self) -> int:
        return len(self.group)


def near_pairs(a: Table, b: Table, low: FloatArray, high: FloatArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield rows (i, j) of `a` and `b` of one group with low <= a[i] + b[j] <= high on every axis.

    low, high: (d,). Each pair is yielded once; every step looks at up to `MAX_PAIRS`, or one row's. Rows of `b` are
    sorted by group, cell of the most selective axis and place on the next one, so that the partners of a row of `a`
    are a few runs.
    """
    if not len(a) or not len(b):
        return
    extent = np.maximum(np.ptp(b.points, axis=0), np.ptp(a.points, axis=0))
    slack = WIDEN * extent + 1e-12
    low, high = low - slack, high + slack
    axes = np.argsort((high - low) / np.maximum(extent, 1e-300))
    first, second = int(axes[0]), int(axes[min(1, len(axes) - 1)])
    grid = _Grid.of(b, first, second, high[first] - low[first])
    order = np.argsort(grid.key)
    key = grid.key[order]
    left_cell = grid.cell(low[first] - a.points[:, first])
    right_cell = grid.cell(high[first] - a.points[:, first])
    for step in range(int((right_cell - left_cell).max()) + 1):
        rows = np.flatnonzero(left_cell + step <= right_cell)
        runs = grid.runs(key, a.group[rows], left_cell[rows] + step, a.points[rows, second], low[second], high[second])
        for i, at in _expanded(rows, *runs):
            j = order[at]
            total = a.points[i] + b.points[j]
            inside = ((total >= low) & (total <= high)).all(axis=1)
            yield i[inside], j[inside]


@dataclass(frozen=True)
class _Grid:
    """Sort key of a table: group, cell on one axis, place within 0..1 on another."""

    key: FloatArray
    cells: int
    start: float
    width: float
    least: float
    span: float

    @classmethod
    def of(cls, b: Table, first: int, second: int, window: float) -> _Grid:
        x, y = b.points[:, first], b.points[:, second]
        start, extent = float(x.min()), float(np.ptp(x))
        cells = int(np.clip(extent / max(window, 1e-300), 1, MAX_CELLS)) if extent > 0.0 else 1
        width = extent / cells if extent > 0.0 else 1.0
        least, span = float(y.min()), max(float(np.ptp(y)), 1e-300) * (1.0 + 1e-9)
        cell = np.clip(np.floor((x - start) / width), 0, cells - 1)
        return cls(b.group * cells + cell + (y - least) / span, cells, start, width, least, span)

    def cell(self, x: FloatArray) -> IntArray:
        """Cell (n,) that a coordinate falls in; the outer ones where it is outside."""
        return np.clip(np.floor((x - self.start) / self.width), 0, self.cells - 1).astype(np.int64)

    def runs(
        self, key: FloatArray, group: IntArray, cell: IntArray, y: FloatArray, low: float, high: float
    ) -> tuple[IntArray, IntArray]:
        """First and last row (n,), the last excluded, of the sorted key in this cell and window of the second axis."""
        code = (group * self.cells + cell).astype(np.float64)
        below = np.clip((low - y - self.least) / self.span, 0.0, 1.0)
        above = np.clip((high - y - self.least) / self.span, -1.0, 1.0 - 1e-12)
        # An empty window ends before it begins: below is then above 1 or above is negative.
        starts = np.searchsorted(key, code + np.minimum(below, 1.0 - 1e-12), side="left")
        ends = np.searchsorted(key, code + np.maximum(above, 0.0), side="right")
        empty = (high - y < self.least) | (low - y > self.least + self.span)
        return starts.astype(np.int64), np.where(empty, starts, np.maximum(ends, starts)).astype(np.int64)


def _expanded(rows: IntArray, starts: IntArray, ends: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Every row with every place of its run, at most `MAX_PAIRS` at once."""
    busy = np.flatnonzero(ends > starts)
    counts = (ends - starts)[busy]
    total = np.cumsum(counts)
    begin = 0
    while begin < len(busy):
        done = total[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + MAX_PAIRS, side="right")))
        here, count = busy[begin:end], counts[begin:end]
        offset = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
        yield np.repeat(rows[here], count), np.repeat(starts[here], count) + offset
        begin = end
