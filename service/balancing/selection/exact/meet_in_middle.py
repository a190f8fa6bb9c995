"""The vector sums that one plane's masses can make near a point, by meeting in the middle.

A selection of up to N pieces is the sum of two halves of up to N / 2 pieces. All halves are listed once; near a given
point, each half is paired with the halves that lie where the rest of the way ends.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.exact.neighbours import Columns
from service.balancing.selection.placements import effective_g, slots, within_g
from service.balancing.selection.problem import BoolArray, Piece, SelectionPlane, Stock

EXTEND_CHUNK = 100_000
"""Halves extended between two stops."""
SLAB = 75_000
"""Halves sorted at a time."""
ASKED = 40_000
"""Halves whose other half is looked for at a time."""
MOST_LISTED = 200
"""Pieces a plane beyond which it is not even counted how many selections there are."""
OVERSHOOT = 4
"""How many times the allowed length a list may have before its limits are applied."""


@dataclass(frozen=True)
class Placements:
    """What may be placed in one plane: position, item, mass and vector (K,) of each pair, by position then item.

    Entry K stands for "no piece". most: pieces at most. limits: capacity, capacity_g (H + 1,), counts (I + 1,).
    """

    position: IntArray
    item: IntArray
    mass: FloatArray
    vector: ComplexArray
    most: int
    max_mass_g: float
    capacity: IntArray
    capacity_g: FloatArray
    counts: IntArray

    @property
    def none(self) -> int:
        """Index that stands for no piece."""
        return len(self.vector) - 1

    @cached_property
    def room(self) -> tuple[int, bool, int]:
        """Pieces that any position takes, whether some position limits grams, and pieces that the box has of any item.

        What a row cannot break need not be counted.
        """
        grams = bool(np.isfinite(self.capacity_g[self.position]).any())
        return int(self.capacity[self.position].min()), grams, int(self.counts[self.item].min())

    def allowed(self, index: IntArray) -> BoolArray:
        """Which rows of index (n, k) keep every limit of the plane and of the box."""
        many = index.shape[1]
        a_position, grams, an_item = self.room
        fits = np.ones(len(index), dtype=bool)
        if grams or math.isfinite(self.max_mass_g):
            mass = self.mass[index]
            fits &= within_g(mass.sum(axis=1), self.max_mass_g)
        if a_position < many or grams:
            position = self.position[index]
            for j in range(many):
                here = position == position[:, j : j + 1]
                fits &= here.sum(axis=1) <= self.capacity[position[:, j]]
                if grams:
                    fits &= within_g((mass * here).sum(axis=1), self.capacity_g[position[:, j]])
        if an_item < many:
            item = self.item[index]
            for j in range(many):
                fits &= (item == item[:, j : j + 1]).sum(axis=1) <= self.counts[item[:, j]]
        return fits

    def pieces(self, row: IntArray) -> tuple[Piece, ...]:
        """Pieces of one row of indices."""
        return tuple(sorted(Piece(int(self.position[i]), int(self.item[i])) for i in row if i != self.none))


@dataclass(frozen=True)
class Sums:
    """n selections of one plane: index (n, k) into the placements, vector sums (n,) without `fixed`, g."""

    index: IntArray
    vector: ComplexArray

    def __len__(self) -> int:
        return len(self.vector)


@dataclass(frozen=True)
class Halves:
    """Two lists whose pairs make every selection once.

    ordered: both come from one list, the first half holds the lower placements and as many pieces or one more;
    otherwise they share no position. complete: the pairs make selections of as many pieces as the plane may carry.
    """

    placements: Placements
    first: Sums
    second: Sums
    ordered: bool
    complete: bool

    @property
    def selections(self) -> float:
        """About how many selections the pairs make."""
        pairs = float(len(self.first)) * float(len(self.second))
        if self.ordered:
            pairs /= math.comb(2 * self.first.index.shape[1], self.first.index.shape[1])
        return min(pairs, _many(self.placements, None, self.placements.most))


def placements_of(plane: SelectionPlane, stock: Stock, most: int | None = None) -> Placements:
    """Pairs of position and item that plane and box allow by themselves."""
    mass = effective_g(stock)
    holes, items = len(plane.angles), len(mass)
    position, item = np.divmod(np.arange(holes * items), items)
    fits = (plane.capacity[position] > 0) & within_g(mass[item], plane.capacity_g[position])
    fits &= within_g(mass[item], plane.max_mass_g) & (stock.counts[item] > 0)
    if plane.allowed is not None:
        fits &= plane.allowed.ravel()
    position, item = position[fits], item[fits]
    pieces = slots(plane, stock)
    return Placements(
        position=np.append(position, holes),
        item=np.append(item, items),
        mass=np.append(mass[item], 0.0),
        vector=np.append(mass[item] * np.exp(1j * plane.angles[position]), 0j),
        most=pieces if most is None else min(pieces, most),
        max_mass_g=plane.max_mass_g,
        capacity=np.append(plane.capacity, np.iinfo(np.int64).max),
        capacity_g=np.append(plane.capacity_g, math.inf),
        counts=np.append(stock.counts, np.iinfo(np.int64).max),
    )


def halves_of(placements: Placements, largest: int) -> Generator[None, None, Halves]:
    """Two lists that meet in the middle, each of at most `largest` halves; yields now and then, for a stop.

    By number of pieces, or, where many pieces sit in few positions, by position. Where both are too long, the halves
    hold fewer pieces than the plane may carry and `complete` is False.
    """
    most = placements.most
    # A single piece has no other half to be met with: by position, every two pieces would be paired in vain.
    by_position = max(_many(placements, parity, most) for parity in (0, 1)) if most > 1 else math.inf
    if by_position < min(_many(placements, None, (most + 1) // 2), largest):
        split = yield from _by_position(placements, largest)
        if split is not None:
            return split
    levels = yield from _levels(placements, np.arange(placements.none), (most + 1) // 2, largest)
    complete = len(levels) == (most + 1) // 2 + 1
    size = len(levels) - 1
    shorter = most - size if complete else size
    first = yield from _gathered(placements, levels, size)
    second = first if shorter == size else (yield from _gathered(placements, levels[: shorter + 1], shorter))
    return Halves(
        placements,
        first,
        second,
        ordered=True,
        complete=complete,
    )


def _many(placements: Placements, parity: int | None, most: int) -> float:
    """Bound how many selections of up to `most` pieces even, odd (parity 1) or all positions hold, box aside."""
    if most > MOST_LISTED:
        return math.inf
    counts = np.ones(1)
    for position, kinds in enumerate(np.bincount(placements.position[:-1]).tolist()):
        if kinds and (parity is None or position % 2 == parity):
            room = min(int(placements.capacity[position]), most)
            ways = [float(math.comb(kinds + k - 1, k)) for k in range(room + 1)]
            counts = np.convolve(counts, ways)[: most + 1]
    return float(counts.sum())


def _by_position(placements: Placements, largest: int) -> Generator[None, None, Halves | None]:
    """Halves of even and of odd positions, with any number of pieces up to the plane's limit."""
    parts = []
    for parity in (0, 1):
        mine = np.flatnonzero(placements.position[:-1] % 2 == parity)
        levels = yield from _levels(placements, mine, placements.most, largest)
        if len(levels) <= placements.most and len(levels[-1]):
            return None
        parts.append((yield from _gathered(placements, levels, len(levels) - 1)))
    return Halves(placements, parts[0], parts[1], ordered=False, complete=True)


