"""The two inner loops of the search that pay for a compiler (numba, the extra `fast`); numpy does the same without it.

Loading takes a second, compiling for the first time some more, so nothing here happens by itself: `load` is called
before a long computation, and until then, or where numba is missing, `loops()` is None
(docs/decisions/compiled-search.md).
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

NORMS = {"sum": 0, "max": 1, "rms": 2, "components": 3}
_TIE = 1e-9
_MAX_LISTED = 4096


@dataclass(frozen=True)
class Loops:
    """Compiled functions. met: see `_met`. pairs: see `_pairs`."""

    met: Callable[..., Any]
    pairs: Callable[..., Any]


_loaded: list[Loops] = []


def loops() -> Loops | None:
    """The compiled loops, where they are loaded."""
    return _loaded[0] if _loaded else None


def load() -> bool:
    """Compile the loops, or read them from the cache of an earlier time; False where numba is not installed."""
    if _loaded:
        return True
    try:
        numba: Any = importlib.import_module("numba")
    except ImportError:
        return False
    register: Any = importlib.import_module("numba.extending").register_jitable
    for helper in (_within, _value, _preferred, _supplied, _best_of):
        register(helper)
    _loaded.append(Loops(met=_compiled(numba, _met), pairs=_compiled(numba, _pairs)))
    return True


def _compiled(numba: Any, function: Callable[..., Any]) -> Callable[..., Any]:
    try:
        made: Callable[..., Any] = numba.njit(cache=True, nogil=True)(function)
    except RuntimeError:  # nowhere to keep a cache
        made = numba.njit(nogil=True)(function)
    return made


def _met(
    rest, begin, grow, grow_vector, parent, child, quota, centre, half_x, slope, half_y, turn, radius2,
    low, width, columns, rows, start, points,
):  # fmt: skip
    """Find the points of a grid that lie within an ellipse about each rest: as `meet_in_middle._met`, a part at a time.

    Begins with the rest parent, child and does about `quota` looks. Returns parents, children and points found, and the
    parent and child to go on with.
    """
    many = len(rest)
    size = 1024
    parents = np.empty(size, np.int64)
    children = np.empty(size, np.int64)
    found_points = np.empty(size, np.int64)
    found = 0
    work = 0
    while parent < many:
        if child < begin[parent]:
            child = begin[parent]
        base = centre - rest[parent]
        while child < len(grow):
            if work > quota:
                return parents[:found], children[:found], found_points[:found], parent, child
            wanted = base - grow_vector[child]
            work += 1
            x = wanted.real - low.real
            y = wanted.imag - low.imag
            first = max(math.floor((x - half_x) / width), 0)
            last = min(math.floor((x + half_x) / width), columns - 1)
            for column in range(first, last + 1):
                left = column * width - x
                one = slope * max(left, -half_x)
                other = slope * min(left + width, half_x)
                bottom = max(math.floor((y + min(one, other) - half_y) / width), 0)
                top = min(math.floor((y + max(one, other) + half_y) / width), rows - 1)
                if bottom > top:
                    continue
                for point in range(start[column * rows + bottom], start[column * rows + top + 1]):
                    work += 1
                    away = points[point] - wanted
                    u = turn[0, 0] * away.real + turn[0, 1] * away.imag
                    v = turn[1, 0] * away.real + turn[1, 1] * away.imag
                    if u * u + v * v <= radius2:
                        if found == size:
                            parents = np.concatenate((parents, np.empty(size, np.int64)))
                            children = np.concatenate((children, np.empty(size, np.int64)))
                            found_points = np.concatenate((found_points, np.empty(size, np.int64)))
                            size *= 2
                        parents[found] = parent
                        children[found] = child
                        found_points[found] = point
                        found += 1
            child += 1
        parent += 1
        child = 0
    return parents[:found], children[:found], found_points[:found], parent, 0


def _within(wanted, radius, plane, out):
    """List the rows of a plane within a disc; how many, or -1 where they are too many."""
    vector, start, low, width, columns, rows = plane
    x = wanted.real - low.real
    y = wanted.imag - low.imag
    half = radius * (1.0 + 1e-9) + 1e-13 * (width * (columns + rows) + abs(low))
    bottom = max(math.floor((y - half) / width), 0)
    top = min(math.floor((y + half) / width), rows - 1)
    many = 0
    if bottom > top:
        return many
    for column in range(max(math.floor((x - half) / width), 0), min(math.floor((x + half) / width), columns - 1) + 1):
        for row in range(start[column * rows + bottom], start[column * rows + top + 1]):
            away = vector[row] - wanted
            if away.real * away.real + away.imag * away.imag <= half * half:
                if many == len(out):
                    return -1
                out[many] = row
                many += 1
    return many


def _value(matrix, offset, weights, norm, u1, u2):
    """Objective of one pair."""
    total = 0.0
    for s in range(len(offset)):
        r = offset[s] + matrix[s, 0] * u1 + matrix[s, 1] * u2
        if norm == 3:
            total += weights[s] * (abs(r.real) + abs(r.imag))
        else:
            length = weights[s] * math.sqrt(r.real * r.real + r.imag * r.imag)
            if norm == 0:
                total += length
            elif norm == 1:
                total = max(total, length)
            else:
                total += length * length / len(offset)
    return math.sqrt(total) if norm == 2 else total


def _preferred(order1, order2, a, b, c, d):
    """Whether the pair of rows a, b comes before the pair c, d of equal value."""
    for k in range(3):
        one = order1[a, k] + order2[b, k]
        other = order1[c, k] + order2[d, k]
        if abs(one - other) > 1e-9:
            return one < other
    if order1[a, 3] != order1[c, 3]:
        return order1[a, 3] < order1[c, 3]
    return order2[b, 3] < order2[d, 3]


def _supplied(items1, items2, a, b, counts, used):
    """Whether the box can supply both rows; used (I + 1,) is zero before and after."""
    fits = True
    for k in range(items1.shape[1]):
        used[items1[a, k]] += 1
        fits = fits and used[items1[a, k]] <= counts[items1[a, k]]
    for k in range(items2.shape[1]):
        used[items2[b, k]] += 1
        fits = fits and used[items2[b, k]] <= counts[items2[b, k]]
    for k in range(items1.shape[1]):
        used[items1[a, k]] = 0
    for k in range(items2.shape[1]):
        used[items2[b, k]] = 0
    return fits


def _best_of(matrix, offset, weights, norm, lists, plane1, plane2, box, best, a0, b0):
    """Best pair of two lists of rows, against the best so far."""
    list1, many1, list2, many2 = lists
    vector1, fixed1, items1, order1 = plane1
    vector2, fixed2, items2, order2 = plane2
    counts, binds, used = box
    for i in range(many1):
        a = list1[i]
        for j in range(many2):
            b = list2[j]
            value = _value(matrix, offset, weights, norm, vector1[a] + fixed1, vector2[b] + fixed2)
            if value > best * (1.0 + _TIE):
                continue
            if value >= best * (1.0 - _TIE) and not _preferred(order1, order2, a, b, a0, b0):
                continue
            if binds and not _supplied(items1, items2, a, b, counts, used):
                continue
            best, a0, b0 = value, a, b
    return best, a0, b0


def _pairs(
    matrix, offset, weights, norm, centre, reach, first_level, step, rounds, grid1, plane1, grid2, plane2, counts, binds
):  # fmt: skip
    """Best pair of rows of two planes for each of D square problems, as `batch.solver` finds it.

    centre, reach (D, 2): where the residual is 0, less what is fixed, and how far a level of 1 lets each plane be from
    it. grid: points, start, low, width, columns, rows of a table; plane: points, fixed, items, and (n, 4) pieces, mass,
    scarcity and rank of its rows. Returns value (D,), rows (D, 2) and whether each is proved (D,).
    """
    draws = len(offset)
    value = np.full(draws, np.inf)
    rows = np.zeros((draws, 2), np.int64)
    proved = np.zeros(draws, np.bool_)
    list1, list2 = np.empty(_MAX_LISTED, np.int64), np.empty(_MAX_LISTED, np.int64)
    box = (counts, binds, np.zeros(len(counts), np.int64))
    for d in range(draws):
        level = first_level
        for _ in range(rounds):
            level = min(level, value[d] * (1.0 + 2.0 * _TIE))
            many1 = _within(centre[d, 0], level * reach[d, 0], grid1, list1)
            many2 = _within(centre[d, 1], level * reach[d, 1], grid2, list2) if many1 > 0 else 0
            if many1 < 0 or many2 < 0:
                break
            lists = (list1, many1, list2, many2)
            value[d], rows[d, 0], rows[d, 1] = _best_of(
                matrix[d], offset[d], weights, norm, lists, plane1, plane2, box, value[d], rows[d, 0], rows[d, 1]
            )
            proved[d] = value[d] <= level
            if proved[d]:
                break
            level *= step
    return value, rows, proved
