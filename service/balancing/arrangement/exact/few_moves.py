"""All arrangements that change at most four places, better than a level, from cycles of parts.

Three changed places and fewer are listed. Four are joined from halves (`near_pairs`): a cycle of four from two paths
between the same slots, or two changes of disjoint slots; so 112 places take as long as their listed triples.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from service.balancing.arrangement.exact.changes import Arcs, Changes, padded, pairs_of
from service.balancing.arrangement.exact.near_pairs import Table, near_pairs
from service.balancing.arrangement.exact.region import Axes
from service.balancing.arrangement.exact.slots import Slots
from service.balancing.arrangement.problem import EMPTY
from service.balancing.rotor.phasors import FloatArray, IntArray
from service.balancing.selection.problem import BoolArray

MAX_FEW = 4
"""Changed places that are searched completely."""
MAX_LISTED = 6_000_000
"""Changes of one kind that are listed."""
AT_ONCE = 200_000
"""Changes that are handed out in one step."""


def listed_changes(slots: Slots, changed: int) -> float:
    """At least the changes that a search of up to `changed` places lists."""
    real, spare = slots.open_places, slots.size - slots.open_places
    if changed <= 2:
        return float((real + spare) ** 2 + spare * real**2 + (spare * real) ** 2 / 2.0)
    swaps = real**2 / 2.0
    return max(float(real**3 * (1 + spare)), swaps * spare * real, (spare * real) ** 3 / 6.0)


@dataclass(frozen=True)
class OpenChanges:
    """Moves of the base: of fixed places, of slots whose present part cannot be had, and of others.

    The base keeps the present part wherever it can, but where several places compete for parts it keeps one of them
    (`again`): a search of m changed places must look at that many more.
    """

    fixed: int
    always: int
    again: int


def open_changes(slots: Slots) -> OpenChanges:
    """Moves that the base makes."""
    present = slots.problem.present
    fixed = int(((slots.fixed != present) & (slots.fixed != EMPTY)).sum())
    held = slots.parts[slots.base[: slots.open_places]]
    number = {int(part): k for k, part in enumerate(slots.parts)}
    differs = np.flatnonzero(held != present[slots.places])
    wanted = [(int(s), number.get(int(present[slots.places[s]]))) for s in differs]
    again = sum(part is not None and bool(slots.allowed[part, slot]) for slot, part in wanted)
    return OpenChanges(fixed, len(differs) - again, again)


def few_changes(slots: Slots, axes: Axes, changed: int, level: list[float]) -> Iterator[IntArray]:
    """Yield parts (n, M) of arrangements that change exactly `changed` slots of the base (0 to `MAX_FEW`).

    Everything that is better than `level[0]` is yielded, `level` being lowered by the caller between the steps.
    """
    if changed == 0:
        yield slots.base[None, :]
        return
    search = _Few(slots, axes, level)
    yield from search.changing(changed)


class _Few:
    """The lists of one search."""

    def __init__(self, slots: Slots, axes: Axes, level: list[float]) -> None:
        self.slots, self.axes, self.level = slots, axes, level
        self.arcs = Arcs(slots)
        own = slots.effects[slots.base, np.arange(slots.size)].sum(axis=0)
        self.start = axes.coordinates(slots.offset + own)

    def changing(self, changed: int) -> Iterator[IntArray]:
        lists = {1: self._one, 2: self._two, 3: self._three}
        if changed <= 3:
            for changes in lists[changed]():
                yield from self._handed(changes)
            return
        yield from self._cycles_of_four()
        one, two = self._list(self._one()), self._list(self._two())
        yield from self._joined(two, None)
        if len(one):
            yield from self._joined(self._list(self._three()), one)

    def _one(self) -> Iterator[Changes]:
        cycles = self.arcs.swaps()
        yield cycles.take(self._spare(cycles))

    def _two(self) -> Iterator[Changes]:
        cycles = self.arcs.swaps()
        yield cycles.take(np.logical_not(self._spare(cycles)))
        if self.slots.size > self.slots.open_places:
            for triples in self.arcs.triples():
                yield triples.take(self._spare(triples))
            yield from self._products(self._list(self._one()), None)

    def _three(self) -> Iterator[Changes]:
        for triples in self.arcs.triples():
            yield triples.take(np.logical_not(self._spare(triples)))
        if self.slots.size > self.slots.open_places:
            yield from self._spare_fours()
            one = self._list(self._one())
            yield from self._products(self._list(self._two()), one)

    def _spare(self, changes: Changes) -> BoolArray:
        return np.asarray((changes.slot >= self.slots.open_places).any(axis=1))

    def _spare_fours(self) -> Iterator[Changes]:
        """Cycles of a spare slot and three places."""
        x, y, z = self.arcs.paths()
        inside = (x < self.slots.open_places) & (y < self.slots.open_places) & (z < self.slots.open_places)
        x, y, z = x[inside], y[inside], z[inside]
        for spare in range(self.slots.open_places, self.slots.size):
            ok = self.arcs.can[spare, x]
            s = np.full(int(ok.sum()), spare)
            yield self.arcs.closed(np.stack([s, x[ok], y[ok], z[ok]], axis=1))

    def _products(self, a: Changes, b: Changes | None) -> Iterator[Changes]:
        other = a if b is None else b
        for i, j in pairs_of(len(a), None if b is None else len(b), AT_ONCE):
            yield a.with_each(i, other, j)

    def _list(self, parts: Iterator[Changes]) -> Changes:
        found = list(parts)
        width = max(part.slot.shape[1] for part in found)
        return padded(found, width)

    def _handed(self, changes: Changes) -> Iterator[IntArray]:
        """Those changes that may be better, applied to the base."""
        for begin in range(0, len(changes), AT_ONCE):
            part = changes.take(np.arange(begin, min(begin + AT_ONCE, len(changes))))
            at = self.axes.coordinates(part.delta) + self.start
            low, high = self._box()
            inside = np.flatnonzero(((at >= low) & (at <= high)).all(axis=1))
            yield part.take(inside).applied(self.slots.base)

    def _box(self) -> tuple[FloatArray, FloatArray]:
        low, high = self.axes.box(self.level[0])
        slack = 1e-9 * (np.abs(self.start) + high - low)
        return low - slack, high + slack

    def _joined(self, a: Changes, b: Changes | None) -> Iterator[IntArray]:
        """Two changes of disjoint slots; of one list where `b` is None."""
        other = a if b is None else b
        left = self._table(a, np.zeros(len(a), dtype=np.int64), self.start)
        right = self._table(other, np.zeros(len(other), dtype=np.int64), 0.0)
        for i, j in near_pairs(left, right, *self._box()):
            if b is None:
                keep = i < j
                i, j = i[keep], j[keep]
            yield a.with_each(i, other, j).applied(self.slots.base)

    def _table(self, changes: Changes, group: IntArray, start: FloatArray | float) -> Table:
        return Table(group, self.axes.coordinates(changes.delta) + start)

    def _cycles_of_four(self) -> Iterator[IntArray]:
        """Cycles of four places, and of a spare slot and four places."""
        real = self.slots.open_places
        for begin, end in self.arcs.blocks():
            yield from self._fours_from(begin, min(end, real))
        if real < self.slots.size:
            x, y, z = self.arcs.paths()
            inside = (x < real) & (y < real) & (z < real)
            for spare in range(real, self.slots.size):
                yield from self._spare_fives(spare, x[inside], y[inside], z[inside])

    def _fours_from(self, begin: int, end: int) -> Iterator[IntArray]:
        """Cycles of four places whose one half, x, y, z with x < z, begins in a range of places."""
        real = self.slots.open_places
        x, y, z = self._inside(self.arcs.paths(first=(begin, end)), upwards=True)
        v, w, u = self._inside(self.arcs.paths(last=(begin, end)), upwards=False)
        left = Table(x * real + z, self.axes.coordinates(self.arcs.path_delta(x, y, z)) + self.start)
        right = Table(u * real + v, self.axes.coordinates(self.arcs.path_delta(v, w, u)))
        for i, j in near_pairs(left, right, *self._box()):
            # x goes first in its cycle once: where it is the least of x and y too, of the two ways to cut a cycle.
            keep = (y[i] != w[j]) & (x[i] < y[i]) & (x[i] < w[j])
            p, q = i[keep], j[keep]
            yield self.arcs.closed(np.stack([x[p], y[p], z[p], w[q]], axis=1)).applied(self.slots.base)

    def _inside(
        self, path: tuple[IntArray, IntArray, IntArray], *, upwards: bool
    ) -> tuple[IntArray, IntArray, IntArray]:
        """Paths through places alone that end beyond where they begin, or before it."""
        real = self.slots.open_places
        x, y, z = path
        keep = (x < real) & (y < real) & (z < real) & ((x < z) == upwards)
        return x[keep], y[keep], z[keep]

    def _spare_fives(self, spare: int, x: IntArray, y: IntArray, z: IntArray) -> Iterator[IntArray]:
        """Cycles spare, x, y, z, w: a path spare -> x -> y and one y -> z -> w that ends there."""
        real = self.slots.open_places
        u, v = np.nonzero(self.arcs.can[:real, :real] & self.arcs.can[spare, :real, None])
        s = np.full(len(u), spare)
        left = Table(v, self.axes.coordinates(self.arcs.path_delta(s, u, v)) + self.start)
        # The part of the last place goes into the spare slot, where it does nothing but leave its place.
        right = Table(x, self.axes.coordinates(self.arcs.path_delta(x, y, z, np.full(len(x), spare))))
        for i, j in near_pairs(left, right, *self._box()):
            keep = (u[i] != y[j]) & (u[i] != z[j])
            i, j = i[keep], j[keep]
            nodes = np.stack([s[i], u[i], v[i], y[j], z[j]], axis=1)
            yield self.arcs.closed(nodes).applied(self.slots.base)
