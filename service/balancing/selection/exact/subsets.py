"""What one plane may carry: its placements, the selections of a few of them, and their vector sums."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.placements import effective_g, slots, within_g
from service.balancing.selection.problem import BoolArray, Piece, SelectionPlane, Stock

EXTEND_CHUNK = 100_000
"""Halves extended between two stops."""
SLAB = 75_000
"""Halves sorted at a time."""
MAX_LISTED = 200
"""Pieces a plane beyond which it is not even counted how many selections there are."""


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

    @cached_property
    def counted(self) -> dict[tuple[int | None, int], float]:
        """What `many_of` has counted before."""
        return {}

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


def many_of(placements: Placements, parity: int | None, most: int) -> float:
    """Bound how many selections of up to `most` pieces even, odd (parity 1) or all positions hold, box aside."""
    if most > MAX_LISTED:
        return math.inf
    asked = (parity, most)
    if asked not in placements.counted:
        placements.counted[asked] = _many(placements, parity, most)
    return placements.counted[asked]


def _many(placements: Placements, parity: int | None, most: int) -> float:
    counts = np.ones(1)
    for position, kinds in enumerate(np.bincount(placements.position[:-1]).tolist()):
        if kinds and (parity is None or position % 2 == parity):
            room = min(int(placements.capacity[position]), most)
            ways = [float(math.comb(kinds + k - 1, k)) for k in range(room + 1)]
            counts = np.convolve(counts, ways)[: most + 1]
    return float(counts.sum())


def levels_of(placements: Placements, subset: IntArray, most: int) -> Generator[None, None, list[IntArray]]:
    """Multisets of 0, 1, .. `most` placements of the subset, (n, pieces) each, ascending.

    Ends with an empty level where no more pieces fit.
    """
    small = np.int16 if placements.none < np.iinfo(np.int16).max else np.int32
    levels = [np.empty((1, 0), dtype=small)]
    while len(levels) <= most and len(levels[-1]):
        parents = levels[-1]
        start = np.zeros(len(parents), dtype=np.int64)
        for cut in range(0, len(parents) if parents.shape[1] else 0, 4 * SLAB):
            start[cut : cut + 4 * SLAB] = np.searchsorted(subset, parents[cut : cut + 4 * SLAB, -1])
            yield
        ends = np.cumsum(len(subset) - start)
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
        levels.append(level)
        yield
    return levels


def gathered(placements: Placements, levels: list[IntArray], width: int) -> Generator[None, None, Sums]:
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
