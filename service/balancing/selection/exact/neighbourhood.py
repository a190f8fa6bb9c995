"""Smaller problems around a selection: some of its pieces stay, the rest is chosen anew.

Each is small enough to be searched completely within a second. Its best selection, with the pieces that stay, is one of
the whole problem, never worse than the one it was made around.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import IntArray
from service.balancing.selection.placements import MASS_SLACK, Selection, effective_g, slots
from service.balancing.selection.problem import UNLIMITED, Piece, SelectionPlane, SelectionProblem, Stock

FREE_PLANES = 2
"""Planes whose pieces are chosen anew together."""
MAX_FREE = 6
"""Pieces a plane that are chosen anew."""
MIN_ITEMS = 12
"""Items below which a box is not thinned any more."""
MAX_HALVES = 200_000
"""Selections of half as many pieces that a plane may have."""


@dataclass(frozen=True)
class Neighbourhood:
    """A smaller problem.

    start: the selection's pieces that are chosen anew. kept: those that stay. items: of the box, in the problem.
    """

    problem: SelectionProblem
    start: Selection
    kept: Selection
    items: IntArray

    def widen(self, selection: Selection) -> Selection:
        """A selection of the smaller problem as one of the whole."""
        return tuple(
            tuple(sorted((*kept, *(Piece(piece.position, int(self.items[piece.item])) for piece in pieces))))
            for kept, pieces in zip(self.kept, selection, strict=True)
        )


def neighbourhood(
    problem: SelectionProblem, selection: Selection, heaviest: float, rng: np.random.Generator
) -> Neighbourhood:
    """Choose what is searched anew around `selection`: planes, pieces, and, where there are many, items and holes.

    heaviest: items of more grams are left out.
    """
    planes = len(problem.planes)
    free_planes = set(rng.permutation(planes)[:FREE_PLANES].tolist())
    holes = max(len(plane.angles) for plane in problem.planes)
    most = max(min(slots(plane, problem.stock), MAX_FREE) for plane in problem.planes)
    free = int(rng.integers(max(most - 2, 1), most + 1))
    mass = effective_g(problem.stock)
    kept, start = [], []
    for p, pieces in enumerate(selection):
        stay = len(pieces)
        if p in free_planes:
            least, room = max(stay - free, 0), slots(problem.planes[p], problem.stock) - free
            stay = int(rng.integers(least, max(least, min(stay, room)) + 1))
        shuffled = [pieces[i] for i in rng.permutation(len(pieces))]
        kept.append(tuple(shuffled[:stay]))
        start.append(tuple(shuffled[stay:]))
    used = np.array([piece.item for pieces in start for piece in pieces], dtype=np.int64)
    items, open_holes = _some(np.flatnonzero(mass <= heaviest), holes, (free + 1) // 2, rng)
    items = np.unique(np.concatenate([items, used])).astype(np.int64)
    at = {int(item): i for i, item in enumerate(items)}
    box = _left(problem.stock, kept, items)
    chosen = tuple(
        _free_plane(plane, kept[p], mass, items, free if p in free_planes else 0)
        for p, plane in enumerate(problem.planes)
    )
    if open_holes < holes:
        chosen = tuple(_fewer_holes(plane, start[p], open_holes, rng) for p, plane in enumerate(chosen))
    begin = tuple(tuple(sorted(Piece(piece.position, at[piece.item]) for piece in pieces)) for pieces in start)
    return Neighbourhood(replace(problem, planes=chosen, stock=box), begin, tuple(kept), items)


def thinned(problem: SelectionProblem, selection: Selection, heaviest: float, stride: int) -> Neighbourhood | None:
    """The problem with every `stride`th item of the box, by mass up to `heaviest` g, and those of `selection`.

    None where that is few items, or all of them.
    """
    mass = effective_g(problem.stock)
    order = np.argsort(mass, kind="stable")
    light = order[mass[order] <= heaviest]
    order = light[::stride]
    if len(order) == len(mass) or (stride > 1 and len(order) < MIN_ITEMS) or not len(order):
        return None
    used = np.array([piece.item for pieces in selection for piece in pieces], dtype=np.int64)
    items = np.unique(np.concatenate([order, used])).astype(np.int64)
    at = {int(item): i for i, item in enumerate(items)}
    nothing: Selection = tuple(() for _ in problem.planes)
    planes = tuple(_free_plane(plane, (), mass, items, plane.max_pieces) for plane in problem.planes)
    begin = tuple(tuple(sorted(Piece(piece.position, at[piece.item]) for piece in pieces)) for pieces in selection)
    box = _left(problem.stock, list(nothing), items)
    return Neighbourhood(replace(problem, planes=planes, stock=box), begin, nothing, items)


def _some(items: IntArray, holes: int, half: int, rng: np.random.Generator) -> tuple[IntArray, int]:
    """Some of the items, and how many holes, so that halves of this many pieces can be listed."""
    pairs = 2.0
    while (pairs + half) ** half / math.factorial(half) < MAX_HALVES:
        pairs *= 1.25
    room = min(max(int(pairs / holes), MIN_ITEMS // 2), len(items))
    chosen = items if room == len(items) else rng.permutation(items)[:room]
    return chosen, max(int(pairs / max(room, 1)), 1)


def _fewer_holes(
    plane: SelectionPlane, start: tuple[Piece, ...], holes: int, rng: np.random.Generator
) -> SelectionPlane:
    """The plane with only some of its holes open, those of `start` among them."""
    closed = np.ones(len(plane.angles), dtype=bool)
    closed[rng.permutation(len(closed))[:holes]] = False
    closed[[piece.position for piece in start]] = False
    return replace(plane, capacity=np.where(closed, 0, plane.capacity))


def _left(stock: Stock, kept: list[tuple[Piece, ...]], items: IntArray) -> Stock:
    """What the box has left for the pieces that are chosen anew."""
    taken = np.bincount([piece.item for pieces in kept for piece in pieces], minlength=len(stock.counts))
    counts = np.where(stock.counts == UNLIMITED, UNLIMITED, stock.counts - taken)
    return Stock(stock.masses_g[items], counts[items], stock.fasteners_g[items])


def _free_plane(
    plane: SelectionPlane,
    kept: tuple[Piece, ...],
    mass: np.ndarray[tuple[int], np.dtype[np.float64]],
    items: IntArray,
    free: int,
) -> SelectionPlane:
    """The plane with the pieces that stay in it, and room for `free` more."""
    at = np.array([piece.position for piece in kept], dtype=np.int64)
    grams = mass[[piece.item for piece in kept]]
    holes, slack = len(plane.angles), 1.0 + MASS_SLACK
    here = np.bincount(at, minlength=holes)
    return replace(
        plane,
        capacity=np.where(plane.capacity == UNLIMITED, UNLIMITED, plane.capacity - here),
        capacity_g=np.maximum(plane.capacity_g - np.bincount(at, weights=grams, minlength=holes) / slack, 0.0),
        max_pieces=min(free, plane.max_pieces - len(kept)),
        max_mass_g=max(plane.max_mass_g - float(grams.sum()) / slack, 0.0),
        fixed=plane.fixed + complex((grams * np.exp(1j * plane.angles[at])).sum()),
        allowed=None if plane.allowed is None else plane.allowed[:, items],
    )
