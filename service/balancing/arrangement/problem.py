"""The problem of arranging weighed parts, and what a solver says about it.

Places hold parts. The part k in place p adds `effects[k, p]` to the residual r; what r is, and how it is rated, is an
`Objective` as of the selection of stock masses:

    r = objective.offset + sum over the places of effects[part there, place]

An arrangement is an array (P,) of part numbers, `EMPTY` where a place holds none. A move is a place whose part differs
from the present one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.problem import BoolArray, Objective, Status

EMPTY = -1
"""Number of the part in a place that holds none."""


@dataclass(frozen=True)
class GroupLimit:
    """Places whose parts may differ by at most `max_difference_g` in mass (a maker's rule)."""

    places: tuple[int, ...]
    max_difference_g: float


@dataclass(frozen=True)
class ArrangementProblem:
    """K parts, P places and S components of the residual.

    effects: (K, P, S) complex, unit of r. allowed: (K, P), which part fits where; a part that must stay is allowed in
    its place alone, and alone there. may_be_empty: (P,). present: (P,) part numbers, `EMPTY` where none is mounted or
    it is gone. new: (K,), parts that count as new. sets: parts that are mounted all or none. masses_g: (K,), for the
    groups. max_moves, max_new: None where not limited.
    """

    objective: Objective
    effects: ComplexArray
    allowed: BoolArray
    may_be_empty: BoolArray
    present: IntArray
    new: BoolArray
    masses_g: FloatArray
    sets: tuple[tuple[int, ...], ...] = ()
    groups: tuple[GroupLimit, ...] = ()
    max_moves: int | None = None
    max_new: int | None = None

    @property
    def parts(self) -> int:
        """Number of parts."""
        return int(self.effects.shape[0])

    @property
    def places(self) -> int:
        """Number of places."""
        return int(self.effects.shape[1])

    @property
    def limited(self) -> bool:
        """Whether anything but `allowed` and `may_be_empty` limits the arrangements."""
        return bool(self.sets or self.groups or self.max_moves is not None or self.max_new is not None)

    def with_max_moves(self, moves: int | None) -> ArrangementProblem:
        """The same with another limit of moves."""
        return replace(self, max_moves=moves)


@dataclass(frozen=True)
class ArrangementState:
    """After one step of a search.

    arrangement: the best so far, None before one is found. lower_bound: no allowed arrangement is below it; `proved`
    means that nothing better is left, or that there is none at all. moves_bound: no fewer moves meet the limit, where
    the fewest are searched. open_ended: a proof may take minutes or never come.
    """

    arrangement: IntArray | None
    value: float
    lower_bound: float
    evaluations: int
    proved: bool = False
    moves_bound: int = 0
    open_ended: bool = False


@dataclass(frozen=True)
class ArrangementResult:
    """What a solver found and what it proved.

    status, lower_bound: as of a selection. code: how it ended, of `infeasibility` or `all_equal`; empty else.
    residual: (S,) complex r. moves: places that differ from the present arrangement. moves_bound: no arrangement with
    fewer moves meets the limit, where the fewest were asked for. scatter: standard deviation of the value from the
    scale. details: parameters of `code`.
    """

    status: Status
    arrangement: IntArray | None
    value: float
    lower_bound: float
    residual: ComplexArray
    moves: int
    evaluations: int
    scatter: float = 0.0
    moves_bound: int | None = None
    code: str = ""
    details: dict[str, float | str] | None = None

    @property
    def gap(self) -> float:
        """How much better, at most, another arrangement could be, in the objective's unit."""
        return max(0.0, self.value - self.lower_bound)


def none_mounted(places: int) -> IntArray:
    """A present arrangement without parts, (P,)."""
    return np.full(places, EMPTY, dtype=np.int64)