def _levels(placements: Placements, subset: IntArray, most: int, largest: int) -> Generator[None, None, list[IntArray]]:
    """Multisets of 0, 1, .. `most` placements of the subset, (n, pieces) each, ascending; shorter where too long.

    Ends with an empty level where no more pieces fit.
    """
    small = np.int16 if placements.none < np.iinfo(np.int16).max else np.int32
    levels = [np.empty((1, 0), dtype=small)]
    total = 1
    while len(levels) <= most and len(levels[-1]):
        parents = levels[-1]
        start = np.zeros(len(parents), dtype=np.int64)
        for cut in range(0, len(parents) if parents.shape[1] else 0, 4 * SLAB):
            start[cut : cut + 4 * SLAB] = np.searchsorted(subset, parents[cut : cut + 4 * SLAB, -1])
            yield
        ends = np.cumsum(len(subset) - start)
        if total + int(ends[-1]) > OVERSHOOT * largest:
            return levels
        found = []
        chunk = 2 * EXTEND_CHUNK // (parents.shape[1] + 2)
        for cut in range(0, int(ends[-1]), chunk):
            child = np.arange(cut, min(cut + chunk, int(ends[-1])))
            of = np.searchsorted(ends, child, side="right")
            last = subset[child - ends[of] + len(subset)]
            index = np.concatenate([parents[of], last[:, None].astype(small)], axis=1)
            found.append(index[placements.allowed(index)])
            yield
        level = np.concatenate(found) if found else np.empty((0, parents.shape[1] + 1), dtype=small)
        total += len(level)
        yield
        if total > largest:
            return levels
        levels.append(level)
    return levels


