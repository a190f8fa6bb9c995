"""The problem without the planes that take no piece at all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from service.balancing.placements import Selection, slots
from service.balancing.selection import Piece, SelectionProblem


@dataclass(frozen=True)
class Opened:
    """`problem` has only the planes `open` of `planes`."""

    problem: SelectionProblem
    open: tuple[int, ...]
    planes: int

    def widen(self, selection: Selection) -> Selection:
        """Selection of all planes."""
        whole: list[tuple[Piece, ...]] = [()] * self.planes
        for p, pieces in zip(self.open, selection, strict=True):
            whole[p] = pieces
        return tuple(whole)

    def narrow(self, selection: Selection) -> Selection:
        """Selection of the open planes."""
        return tuple(selection[p] for p in self.open)

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


def opened(problem: SelectionProblem) -> Opened:
    """Leave out planes that take nothing; their fixed vectors move into the objective's offset."""
    slotted = [slots(plane, problem.stock) > 0 for plane in problem.planes]
    keep = [p for p, some in enumerate(slotted) if some]
    rest = [p for p, some in enumerate(slotted) if not some]
    objective = problem.objective
    fixed = np.array([problem.planes[p].fixed for p in rest], dtype=np.complex128)
    moved = replace(
        objective, matrix=objective.matrix[:, keep], offset=objective.offset + objective.matrix[:, rest] @ fixed
    )
    planes = tuple(problem.planes[p] for p in keep)
    return Opened(replace(problem, objective=moved, planes=planes), tuple(keep), len(problem.planes))
