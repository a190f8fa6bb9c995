"""The best arrangement so far, and how equals are told apart."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from service.balancing.arrangement.problem import ArrangementProblem, ArrangementState
from service.balancing.arrangement.rating import moves, new_parts, values, within_limits
from service.balancing.rotor.phasors import IntArray

TIE = 1e-9
"""Values that differ by a smaller part are equal; the fewest moves, then the fewest new parts, decide."""


@dataclass
class Record:
    """Keeps the best of what it is offered.

    limit: None where the least objective counts; else the fewest moves, then new parts, then the least objective count
    among the arrangements whose objective is at most `limit`.
    """

    problem: ArrangementProblem
    limit: float | None = None
    lower_bound: float = 0.0
    moves_bound: int = 0
    evaluations: int = 0
    arrangement: IntArray | None = None
    value: float = np.inf
    _rank: tuple[float, ...] = field(default=(np.inf,), repr=False)

    @property
    def level(self) -> float:
        """Objective up to which an arrangement may be better than the best; inf before there is one."""
        return (self.value if self.limit is None else self.limit) * (1.0 + 2.0 * TIE)

    def offer(self, arrangements: IntArray) -> None:
        """Rate arrangements (n, P); those that break a limit are left out."""
        self.evaluations += len(arrangements)
        kept = arrangements[within_limits(self.problem, arrangements)]
        value = values(self.problem, kept)
        near = value <= (self.level if np.isfinite(self.level) else value.min(initial=np.inf) * (1.0 + 2.0 * TIE))
        kept, value = kept[near], value[near]
        if not len(kept):
            return
        changed, fresh = moves(self.problem, kept), new_parts(self.problem, kept)
        if self.limit is None:
            equal = value <= float(value.min()) * (1.0 + TIE)
            kept, value, changed, fresh = kept[equal], value[equal], changed[equal], fresh[equal]
        first = int(np.lexsort((value, fresh, changed))[0])
        best, rank = float(value[first]), (float(changed[first]), float(fresh[first]))
        if self._better(best, rank):
            self.arrangement, self.value = kept[first], best
            self._rank = (*rank, best) if self.limit is not None else rank

    def state(self, *, proved: bool = False, open_ended: bool = False) -> ArrangementState:
        """Snapshot; a proof of the least objective makes the value its own bound."""
        bound = self.value if proved and self.limit is None else min(self.lower_bound, self.value)
        return ArrangementState(
            self.arrangement, self.value, bound, self.evaluations, proved, self.moves_bound, open_ended
        )

    def _better(self, value: float, rank: tuple[float, ...]) -> bool:
        if self.limit is not None:
            return (*rank, value) < self._rank
        if value < self.value * (1.0 - TIE):
            return True
        return value <= self.value * (1.0 + TIE) and rank < self._rank
