"""Vector sums of one plane in a grid: those within an ellipse are read off a few rows of cells.

The grid is laid once, whatever ellipses are asked for later. Points of one cell stand together, cells of one column
follow each other, so that what an ellipse touches of a column is one slice.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray

SLAB = 75_000
"""Points that are sorted at a time."""
CELLS_A_POINT = 4
MAX_CELLS = 16_000_000
"""Cells of a grid: 64 MB."""
ROUNDING = 1e-13
"""Part of the extent by which what is asked for is widened, so that rounding loses no point."""


@dataclass(frozen=True)
class Ellipse:
    """All z with |turn (z - centre)| <= radius; turn (2, 2) real, upper triangular."""

    centre: complex
    turn: FloatArray
    radius: float

    def distance(self, z: ComplexArray) -> FloatArray:
        """|turn (z - centre)| of each z (n,)."""
        return np.asarray(np.sqrt(length2(self.turn, z - self.centre)), dtype=np.float64)


@dataclass(frozen=True)
class Reading:
    """Ellipses as they are looked for: half extent in x, slope of the middle line y(x), and half extent about it.

    One for all, or (m,) for each of them.
    """

    half_x: float | FloatArray
    slope: float | FloatArray
    half_y: float | FloatArray

    @classmethod
    def of(cls, ellipse: Ellipse, margin: float) -> Reading:
        """Bounds of the ellipse, widened by `margin`."""
        form = ellipse.turn.T @ ellipse.turn
        spread = np.linalg.inv(form)
        return cls(
            half_x=ellipse.radius * math.sqrt(spread[0, 0]) * (1.0 + 1e-9) + margin,
            slope=float(spread[0, 1] / spread[0, 0]),
            half_y=ellipse.radius / math.sqrt(form[1, 1]) * (1.0 + 1e-9) + margin,
        )

    def taken(self, whose: IntArray) -> Reading:
        """The same of those ellipses that are named, where each is its own."""
        if isinstance(self.half_x, float):
            return self
        return Reading(*(np.asarray(part)[whose] for part in (self.half_x, self.slope, self.half_y)))


@dataclass(frozen=True)
class Table:
    """n selections of one plane by cell.

    index: (n, k) placements, ascending, filled up with "no piece". vector: (n,) sums, g. start: (columns * rows + 1,)
    first point of each cell. low, width: corner and side of the cells.
    """

    index: IntArray
    vector: ComplexArray
    start: NDArray[np.int32]
    low: complex
    width: float
    columns: int
    rows: int

    @property
    def margin(self) -> float:
        """What rounding may move a point by."""
        return ROUNDING * (self.width * (self.columns + self.rows) + abs(self.low))

    def windows(self, wanted: ComplexArray, reading: Reading) -> tuple[IntArray, IntArray, IntArray]:
        """Slices [begin, end) of points that ellipses about `wanted` (m,) touch, and whose they are; none is empty."""
        x, y = wanted.real - self.low.real, wanted.imag - self.low.imag
        first = np.maximum(np.floor((x - reading.half_x) / self.width), 0.0)
        last = np.minimum(np.floor((x + reading.half_x) / self.width), self.columns - 1.0)
        many = np.maximum(last - first + 1.0, 0.0)
        lean = np.abs(reading.slope) * reading.half_x + reading.half_y
        many[(y + lean < 0.0) | (y - lean > self.width * self.rows)] = 0.0
        whose = np.repeat(np.arange(len(wanted)), many.astype(np.int64))
        column = first[whose] + (np.arange(len(whose)) - np.repeat(np.cumsum(many) - many, many.astype(np.int64)))
        left = column * self.width - x[whose]
        reading = reading.taken(whose)
        one = reading.slope * np.maximum(left, -reading.half_x)
        other = reading.slope * np.minimum(left + self.width, reading.half_x)
        at = y[whose]
        bottom = np.floor((at + np.minimum(one, other) - reading.half_y) / self.width)
        top = np.floor((at + np.maximum(one, other) + reading.half_y) / self.width)
        touched = np.flatnonzero((bottom < self.rows) & (top >= 0.0))
        base = column[touched].astype(np.int64) * self.rows
        begin = self.start[base + np.maximum(bottom[touched], 0.0).astype(np.int64)]
        end = self.start[base + np.minimum(top[touched], self.rows - 1.0).astype(np.int64) + 1]
        some = np.flatnonzero(end > begin)
        return whose[touched[some]], begin[some].astype(np.int64), end[some].astype(np.int64)


def length2(turn: FloatArray, z: ComplexArray) -> FloatArray:
    """|turn z|^2 of each z (n,)."""
    x = turn[0, 0] * z.real + turn[0, 1] * z.imag
    y = turn[1, 0] * z.real + turn[1, 1] * z.imag
    return np.asarray(x * x + y * y, dtype=np.float64)


def table_of(index: IntArray, vector: ComplexArray) -> Generator[None, None, Table]:
    """Lay the selections index (n, k), vector (n,) in a grid; yields now and then, for a stop."""
    low = complex(vector.real.min(), vector.imag.min())
    extent = complex(vector.real.max(), vector.imag.max()) - low
    cells = min(CELLS_A_POINT * len(vector), MAX_CELLS)
    longest = max(extent.real, extent.imag, 1e-150)
    width = max(math.sqrt(extent.real * extent.imag / cells), longest / cells) * (1.0 + 1e-9)
    columns, rows = (int(side / width) + 1 for side in (extent.real, extent.imag))
    cell = np.empty(len(vector), dtype=np.int32)
    for cut in range(0, len(vector), SLAB):
        part = vector[cut : cut + SLAB]
        column, row = (np.floor(v / width) for v in (part.real - low.real, part.imag - low.imag))
        cell[cut : cut + SLAB] = np.minimum(column, columns - 1) * rows + np.minimum(row, rows - 1)
        yield
    start = np.empty(columns * rows + 1, dtype=np.int32)
    out_index, out_vector = np.empty_like(index), np.empty_like(vector)
    done = 0
    edges = _edges(cell, columns * rows)
    for first, last in pairwise(edges):
        mine = np.flatnonzero((cell >= first) & (cell < last))
        yield
        order = mine[np.argsort(cell[mine], kind="stable")]
        yield
        for cut in range(0, len(order), SLAB):
            some = order[cut : cut + SLAB]
            out_index[done : done + len(some)], out_vector[done : done + len(some)] = index[some], vector[some]
            done += len(some)
            yield
        begin = done - len(order)
        start[first:last] = begin + np.searchsorted(cell[order], np.arange(first, last))
        yield
    start[-1] = done
    return Table(out_index, out_vector, start, low, width, columns, rows)


def _edges(cell: NDArray[np.int32], cells: int) -> list[int]:
    """Ranges of cells with about `SLAB` points each."""
    slabs = max(1, math.ceil(len(cell) / SLAB))
    inner = np.quantile(cell[::slabs], np.arange(1, slabs) / slabs).tolist()
    return [0, *sorted({int(edge) for edge in inner if 1 <= edge < cells}), cells]
