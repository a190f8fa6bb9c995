"""All pairs (query, point) in the plane that are nearer than a query's own radius, found column by column.

Points are sorted by column of width `width` and within a column by ordinate, as one key; a query reads the few
columns that it touches. Large searches come in chunks, so that a caller can stop between them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray

CHUNK = 60_000
"""Pairs looked at between two stops: ten or twenty milliseconds with what callers do with them."""

ROUNDING = 1e-13
"""Part of the greatest key by which windows are widened, so that rounding loses no pair."""


class Columns:
    """Points (n,) of the complex plane, sorted for searches of radius up to about `radius`."""

    def __init__(self, points: ComplexArray, radius: float) -> None:
        self.points = points
        low = complex(points.real.min(), points.imag.min()) if len(points) else 0j
        high = complex(points.real.max(), points.imag.max()) if len(points) else 0j
        extent = max((high - low).real, (high - low).imag, 1e-150)
        self._low = low
        self._width = max(3.0 * radius, extent / max(np.sqrt(len(points)), 1.0))
        self._stride = 4.0 * (extent + radius)
        columns = np.floor((points.real - low.real) / self._width)
        key = columns * self._stride + (points.imag - low.imag)
        self._order = np.argsort(key, kind="stable")
        self._key = np.append(key[self._order], np.inf)  # an end that every window stops at
        self._last = float(columns.max()) if len(points) else -1.0

    def pairs(self, queries: ComplexArray, radii: FloatArray) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield chunks of (query, point) indices with |query - point| <= radius of the query; a chunk may be empty."""
        if len(self.points) == 0 or len(queries) == 0:
            return
        query, low, high = self._windows(queries, radii)
        many = high - low
        ends = np.cumsum(many)
        total = int(ends[-1]) if len(ends) else 0
        start = 0
        while start < len(many):
            done = int(ends[start - 1]) if start else 0
            stop = max(int(np.searchsorted(ends, done + CHUNK, side="right")), start + 1)
            here = many[start:stop]
            of = np.repeat(np.arange(start, stop), here)
            offset = np.arange(len(of)) - np.repeat(ends[start:stop] - here - done, here)
            point = self._order[low[of] + offset]
            asked = query[of]
            near = np.abs(queries[asked] - self.points[point]) <= radii[asked]
            yield asked[near], point[near]
            start = stop
        if total == 0:
            yield np.empty(0, np.int64), np.empty(0, np.int64)

    def _windows(self, queries: ComplexArray, radii: FloatArray) -> tuple[IntArray, IntArray, IntArray]:
        """Query of each window, and its range in the sorted keys, empty windows left out."""
        x, y = queries.real - self._low.real, queries.imag - self._low.imag
        radii = radii + ROUNDING * self._stride * (self._last + 1.0)
        first = np.maximum(np.floor((x - radii) / self._width), 0.0)
        last = np.minimum(np.floor((x + radii) / self._width), self._last)
        columns = np.maximum(last - first + 1.0, 0.0).astype(np.int64)
        inside = (y + radii >= 0.0) & (y - radii <= self._stride / 4.0)
        columns[~inside] = 0
        query = np.repeat(np.arange(len(queries)), columns)
        step = np.arange(len(query)) - np.repeat(np.cumsum(columns) - columns, columns)
        base = (first[query] + step) * self._stride
        at, reach = y[query], radii[query]
        low = self._key.searchsorted(base + np.maximum(at - reach, -0.25 * self._stride), side="left")
        upper = base + np.minimum(at + reach, 0.5 * self._stride)
        # Most windows of a small radius are empty: their upper end need not be looked for.
        some = np.flatnonzero(self._key[low] <= upper)
        return query[some], low[some], self._key.searchsorted(upper[some], side="right")
