"""Run a search to its end, its deadline or what the scale can tell, and say how it ended."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from service.balancing.arrangement import infeasibility
from service.balancing.arrangement.exact.enumeration import MAX_ENUMERATED, count_bound
from service.balancing.arrangement.problem import ArrangementProblem, ArrangementResult, ArrangementState
from service.balancing.arrangement.rating import moves, residuals
from service.balancing.arrangement.record import TIE
from service.balancing.arrangement.solve import search_best, search_fewest
from service.balancing.rotor.phasors import IntArray
from service.balancing.selection.problem import Status

Stop = Callable[[], bool]
Deviation = Callable[[IntArray], float]

ALL_EQUAL = "all_equal"
NOT_FOUND = "none_found"
LIMIT_NOT_MET = "limit_not_met"


def exact_masses(_arrangement: IntArray) -> float:
    """Deviation of the objective where the scale is not known: none."""
    return 0.0


def solve_best(
    problem: ArrangementProblem, seed: int, *, deviation: Deviation = exact_masses, stop: Stop = lambda: False
) -> ArrangementResult:
    """Best arrangement with a proven lower bound.

    deviation: standard deviation of the objective of an arrangement from the scale; where a proof may take minutes, the
    search ends as `within_uncertainty` once value - bound is below it. `stop()` is asked between the steps.
    Raises NumericsError for an invalid problem.
    """
    state = _last(search_best(problem, np.random.default_rng(seed)), deviation, stop)
    return _result(problem, state, deviation)


def solve_fewest(
    problem: ArrangementProblem,
    limit: float,
    seed: int,
    *,
    deviation: Deviation = exact_masses,
    stop: Stop = lambda: False,
) -> ArrangementResult:
    """Fewest moves whose objective is at most `limit`, then fewest new parts, then least objective.

    Where no arrangement meets the limit the result is infeasible and its `value` what the best leaves, if that is
    proved.
    """
    state = _last(search_fewest(problem, limit, np.random.default_rng(seed)), deviation, stop, least=False)
    if state.arrangement is None and state.proved:
        best = solve_best(problem, seed, deviation=deviation, stop=stop)
        if best.arrangement is None:
            return best
        return _none(problem, best.evaluations, LIMIT_NOT_MET, {"limit": limit, "best": best.value}, best.lower_bound)
    return _result(problem, state, deviation, fewest=True)


def _last(
    states: Iterator[ArrangementState], deviation: Deviation, stop: Stop, *, least: bool = True
) -> ArrangementState:
    """The state at which a search ends."""
    state = next(states)
    rated: tuple[IntArray | None, float] = (None, 0.0)
    while not (state.proved or stop()):
        if least and state.open_ended and state.arrangement is not None:
            if rated[0] is not state.arrangement:
                rated = (state.arrangement, deviation(state.arrangement))
            if state.value - state.lower_bound <= rated[1]:
                break
        following = next(states, None)
        if following is None:
            break
        state = following
    return state


def _result(
    problem: ArrangementProblem, state: ArrangementState, deviation: Deviation, *, fewest: bool = False
) -> ArrangementResult:
    if state.arrangement is None:
        if not state.proved:
            return _none(problem, state.evaluations, NOT_FOUND, {}, state.lower_bound, status="limit_reached")
        code, details = infeasibility.unfillable(problem) or _excluded(problem)
        return _none(problem, state.evaluations, code, details, 0.0)
    row = state.arrangement[None, :]
    scatter = deviation(state.arrangement)
    status: Status = "limit_reached"
    if state.proved:
        status = "optimal"
    elif not fewest and state.value - state.lower_bound <= scatter:
        status = "within_uncertainty"
    equal = _all_equal(problem)
    return ArrangementResult(
        status=status,
        arrangement=state.arrangement,
        value=state.value,
        lower_bound=state.lower_bound,
        residual=residuals(problem, row)[0],
        moves=int(moves(problem, row)[0]),
        evaluations=state.evaluations,
        scatter=scatter,
        moves_bound=state.moves_bound if fewest else None,
        code=ALL_EQUAL if equal else "",
    )


def _excluded(problem: ArrangementProblem) -> tuple[str, dict[str, float | str]]:
    if count_bound(problem) <= MAX_ENUMERATED:
        return infeasibility.excluded(problem)
    return infeasibility.TOGETHER, {}


def _none(
    problem: ArrangementProblem,
    evaluations: int,
    code: str,
    details: dict[str, float | str],
    lower_bound: float,
    status: Status = "infeasible",
) -> ArrangementResult:
    return ArrangementResult(
        status=status,
        arrangement=None,
        value=float("inf"),
        lower_bound=lower_bound,
        residual=problem.objective.offset,
        moves=0,
        evaluations=evaluations,
        code=code,
        details=details,
    )


def _all_equal(problem: ArrangementProblem) -> bool:
    """Whether the parts differ so little that their order is of no consequence."""
    if problem.parts < 2:
        return False
    spread = np.ptp(problem.effects.view(np.float64), axis=0).max()
    return bool(spread <= TIE * np.abs(problem.effects).max())
