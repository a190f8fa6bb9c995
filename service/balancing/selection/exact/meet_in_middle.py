"""Meet in the middle: split a plane's selections into a table and rests that are looked up in it.

Placements stand in a fixed order, cut in two at the pivot. Of a selection of n pieces, in order, the first n - t are
all below the pivot or the last n - t are all above it, as long as n <= 2 t + 1. So with a table of all selections of up
to t pieces, it is enough to ask for those rests that lie on one side of the pivot: a small part of all of them. Where
many pieces sit in few positions, the parts are even and odd positions instead.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.balancing.selection.compiled import Loops, loops
from service.balancing.selection.exact.plane_table import Ellipse, Reading, Table, length2, table_of
from service.balancing.selection.exact.subsets import Placements, Sums, gathered, levels_of, many_of
from service.balancing.selection.problem import BoolArray

ASKED = 40_000
"""Rests that are looked for at a time."""
LOOKED_AT = 60_000
"""Points that are looked at between two stops."""
LARGEST_TABLE = 150_000_000
"""Bytes of one plane's table without its grid."""
COMPILED_LOOKS = 200_000
"""Rests and points that the compiled loop looks at between two stops."""
WORTH_COMPILING = 20_000
"""Rests from which the compiled loop is quicker."""
SHORT_TABLE = 10_000
"""Entries of a table that take less time to list than the rests which it saves."""

Side = Literal["whole", "low", "high", "apart"]


@dataclass(frozen=True)
class Rests:
    """Selections of `size` pieces to be asked of the table: each of index (n, w) with each of `grow` from `begin` (n,).

    side: which of the pairs make a selection the one way that counts.
    """

    side: Side
    size: int
    index: IntArray
    vector: ComplexArray
    begin: IntArray
    grow: IntArray

    @property
    def many(self) -> int:
        """How many there are."""
        return int((len(self.grow) - self.begin).sum())