def _gathered(placements: Placements, levels: list[IntArray], width: int) -> Generator[None, None, Sums]:
    """All levels as one list, rows filled up with "no piece"."""
    total = sum(len(level) for level in levels)
    index = np.full((total, width), placements.none, dtype=levels[0].dtype)
    vector = np.zeros(total, dtype=np.complex128)
    start = 0
    for level in levels:
        for cut in range(0, len(level), SLAB):
            part = level[cut : cut + SLAB]
            rows = slice(start, start + len(part))
            index[rows, : level.shape[1]] = part
            vector[rows] = placements.vector[part].sum(axis=1)
            start += len(part)
            yield
    return Sums(index, vector)


def near(halves: Halves, centre: complex, shape: tuple[complex, complex], radius: float) -> Generator[Sums, None, None]:
    """Find selections whose sum u has |T(u - centre)| <= radius, T(z) = shape[0] z + shape[1] conj(z), in chunks.

    A chunk may be empty; it only marks a moment at which to stop.
    """
    first, second = halves.first, halves.second
    stop = Sums(first.index[:0], first.vector[:0])
    ends = np.empty(len(second), dtype=np.complex128)
    wanted = np.empty(len(first), dtype=np.complex128)
    for target, vector, sign in ((ends, second.vector, 1.0), (wanted, first.vector, -1.0)):
        shift = 0.0 if sign > 0.0 else shape[0] * centre + shape[1] * np.conj(centre)
        for cut in range(0, len(vector), SLAB):
            part = slice(cut, cut + SLAB)
            target[part] = shift + sign * (shape[0] * vector[part] + shape[1] * np.conj(vector[part]))
            yield stop
    slabs = min(max(1, math.ceil(len(ends) / SLAB)), 250)
    edges = np.quantile(ends.real[::slabs], np.arange(1, slabs) / slabs) if slabs > 1 else np.empty(0)
    at = yield from _slabs(ends.real, edges, stop)
    lowest = yield from _slabs(wanted.real - radius, edges, stop)
    highest = yield from _slabs(wanted.real + radius, edges, stop)
    for slab in range(slabs):
        points = np.flatnonzero(at == slab)
        queries = np.flatnonzero((lowest <= slab) & (highest >= slab))
        yield stop
        columns = Columns(ends[points], radius)
        yield stop
        for cut in range(0, len(queries), ASKED):
            some = queries[cut : cut + ASKED]
            for a, b in columns.pairs(wanted[some], np.full(len(some), radius)):
                yield _joined(halves, some[a], points[b])


def _slabs(x: FloatArray, edges: FloatArray, stop: Sums) -> Generator[Sums, None, NDArray[np.uint8]]:
    """Return the number of the slab between `edges` that each x lies in."""
    out = np.empty(len(x), dtype=np.uint8)
    for cut in range(0, len(x), SLAB):
        out[cut : cut + SLAB] = np.searchsorted(edges, x[cut : cut + SLAB], side="right")
        yield stop
    return out


def _joined(halves: Halves, a: IntArray, b: IntArray) -> Sums:
    """Pairs that make a selection the one way that counts, and keep every limit."""
    placements, first, second = halves.placements, halves.first.index, halves.second.index
    none = placements.none
    if halves.ordered:
        extra = (first[a] != none).sum(axis=1) - (second[b] != none).sum(axis=1)
        once = (extra >= 0) & (extra <= 1)
        if second.shape[1]:
            once &= np.where(first[a] != none, first[a], -1).max(axis=1, initial=-1) <= second[b, 0]
    else:
        once = (first[a] != none).sum(axis=1) + (second[b] != none).sum(axis=1) <= placements.most
    a, b = a[once], b[once]
    index = np.concatenate([first[a], second[b]], axis=1)
    fits = placements.allowed(index)
    return Sums(index[fits], halves.first.vector[a[fits]] + halves.second.vector[b[fits]])
