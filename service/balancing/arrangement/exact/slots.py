"""The problem as a matching: every slot holds exactly one part.

The places whose part is open are the first slots; spare slots hold the parts that are not mounted, and dummy parts
stand for empty places. Residuals are weighted, so that the norm is unweighted, and counted from the base: the present
arrangement, completed where it must be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from service.balancing.arrangement.problem import EMPTY, ArrangementProblem
from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.balancing.selection.problem import BoolArray, Norm


@dataclass(frozen=True)
class Slots:
    """M parts (the last of them dummies) in M slots (the first of them places).

    effects: (M, M, S) complex, weighted residual by part and slot. offset: (S,), weighted, with the fixed parts in it.
    allowed: (M, M). places, parts: numbers in the problem of the open places and of the open parts; a dummy is `EMPTY`.
    fixed: (P,) the fixed parts of all places, `EMPTY` in the open ones. base: (M,) part in each slot.
    """

    problem: ArrangementProblem
    effects: ComplexArray
    offset: ComplexArray
    allowed: BoolArray
    places: IntArray
    parts: IntArray
    fixed: IntArray
    base: IntArray

    @property
    def size(self) -> int:
        """Number of slots, and of parts."""
        return len(self.parts)

    @property
    def open_places(self) -> int:
        """Number of slots that are places."""
        return len(self.places)

    @property
    def norm(self) -> Norm:
        """Norm of the weighted residual."""
        return self.problem.objective.norm

    def arrangements(self, slotted: IntArray) -> IntArray:
        """Arrangements (n, P) of the problem for parts (n, M) or (n, open places) in the slots."""
        whole = np.repeat(self.fixed[None, :], len(slotted), axis=0)
        whole[:, self.places] = self.parts[slotted[:, : self.open_places]]
        return whole

    def slotted(self, arrangement: IntArray) -> IntArray:
        """Parts (M,) in the slots for an arrangement (P,); spare slots and dummies are filled up in order."""
        number = {int(part): k for k, part in enumerate(self.parts) if part != EMPTY}
        held = [number.get(int(arrangement[place]), -1) for place in self.places]
        left = [k for k in range(self.size) if k not in set(held)]
        dummies = [k for k in left if self.parts[k] == EMPTY]
        filled = [k if k >= 0 else dummies.pop(0) for k in held]
        rest = [k for k in range(self.size) if k not in set(filled)]
        return np.array([*filled, *rest], dtype=np.int64)


def slots_of(problem: ArrangementProblem) -> Slots | None:
    """The matching of a problem; None where no arrangement fills the places with parts that fit."""
    fixed, places, parts = _open(problem)
    dummies = int(problem.may_be_empty[places].sum())
    size = len(parts) + dummies
    spare = size - len(places)
    if spare < 0:
        return None
    numbers = np.concatenate([parts, np.full(dummies, EMPTY, dtype=np.int64)])
    allowed = np.full((size, size), fill_value=True, dtype=np.bool_)
    allowed[: len(parts), : len(places)] = problem.allowed[np.ix_(parts, places)]
    allowed[len(parts) :, : len(places)] = problem.may_be_empty[places]
    effects = np.zeros((size, size, problem.effects.shape[2]), dtype=np.complex128)
    effects[: len(parts), : len(places)] = problem.effects[np.ix_(parts, places)] * problem.objective.weights
    held = fixed != EMPTY
    offset = problem.objective.offset + problem.effects[fixed[held], np.flatnonzero(held)].sum(axis=0)
    base = _base(problem, allowed, places, parts)
    return (
        None
        if base is None
        else Slots(
            problem=problem,
            effects=effects,
            offset=offset * problem.objective.weights,
            allowed=allowed,
            places=places,
            parts=numbers,
            fixed=fixed,
            base=base,
        )
    )


def _open(problem: ArrangementProblem) -> tuple[IntArray, IntArray, IntArray]:
    """Fixed parts (P,), and the numbers of the open places and parts."""
    choices = problem.allowed.sum(axis=0) + problem.may_be_empty
    only = np.flatnonzero((choices == 1) & ~problem.may_be_empty)
    fixed = np.full(problem.places, EMPTY, dtype=np.int64)
    for place in only:
        part = int(np.argmax(problem.allowed[:, place]))
        if problem.allowed[part].sum() == 1:
            fixed[place] = part
    places = np.flatnonzero(fixed == EMPTY)
    usable = set(np.flatnonzero(problem.allowed[:, places].any(axis=1)).tolist()) - set(fixed.tolist())
    return fixed, places, np.array(sorted(usable), dtype=np.int64)


def _base(problem: ArrangementProblem, allowed: BoolArray, places: IntArray, parts: IntArray) -> IntArray | None:
    """Part in each slot: as many of the present ones as possible; None where the slots cannot be filled."""
    size = len(allowed)
    cost = np.where(allowed, 1.0, 4.0 * size)
    number = {int(part): k for k, part in enumerate(parts)}
    for slot, place in enumerate(places):
        part = int(problem.present[place])
        if part in number and allowed[number[part], slot]:
            cost[number[part], slot] = 0.0
        if part == EMPTY and problem.may_be_empty[place]:
            cost[len(parts) :, slot] = 0.0
    if size == 0:
        return np.zeros(0, dtype=np.int64)
    rows, columns = linear_sum_assignment(cost)
    base = np.empty(size, dtype=np.int64)
    base[columns] = rows
    return base if allowed[base, np.arange(size)].all() else None
