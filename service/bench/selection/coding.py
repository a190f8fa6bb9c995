"""A selection problem as a list of whole numbers, for searchers that know nothing else.

Each plane has as many slots as it takes pieces; a slot is two numbers: the rank of its mass (0: left empty) and its
position. Broken limits are counted, not repaired: that is left to the searcher's own rules.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import IntArray
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, effective_g, slots, vectors_of
from service.balancing.selection.problem import Piece, SelectionProblem


@dataclass(frozen=True)
class Coded:
    """The numbers 0 .. highest[k] of each variable, ranks and positions in turn; plane: (slots,) of each slot."""

    problem: SelectionProblem
    plane: IntArray
    highest: IntArray
    order: IntArray

    @classmethod
    def of(cls, problem: SelectionProblem) -> Coded:
        """Code a problem."""
        plane = np.repeat(np.arange(len(problem.planes)), [slots(p, problem.stock) for p in problem.planes])
        highest = np.empty(2 * len(plane), dtype=np.int64)
        highest[0::2] = len(problem.stock.masses_g)
        highest[1::2] = [len(problem.planes[p].angles) - 1 for p in plane]
        return cls(problem, plane, highest, np.argsort(effective_g(problem.stock), kind="stable"))

    def selection(self, x: Sequence[float]) -> Selection:
        """Pieces that the numbers stand for, allowed or not."""
        numbers = np.clip(np.rint(np.asarray(x, dtype=np.float64)).astype(np.int64), 0, self.highest)
        chosen: list[list[Piece]] = [[] for _ in self.problem.planes]
        for p, rank, position in zip(self.plane, numbers[0::2], numbers[1::2], strict=True):
            if rank > 0:
                chosen[p].append(Piece(int(position), int(self.order[rank - 1])))
        return tuple(tuple(sorted(pieces)) for pieces in chosen)

    def rate(self, x: Sequence[float]) -> tuple[float, float]:
        """Objective, and by how many pieces and parts of a limit in grams the limits are broken."""
        selection = self.selection(x)
        value = float(evaluate(self.problem.objective, vectors_of(self.problem, selection)))
        return value, excess(self.problem, selection)

    def penalised(self, x: Sequence[float]) -> float:
        """Objective, any broken limit being worse than the bare rotor."""
        value, broken = self.rate(x)
        if broken <= 0.0:
            return value
        bare = np.array([plane.fixed for plane in self.problem.planes])
        return value + (1.0 + broken) * float(evaluate(self.problem.objective, bare))


def excess(problem: SelectionProblem, selection: Selection) -> float:
    """How far limits are broken: pieces too many, and grams too many over their limit; 0 where none is."""
    mass = effective_g(problem.stock).tolist()
    over = 0.0
    for plane, pieces in zip(problem.planes, selection, strict=True):
        over += max(0, len(pieces) - plane.max_pieces)
        over += _over(sum(mass[piece.item] for piece in pieces), plane.max_mass_g)
        for position, count in Counter(piece.position for piece in pieces).items():
            grams = sum(mass[piece.item] for piece in pieces if piece.position == position)
            over += max(0, count - int(plane.capacity[position]))
            over += _over(grams, float(plane.capacity_g[position]))
        if plane.allowed is not None:
            over += sum(not plane.allowed[piece.position, piece.item] for piece in pieces)
    used = Counter(piece.item for pieces in selection for piece in pieces)
    return float(over + sum(max(0, count - int(problem.stock.counts[item])) for item, count in used.items()))


def _over(grams: float, limit: float) -> float:
    return max(0.0, grams - limit * (1.0 + 1e-9)) / max(limit, 1.0)
