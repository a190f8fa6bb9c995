"""Presolve: reduce a problem to the planes and items that can matter, and map its selections back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import IntArray
from service.balancing.selection.placements import Selection, effective_g, slots
from service.balancing.selection.problem import Piece, SelectionProblem, Stock

NO_EFFECT = 1e-14
"""Part of another plane's effect per g below which a plane has none: it is rounding of the other's."""


@dataclass(frozen=True)
class Reduced:
    """`problem` has only the planes `open` of `planes`; the others stay empty.

    items: where the box is too long to be listed position by position, those of its items that are in `problem`.
    """

    problem: SelectionProblem
    open: tuple[int, ...]
    planes: int
    items: IntArray | None = None

    def widen(self, selection: Selection) -> Selection:
        """Selection of all planes."""
        whole: list[tuple[Piece, ...]] = [()] * self.planes
        for p, pieces in zip(self.open, selection, strict=True):
            whole[p] = pieces
            if self.items is not None:
                whole[p] = tuple(Piece(piece.position, int(self.items[piece.item])) for piece in pieces)
        return tuple(whole)

    def narrow(self, selection: Selection) -> Selection:
        """Selection of the open planes; all its items are in `problem`."""
        chosen = tuple(selection[p] for p in self.open)
        if self.items is None:
            return chosen
        at = {int(item): i for i, item in enumerate(self.items)}
        return tuple(tuple(Piece(piece.position, at[piece.item]) for piece in pieces) for pieces in chosen)

    def thinned(self, most: int, start: Selection | None) -> Reduced:
        """The same with a box of at most about `most` position-item pairs a plane, spread over its masses.

        The items of `start` are kept. The same object where the box is short enough.
        """
        stock = self.problem.stock
        room = max(2, most // max(len(plane.angles) for plane in self.problem.planes))
        if len(stock.masses_g) <= room:
            return self
        order = np.argsort(effective_g(stock), kind="stable")
        spread = order[np.linspace(0, len(order) - 1, room).round().astype(np.int64)]
        used = [piece.item for pieces in start or () for piece in pieces]
        keep = np.unique(np.concatenate([spread, np.array(used, dtype=np.int64)]))
        box = Stock(stock.masses_g[keep], stock.counts[keep], stock.fasteners_g[keep])
        planes = tuple(
            plane if plane.allowed is None else replace(plane, allowed=plane.allowed[:, keep])
            for plane in self.problem.planes
        )
        return replace(self, problem=replace(self.problem, planes=planes, stock=box), items=keep)

    def alike(self, p: int, q: int) -> bool:
        """Whether two open planes have the same positions and limits."""
        one, other = self.problem.planes[p], self.problem.planes[q]
        return (
            np.array_equal(one.angles, other.angles)
            and np.array_equal(one.capacity, other.capacity)
            and np.array_equal(one.capacity_g, other.capacity_g)
            and one.max_pieces == other.max_pieces
            and one.max_mass_g == other.max_mass_g
            and one.allowed is None
            and other.allowed is None
        )


def opened(problem: SelectionProblem) -> Reduced:
    """Leave out planes that take nothing, or whose masses have no effect: fewest pieces is then none.

    Their fixed vectors move into the objective's offset.
    """
    effect = np.abs(problem.objective.weights[:, None] * problem.objective.matrix).max(axis=0)
    acts = effect > NO_EFFECT * effect.max()
    slotted = [act and slots(plane, problem.stock) > 0 for act, plane in zip(acts, problem.planes, strict=True)]
    keep = [p for p, some in enumerate(slotted) if some]
    rest = [p for p, some in enumerate(slotted) if not some]
    objective = problem.objective
    fixed = np.array([problem.planes[p].fixed for p in rest], dtype=np.complex128)
    moved = replace(
        objective, matrix=objective.matrix[:, keep], offset=objective.offset + objective.matrix[:, rest] @ fixed
    )
    planes = tuple(problem.planes[p] for p in keep)
    return Reduced(replace(problem, objective=moved, planes=planes), tuple(keep), len(problem.planes))