@dataclass(frozen=True)
class Split:
    """Table and rests that make every selection of up to `most` pieces once. pivot: greatest placement below it."""

    placements: Placements
    table: Table
    rests: tuple[Rests, ...]
    pivot: int
    most: int

    @property
    def width(self) -> int:
        """Columns of a selection's index."""
        return int(self.table.index.shape[1]) + 1 + max(int(rests.index.shape[1]) for rests in self.rests)

    @property
    def asked(self) -> int:
        """How many rests are looked for."""
        return sum(rests.many for rests in self.rests)

    @property
    def selections(self) -> float:
        """About how many selections they make."""
        return min(many_of(self.placements, None, self.most), float(self.asked) * float(len(self.table.vector)))

    def moments(self) -> tuple[complex, float]:
        """About the mean and the variance (of a component) of all sums: those of a part, as many pieces as it takes."""
        apart = self.rests[0].side == "apart"
        parts = [self.table.vector, self.rests[0].vector] if apart else [self.table.vector]
        some = [v[:: 1 + len(v) // 100_000] for v in parts]
        share = 1.0 if apart else self.most / max(self.table.index.shape[1], 1)
        variance = sum(float(v.real.var() + v.imag.var()) / 2.0 for v in some)
        return share * sum(complex(v.mean()) for v in some), share * variance


def entry_bytes(pieces: int) -> int:
    """Memory of a table's entry."""
    return 16 + 2 * pieces


def depth_of(placements: Placements, most: int) -> int:
    """Pieces t of the table for selections of up to `most`; 0 where even the shorter halves are too many."""
    longer, shorter = (most + 1) // 2, max(most // 2, 1)
    if many_of(placements, None, longer) <= SHORT_TABLE:
        return longer
    return shorter if many_of(placements, None, shorter) * entry_bytes(shorter) <= LARGEST_TABLE else 0


def cost_of(placements: Placements, most: int) -> float:
    """About how many rests have to be asked for selections of up to `most`; infinite where the table grows too long."""
    if _apart(placements, most):
        return max(many_of(placements, parity, most) for parity in (0, 1))
    depth = depth_of(placements, most)
    side = placements.none / 2.0
    return 2.0 * math.comb(int(side) + most - depth, most - depth) if depth else math.inf


def _apart(placements: Placements, most: int) -> bool:
    """Whether even and odd positions make the shorter parts; one piece has no other part to be met with."""
    longer = max(many_of(placements, parity, most) for parity in (0, 1)) if most > 1 else math.inf
    return longer * entry_bytes(most) <= LARGEST_TABLE and longer < many_of(placements, None, max(most // 2, 1))


def split_of(placements: Placements, most: int, known: Table | None = None) -> Generator[None, None, Split | None]:
    """Split selections of up to `most` pieces; yields now and then, for a stop. None where its table grows too long.

    known: the table of the same plane for fewer pieces, which may do again.
    """
    if _apart(placements, most):
        return (yield from _by_position(placements, most))
    depth = depth_of(placements, most)
    if not depth:
        return None
    table = known
    if table is None or table.index.shape[1] != depth:
        levels = yield from levels_of(placements, np.arange(placements.none), depth)
        everything = yield from gathered(placements, levels, depth)
        del levels
        table = yield from table_of(everything.index, everything.vector)
    full = bool((table.index[:, -1] != placements.none).any())
    nothing = _alone(placements, Sums(np.empty((1, 0), np.int64), np.zeros(1, np.complex128)), "whole")
    rests = [nothing]
    pivot = placements.none // 2 - 1
    for side, subset in (("low", np.arange(pivot + 1)), ("high", np.arange(pivot + 1, placements.none))):
        deepest = most - depth if full else 0
        parents = yield from levels_of(placements, subset, deepest - 1)
        for size, level in enumerate(parents[: max(deepest, 0)], start=1):
            if len(level):
                rests.append((yield from _grown(placements, level, size, subset, "low" if side == "low" else "high")))
    return Split(placements, table, tuple(rests), pivot, most)


def _by_position(placements: Placements, most: int) -> Generator[None, None, Split]:
    """Even positions asked, odd positions in the table, each with any number of pieces up to the limit."""
    parts = []
    for parity in (0, 1):
        mine = np.flatnonzero(placements.position[:-1] % 2 == parity)
        levels = yield from levels_of(placements, mine, most)
        parts.append((yield from gathered(placements, levels, len(levels) - 1)))
    asked, kept = sorted(parts, key=len)
    table = yield from table_of(kept.index, kept.vector)
    return Split(placements, table, (_alone(placements, asked, "apart"),), -1, most)


def _alone(placements: Placements, sums: Sums, side: Side) -> Rests:
    """Rests that are listed as they are."""
    return Rests(side, 0, sums.index, sums.vector, np.zeros(len(sums), np.int64), np.array([placements.none]))


def _grown(
    placements: Placements, level: IntArray, size: int, subset: IntArray, side: Side
) -> Generator[None, None, Rests]:
    sums = yield from gathered(placements, [level], level.shape[1])
    begin = np.zeros(len(level), dtype=np.int64)
    if level.shape[1]:
        begin = np.searchsorted(subset, level[:, -1])
        yield
    return Rests(side, size, sums.index, sums.vector, begin, subset)


def near(split: Split, ellipse: Ellipse) -> Generator[Sums, None, None]:
    """Find the selections whose sum lies in the ellipse, in chunks. A chunk may be empty: a moment at which to stop."""
    reading = Reading.of(ellipse, split.table.margin)
    compiled = loops() if split.asked > WORTH_COMPILING else None
    for rests in split.rests:
        met = (
            _met(split, rests, ellipse, reading)
            if compiled is None
            else _met_by(compiled, split, rests, ellipse, reading)
        )
        for parent, grown, point in met:
            yield _joined(split, rests, parent, grown, point)


def _met(
    split: Split, rests: Rests, ellipse: Ellipse, reading: Reading
) -> Generator[tuple[IntArray, IntArray, IntArray], None, None]:
    """Parents, pieces they are grown by, and points of the table, whose sum lies in the ellipse."""
    table, vector = split.table, split.placements.vector
    ends = np.cumsum(len(rests.grow) - rests.begin)
    total = int(ends[-1]) if len(ends) else 0
    for cut in range(0, total, ASKED):
        child = np.arange(cut, min(cut + ASKED, total))
        parent = np.searchsorted(ends, child, side="right")
        grown = rests.grow[child - ends[parent] + len(rests.grow)]
        wanted = ellipse.centre - rests.vector[parent] - vector[grown]
        whose, begin, end = table.windows(wanted, reading)
        for some, point in _points(begin, end):
            asked = whose[some]
            away = table.vector[point] - wanted[asked]
            inside = length2(ellipse.turn, away) <= ellipse.radius**2
            asked = asked[inside]
            yield parent[asked], grown[asked], point[inside]


def _met_by(
    compiled: Loops, split: Split, rests: Rests, ellipse: Ellipse, reading: Reading
) -> Generator[tuple[IntArray, IntArray, IntArray], None, None]:
    """Find the same as `_met`, by the compiled loop."""
    table = split.table
    parent, child = 0, 0
    while parent < len(rests.vector):
        parents, children, points, parent, child = compiled.met(
            rests.vector,
            rests.begin,
            rests.grow,
            split.placements.vector[rests.grow],
            parent,
            child,
            COMPILED_LOOKS,
            complex(ellipse.centre),
            reading.half_x,
            reading.slope,
            reading.half_y,
            ellipse.turn,
            ellipse.radius**2,
            complex(table.low),
            float(table.width),
            table.columns,
            table.rows,
            table.start,
            table.vector,
        )
        yield parents, rests.grow[children], points


def _points(begin: IntArray, end: IntArray) -> Generator[tuple[IntArray, IntArray], None, None]:
    """Window and point of everything in the windows, about `LOOKED_AT` at a time; at least one chunk."""
    many = end - begin
    ends = np.cumsum(many)
    start = 0
    while start < len(many):
        done = int(ends[start - 1]) if start else 0
        stop = max(int(np.searchsorted(ends, done + LOOKED_AT, side="right")), start + 1)
        here = many[start:stop]
        window = np.repeat(np.arange(start, stop), here)
        yield window, begin[window] + np.arange(len(window)) - np.repeat(ends[start:stop] - here - done, here)
        start = stop
    if not len(many):
        yield np.empty(0, np.int64), np.empty(0, np.int64)


def _joined(split: Split, rests: Rests, parent: IntArray, grown: IntArray, point: IntArray) -> Sums:
    """Pairs that make a selection the one way that counts, and keep every limit."""
    table, placements = split.table, split.placements
    once = _counts(split, rests, parent, grown, table.index[point])
    parent, grown, point = parent[once], grown[once], point[once]
    index = np.full((len(parent), split.width), placements.none, dtype=table.index.dtype)
    wide = rests.index.shape[1]
    index[:, :wide], index[:, wide] = rests.index[parent], grown
    index[:, wide + 1 : wide + 1 + table.index.shape[1]] = table.index[point]
    fits = placements.allowed(index)
    vector = rests.vector[parent] + placements.vector[grown] + table.vector[point]
    return Sums(index[fits], vector[fits])


def _counts(split: Split, rests: Rests, parent: IntArray, grown: IntArray, other: IntArray) -> BoolArray:
    none, depth = split.placements.none, other.shape[1]
    if rests.side in ("whole", "apart"):
        pieces = (rests.index[parent] != none).sum(axis=1) + (other != none).sum(axis=1)
        return np.asarray(pieces <= split.most, dtype=np.bool_)
    once = other[:, -1] != none
    if rests.side == "low":
        return np.asarray(once & (other[:, 0] >= grown), dtype=np.bool_)
    first = rests.index[parent, 0] if rests.index.shape[1] else grown
    once &= other[:, -1] <= first
    return np.asarray(once & (other[:, rests.size - 1] > split.pivot) if rests.size <= depth else once, dtype=np.bool_)
