"""Changes of an arrangement: cycles of parts through slots, listed by the number of places they change.

A change moves the base part of slot `source[i]` into slot `slot[i]`. What a part leaves another fills, so the changed
slots fall into cycles; a cycle through one spare slot brings one part in and takes one out. Cycles through several
spare slots are the same as several cycles through one each.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from service.balancing.arrangement.exact.slots import Slots
from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.balancing.selection.problem import BoolArray

AT_ONCE = 60_000
"""Paths that are listed in one step."""
NONE = -1
"""Fills up rows of changes that touch fewer slots."""


@dataclass(frozen=True)
class Changes:
    """n changes of up to w slots each: slot, source (n, w), filled up with `NONE`; delta (n, S) of the residual."""

    slot: IntArray
    source: IntArray
    delta: ComplexArray

    def __len__(self) -> int:
        return len(self.slot)

    def take(self, rows: IntArray | BoolArray) -> Changes:
        """Some of them."""
        return Changes(self.slot[rows], self.source[rows], self.delta[rows])

    def with_each(self, i: IntArray, other: Changes, j: IntArray) -> Changes:
        """Changes i of these made together with changes j of `other`, where both touch different slots."""
        a, b = self.slot[i], other.slot[j]
        apart = np.ones(len(i), dtype=np.bool_)
        for column in range(a.shape[1]):
            x = a[:, column, None]
            apart &= ~((x == b) & (x != NONE)).any(axis=1)
        i, j = i[apart], j[apart]
        return Changes(
            np.concatenate([self.slot[i], other.slot[j]], axis=1),
            np.concatenate([self.source[i], other.source[j]], axis=1),
            self.delta[i] + other.delta[j],
        )

    def applied(self, base: IntArray) -> IntArray:
        """Parts (n, M) in the slots after each change of `base` (M,)."""
        out = np.repeat(base[None, :], len(self), axis=0)
        row, column = np.nonzero(self.slot != NONE)
        out[row, self.slot[row, column]] = base[self.source[row, column]]
        return out


class Arcs:
    """Steps from slot to slot: what it changes when the base part of x goes into y, (M, M, S), nan where it cannot."""

    def __init__(self, slots: Slots) -> None:
        index = np.arange(slots.size)
        own = slots.effects[slots.base, index]
        self.real = slots.open_places
        self.size = slots.size
        self.delta = slots.effects[slots.base] - own[None, :, :]
        self.can = slots.allowed[slots.base].copy()
        np.fill_diagonal(self.can, False)
        # A part that goes from one spare slot to another changes nothing.
        self.can[self.real :, self.real :] = False

    def swaps(self) -> Changes:
        """Cycles of 2 slots, each once, at most one of them spare."""
        x, y = np.nonzero(np.triu(self.can & self.can.T, 1))
        return self.closed(np.stack([x, y], axis=1))

    def triples(self) -> Iterator[Changes]:
        """Cycles of 3 slots, each once, at most one of them spare, some at once."""
        for begin, end in self.blocks():
            x, y, z = self.paths(first=(begin, end))
            closes = self.can[z, x] & (x < y) & (x < z)
            yield self.closed(np.stack([x, y, z], axis=1)[closes])

    def paths(
        self, first: tuple[int, int] | None = None, last: tuple[int, int] | None = None
    ) -> tuple[IntArray, IntArray, IntArray]:
        """Slots x, y, z of every two steps in a row, at most one of them spare.

        first, last: range of slots that x, or z, is of; None: all.
        """
        begin, end = first or (0, self.size)
        low, high = last or (0, self.size)
        x, y = np.nonzero(self.can[begin:end])
        x = x + begin
        z = np.arange(low, high)
        ok = self.can[y][:, z] & (z[None, :] != x[:, None])
        ok &= ~((x >= self.real)[:, None] & (z >= self.real)[None, :])
        row, z = np.nonzero(ok)
        return x[row], y[row], z + low

    def blocks(self) -> Iterator[tuple[int, int]]:
        """Ranges of slots whose paths from there are `AT_ONCE` at most, or those of one slot."""
        step = max(1, AT_ONCE // max(self.size**2, 1))
        yield from ((begin, min(begin + step, self.size)) for begin in range(0, self.size, step))

    def closed(self, nodes: IntArray) -> Changes:
        """Cycles (n, w) in which the part of each slot goes into the next one's, the last one's into the first."""
        follow = np.roll(nodes, -1, axis=1)
        delta = np.zeros((len(nodes), self.delta.shape[2]), dtype=np.complex128)
        for column in range(nodes.shape[1]):
            delta += self.delta[nodes[:, column], follow[:, column]]
        return Changes(follow, nodes, delta)

    def path_delta(self, *nodes: IntArray) -> ComplexArray:
        """Sum (n, S) of the steps along paths."""
        pairs = pairwise(nodes)
        return np.asarray(sum(self.delta[a, b] for a, b in pairs), dtype=np.complex128)


def padded(parts: list[Changes], width: int) -> Changes:
    """All of them in one, filled up to the same width."""

    def wide(rows: IntArray) -> IntArray:
        return np.pad(rows, ((0, 0), (0, width - rows.shape[1])), constant_values=NONE)

    return Changes(
        np.concatenate([wide(c.slot) for c in parts]),
        np.concatenate([wide(c.source) for c in parts]),
        np.concatenate([c.delta for c in parts]),
    )


def pairs_of(count: int, other: int | None, at_once: int) -> Iterator[tuple[IntArray, IntArray]]:
    """All pairs (i, j), i < j where `other` is None, some at once."""
    begin = 0
    columns = count if other is None else other
    while begin < count:
        end = min(count, begin + max(1, at_once // max(columns, 1)))
        i, j = np.divmod(np.arange((end - begin) * columns), max(columns, 1))
        i = i + begin
        keep = i < j if other is None else slice(None)
        yield i[keep], j[keep]
        begin = end
