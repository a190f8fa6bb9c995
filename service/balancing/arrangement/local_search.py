"""Improve arrangements by swaps: a first answer, and the answer where there are too many arrangements to prove one.

Many starts are improved at once by the best swap of two slots, until no swap helps. The best of them is then improved
by two disjoint swaps at once, found by joining the list of swaps with itself. All numbers of `Slots`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from service.balancing.arrangement.exact.near_pairs import Table, near_pairs
from service.balancing.arrangement.exact.region import Axes
from service.balancing.arrangement.exact.slots import Slots
from service.balancing.arrangement.rating import violations
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.objectives import norm_of
from service.balancing.selection.problem import Objective

CELLS = 30_000
"""Swaps that are rated in one step."""
MAX_STARTS = 64
MAX_OFFERED = 500
"""Pairs of swaps of one step that are looked at closely: all their parts are written down."""
MAX_NUMBERS = 400_000
"""Parts that are written down in one step to see which swaps keep the limits; of more swaps a random choice."""
KICKS = 4
"""Random swaps between two descents of the best so far."""
BIG = 1e30
"""Value of a swap that is not allowed."""


@dataclass(frozen=True)
class Found:
    """One arrangement as parts (M,) in the slots: how far it breaks the limits, and its value."""

    slotted: IntArray
    violation: float
    value: float

    def better_than(self, other: Found | None) -> bool:
        """Whether it breaks the limits less, or keeps them as well with a smaller value."""
        return other is None or (self.violation, self.value) < (other.violation, other.value)


class LocalSearch:
    """Iterator over the best arrangement so far; it does not end by itself. Steps take some ten milliseconds."""

    def __init__(self, slots: Slots, axes: Axes, rng: np.random.Generator) -> None:
        self._slots, self._axes, self._rng = slots, axes, rng
        self._index = np.arange(slots.size)
        self._limited = slots.problem.limited
        count = len(slots.offset)
        self._objective = Objective(np.zeros((count, 0), dtype=np.complex128), slots.offset, np.ones(count), slots.norm)
        self.evaluations = 0
        self.best: Found | None = None

    def offer(self, slotted: IntArray) -> None:
        """Take arrangements (n, M) as candidates for the best."""
        if not len(slotted):
            return
        over, value = self._violation(slotted), self._value(self._residual(slotted))
        self.evaluations += len(slotted)
        first = int(np.lexsort((value, over))[0])
        found = Found(slotted[first], float(over[first]), float(value[first]))
        if found.better_than(self.best):
            self.best = found

    def run(self, starts: IntArray) -> Iterator[None]:
        """Improve `starts` (n, M) and random ones, then the best of them again and again."""
        self.offer(starts)
        count = int(np.clip(CELLS // max(self._slots.size**2, 1), 1, MAX_STARTS))
        kicked = np.repeat(starts[:1], max(count - len(starts), 0), axis=0)
        yield from self._descend(np.concatenate([starts[:count], self._kicked(kicked, 3 * self._slots.size)]))
        while True:
            yield from self._two_swaps()
            best = starts[:1] if self.best is None else self.best.slotted[None, :]
            kicked = np.repeat(best, count, axis=0)
            half = count // 2
            yield from self._descend(
                np.concatenate([self._kicked(kicked[half:], KICKS), self._kicked(kicked[:half], 3 * self._slots.size)])
            )

    def _residual(self, slotted: IntArray) -> ComplexArray:
        return np.asarray(self._slots.offset + self._slots.effects[slotted, self._index].sum(axis=1))

    def _value(self, r: ComplexArray) -> FloatArray:
        return norm_of(self._objective, r)

    def _violation(self, slotted: IntArray) -> FloatArray:
        if not self._limited:
            return np.zeros(len(slotted))
        return violations(self._slots.problem, self._slots.arrangements(slotted))

    def _kicked(self, slotted: IntArray, swaps: int) -> IntArray:
        """Random allowed swaps of each row."""
        out = slotted.copy()
        rows = np.arange(len(out))
        for _ in range(swaps):
            x, y = self._rng.integers(self._slots.size, size=(2, len(out)))
            a, b = out[rows, x], out[rows, y]
            fits = self._slots.allowed[a, y] & self._slots.allowed[b, x]
            out[rows[fits], x[fits]], out[rows[fits], y[fits]] = b[fits], a[fits]
        return out

    def _descend(self, slotted: IntArray) -> Iterator[None]:
        """Best swaps of all rows until none helps."""
        rows = slotted
        while len(rows):
            before = self._violation(rows)
            value = self._value(self._residual(rows))
            rated = self._swaps(rows, value, before)
            flat = rated.reshape(len(rows), -1)
            pick = flat.argmin(axis=1)
            better = flat[np.arange(len(rows)), pick] < 0.0
            x, y = np.divmod(pick, self._slots.size)
            moved = rows.copy()
            at = np.arange(len(rows))
            moved[at, x], moved[at, y] = rows[at, y], rows[at, x]
            self.offer(rows[~better] if (~better).any() else moved)
            rows = moved[better]
            yield

    def _swaps(self, rows: IntArray, value: FloatArray, before: FloatArray) -> FloatArray:
        """How much (n, M, M) each swap makes better, negative, and by how many broken limits first."""
        slots = self._slots
        here = slots.effects[rows]
        own = here[:, self._index, self._index]
        delta = here + here.transpose(0, 2, 1, 3) - own[:, :, None] - own[:, None, :]
        r = self._residual(rows)[:, None, None, :] + delta
        rated = self._value(r) - value[:, None, None]
        self.evaluations += rated.size
        fits = slots.allowed[rows]
        allowed = fits & fits.transpose(0, 2, 1) & np.triu(np.ones((slots.size, slots.size), dtype=np.bool_), 1)
        rated = np.where(allowed, rated, BIG)
        if self._limited:
            n, x, y = np.nonzero(allowed)
            most = max(MAX_NUMBERS // slots.size, 1)
            if len(n) > most:
                some = self._rng.choice(len(n), most, replace=False)
                n, x, y = n[some], x[some], y[some]
                looked_at = np.full_like(rated, BIG)
                looked_at[n, x, y] = rated[n, x, y]
                rated = looked_at
            swapped = rows[n]
            at = np.arange(len(n))
            swapped[at, x], swapped[at, y] = rows[n, y], rows[n, x]
            rated[n, x, y] += (self._violation(swapped) - before[n]) * (1.0 + float(np.abs(value).max())) * 1e3
        return rated

    def _two_swaps(self) -> Iterator[None]:
        """Two disjoint swaps of the best at once, as long as they make it better."""
        while self.best is not None and self.best.violation <= 0.0:
            best = self.best
            slots = self._slots
            x, y = np.triu_indices(slots.size, 1)
            a = best.slotted
            fits = slots.allowed[a[x], y] & slots.allowed[a[y], x]
            x, y = x[fits], y[fits]
            own = slots.effects[a, self._index]
            delta = slots.effects[a[x], y] + slots.effects[a[y], x] - own[x] - own[y]
            at = self._axes.coordinates(delta)
            residual = self._residual(a[None, :])
            start = self._axes.coordinates(residual)
            group = np.zeros(len(x), dtype=np.int64)
            for i, j in near_pairs(Table(group, at + start), Table(group, at), *self._axes.box(best.value)):
                apart = (i < j) & (x[i] != x[j]) & (x[i] != y[j]) & (y[i] != x[j]) & (y[i] != y[j])
                i, j = self._least(residual + delta[i[apart]] + delta[j[apart]], i[apart], j[apart])
                self._offer_swaps(best, (x[i], y[i]), (x[j], y[j]))
                yield
            if self.best is best:
                return

    def _least(self, r: ComplexArray, i: IntArray, j: IntArray) -> tuple[IntArray, IntArray]:
        """Of pairs (n,) with the residual r (n, S) those of the least value, `MAX_OFFERED` at most."""
        if len(i) <= MAX_OFFERED:
            return i, j
        least = np.argpartition(self._value(r), MAX_OFFERED)[:MAX_OFFERED]
        return i[least], j[least]

    def _offer_swaps(self, best: Found, one: tuple[IntArray, IntArray], two: tuple[IntArray, IntArray]) -> None:
        rows = np.repeat(best.slotted[None, :], len(one[0]), axis=0)
        at = np.arange(len(rows))
        for x, y in (one, two):
            held = rows[at, x].copy()
            rows[at, x] = rows[at, y]
            rows[at, y] = held
        self.offer(rows)
