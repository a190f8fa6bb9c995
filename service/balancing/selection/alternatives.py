"""Other answers to the same problem: the next best, fewer pieces, and the fewest that are good enough.

All of them use the exact search, so that "no selection of three pieces meets the limit" is proved, not tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from service.balancing.selection.exact.search import (
    ExactState,
    Stop,
    bounds_for,
    exact_result,
    last_state,
    never,
    search_exact,
    solve_exact,
)
from service.balancing.selection.infeasibility import explain_limit
from service.balancing.selection.objectives import evaluate, residual
from service.balancing.selection.placements import result_of, slots, vectors_of
from service.balancing.selection.problem import SelectionProblem, SelectionResult
from service.balancing.selection.validation import validate
from service.errors import NumericsError
from service.messages import Message

SAME = 1e-9
"""Relative difference below which a value meets a limit, or two values are one."""


@dataclass(frozen=True)
class FrontPoint:
    """The best selection of at most `pieces` pieces in all planes together."""

    pieces: int
    result: SelectionResult


def best_selections(problem: SelectionProblem, many: int, *, stop: Stop = never) -> tuple[SelectionResult, ...]:
    """The `many` best distinct selections, best first; fewer where there are fewer.

    Distinct means other pieces or other positions. Proved (`optimal`: nothing else comes between), or
    `limit_reached` after `stop()`. Equal values are ordered by fewest pieces, least mass, commonest stock.
    """
    if many < 1:
        raise NumericsError(Message("numerics.many_below_one", many=many), field="many", value=many)
    state = last_state(search_exact(problem, keep=many), lambda _: stop(), patient=stop is not never)
    whole = exact_result(problem, state)
    return tuple(
        result_of(problem, selection, whole.status, whole.message, state.evaluations, state.lower_bound)
        for selection in state.selections
    )


def front(problem: SelectionProblem, *, stop: Stop = never) -> Iterator[FrontPoint]:
    """Yield the best selection of at most 0, 1, 2 .. pieces, as long as one more piece makes it better.

    Ends with the point that the whole problem's optimum belongs to, or at `stop()`; a point that was stopped carries
    its own bound and status.
    """
    validate(problem)
    total = most_pieces(problem)
    bounds = bounds_for(problem)
    last: SelectionResult | None = None
    optimum: SelectionResult | None = None
    for pieces in range(total + 1):
        start = None if last is None else last.pieces
        state = last_state(search_exact(problem, start=start, most_pieces=pieces, bounds=bounds), lambda _: stop())
        result = exact_result(problem, state, limited=pieces < total)
        if last is None or result.value < last.value * (1.0 - SAME):
            yield FrontPoint(pieces, result)
            last = result
        elif optimum is None and pieces < total:
            # More pieces did not help: is there anything left to find?
            optimum = solve_exact(problem, start=last.pieces, stop=stop)
        if stop() or result.status != "optimal":
            return
        if optimum is not None and optimum.status == "optimal" and last.value <= optimum.value * (1.0 + SAME):
            return


def solve_fewest(problem: SelectionProblem, limit: float, *, stop: Stop = never) -> SelectionResult:
    """The fewest pieces that bring the objective to `limit` or below, and among those the best.

    `optimal`: no selection of fewer pieces meets the limit. `infeasible`: none at all does; `reason` says how near one
    comes and what would make it possible. `limit_reached`: stopped; `details["at_least"]` pieces are proved necessary.
    """
    validate(problem)
    if not limit >= 0.0:
        raise NumericsError(Message("numerics.limit_negative", limit=limit), field="limit", value=limit)
    allowed = limit * (1.0 + SAME)
    evaluations = 0
    bounds = bounds_for(problem)
    state: ExactState | None = None
    for pieces in range(most_pieces(problem) + 1):
        start = None if state is None else state.selection
        states = search_exact(problem, start=start, most_pieces=pieces, bounds=bounds)
        state = last_state(states, lambda now: now.lower_bound > allowed or stop())
        evaluations += state.evaluations
        if state.value <= allowed or stop() or state.exhausted:
            found = exact_result(problem, state, limited=True)
            status = found.status if state.value <= allowed else "limit_reached"
            message = _met(pieces, found.message) if state.value <= allowed else _unmet(state, pieces)
            return replace(found, status=status, message=message, evaluations=evaluations, details={"at_least": pieces})
    return explain_limit(problem, limit, evaluations, stop)


def _met(pieces: int, proof: Message) -> Message:
    """How many pieces meet the limit, and what is proved of them."""
    if pieces == 0:
        return Message("limit_met.without_pieces", proof=proof)
    return Message("limit_met", count=pieces, proof=proof)


def _unmet(state: ExactState, pieces: int) -> Message:
    if state.exhausted:
        return Message("limit_open.too_large" if pieces else "limit_open.too_large_at_once", pieces=pieces)
    return Message("limit_open.stopped" if pieces else "limit_open.stopped_at_once", pieces=pieces)


def prefer(problem: SelectionProblem, result: SelectionResult, slack: float, *, stop: Stop = never) -> SelectionResult:
    """The selection of fewest pieces, then least mass, then commonest stock, whose objective is within `slack`.

    result: the best, proved at least as far as can be measured, else there is nothing to be near to. slack: in the
    objective's unit, on top of its value; with 0 that is `result`, whose equals are told apart in this way already. The
    lower bound and the status stay the problem's own.
    details["slack_proved"]: 1 where nothing of fewer pieces, or of as few and less mass, is within the slack; 0 where
    `stop()` or memory ended the search for it: the message says what is left open.
    """
    if not slack >= 0.0:
        raise NumericsError(Message("numerics.slack_negative", slack=slack), field="slack", value=slack)
    if slack == 0.0 or result.pieces is None:
        return result
    limit = result.value + slack
    fewest = None if result.status == "limit_reached" else solve_fewest(problem, limit, stop=stop)
    if fewest is None or fewest.pieces is None or fewest.value > limit * (1.0 + SAME):
        message = Message("slack_open", proof=result.message, slack=slack)
        return replace(result, message=message, details={**result.details, "slack_proved": 0.0})
    pieces = sum(len(plane) for plane in fewest.pieces)
    states = search_exact(problem, start=fewest.pieces, most_pieces=pieces, good_enough=limit)
    state = last_state(states, lambda _: stop())
    vectors = vectors_of(problem, state.selection)
    value = float(evaluate(problem.objective, vectors))
    return replace(
        result,
        message=Message(
            "slack_taken" if state.proved else "slack_taken.mass_open", proof=result.message, slack=slack, pieces=pieces
        ),
        pieces=state.selection,
        value=value,
        lower_bound=min(result.lower_bound, value),
        vectors=vectors,
        residual=residual(problem.objective, vectors),
        evaluations=result.evaluations + fewest.evaluations + state.evaluations,
        details={**result.details, "slack_proved": float(state.proved)},
    )


def most_pieces(problem: SelectionProblem) -> int:
    """Pieces that all planes together can take at most."""
    in_the_box: int = sum(problem.stock.counts.tolist())
    return min(sum(slots(plane, problem.stock) for plane in problem.planes), in_the_box)
