"""Run the methods of a plan under one deadline."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from service.balancing.selection.alternatives import prefer, solve_fewest
from service.balancing.selection.certified import FIRST_GENERATIONS, FIRST_MEMBERS
from service.balancing.selection.exact.search import ExactState, exact_result, last_state, search_exact
from service.balancing.selection.jaya import budget, runs_together, solve_jaya
from service.balancing.selection.placements import Selection, result_of
from service.balancing.selection.problem import SelectionProblem, SelectionResult, Status
from service.errors import InvalidInput
from service.messages import Message, Word
from service.model.plan import Method, PlanRequest

JAYA_RUNS = 4
"""Independent runs of the modified Jaya where it answers alone; how many agree says how far to trust it."""
JAYA_SHARE = 0.2
"""Share of the time limit that `certified` leaves to the modified Jaya."""
MIN_SHARE = 0.75
"""Share of the time limit for the proof of the fewest masses; after it, any number that meets the limit is searched."""
PATIENCE = 256
"""Steps of the exact search before it may end `within_uncertainty`; what takes fewer is proved in full.

Steps, not seconds, so that the same session gives the same answer on a busy machine.
"""


@dataclass(frozen=True)
class Part:
    """What one method found by itself."""

    method: Method
    result: SelectionResult
    seconds: float


@dataclass
class Solved:
    """The answer, the methods it comes from, and the next best selections."""

    parts: list[Part] = field(default_factory=list)
    others: tuple[SelectionResult, ...] = ()
    seconds: float = 0.0

    @property
    def result(self) -> SelectionResult:
        """The answer: that of the last method."""
        return self.parts[-1].result


def run_method(
    problem: SelectionProblem,
    request: PlanRequest,
    uncertainty: float,
    monotonic: Callable[[], float],
    now: float | None = None,
) -> Solved:
    """Solve within the request's time limit on `monotonic`; the best selection so far is returned when it is over.

    uncertainty: what the measurement cannot tell, in the objective's unit; a smaller gap is not worth a long search.
    now: objective of the masses that are fitted, for mode combine.
    Raises InvalidInput for a mode without its limit, or a wish that mode or method cannot fulfil.
    """
    _refuse_unheard(request)
    begun = monotonic()
    solved = Solved()

    def over(share: float = 1.0) -> Callable[[], bool]:
        return lambda: monotonic() - begun >= share * request.time_limit_s

    def add(name: Method, solve: Callable[[], SelectionResult]) -> None:
        start = monotonic()
        result = solve()
        solved.parts.append(Part(name, result, monotonic() - start))

    if request.mode != "best":
        limit = limit_of_mode(request, now)
        add("exact", lambda: _fewest(problem, limit, over(MIN_SHARE), over()))
    else:
        if request.method == "modified_jaya":
            runs = min(JAYA_RUNS, runs_together(problem, budget(problem, as_published=False)[0]))
            add("modified_jaya", lambda: solve_jaya(problem, request.seed, runs=runs, stop=over()))
        elif request.method == "certified":
            add("modified_jaya", lambda: _first_answer(problem, request.seed, over(JAYA_SHARE)))
        if request.method != "modified_jaya":
            start = solved.result.pieces if solved.parts else None

            def exact() -> SelectionResult:
                found = prove(problem, start, request.alternatives, uncertainty, over())
                solved.others = _others(problem, found, uncertainty)
                return prefer(problem, exact_result(problem, found, uncertainty), request.slack, stop=over())

            add("exact", exact)
    solved.seconds = monotonic() - begun
    return solved


def prove(
    problem: SelectionProblem,
    start: Selection | None,
    alternatives: int,
    uncertainty: float,
    stop: Callable[[], bool],
) -> ExactState:
    """The exact search, ended when it has proved its best, when `stop()` says so, or when more is not worth it.

    Worth it is what could be better than the last of the alternatives, not only than the best.
    """
    steps = 0

    def enough(state: ExactState) -> bool:
        nonlocal steps
        steps += 1
        gap = state.values[-1] - state.lower_bound if len(state.values) > alternatives else math.inf
        # A gap only just below what can be told is worth twice the steps: most are closed by then.
        patience = PATIENCE if gap <= 0.25 * uncertainty else 2 * PATIENCE
        return state.proved or (gap <= uncertainty and steps > patience) or stop()

    return last_state(search_exact(problem, start=start, keep=1 + alternatives), enough, patient=True)


def limit_of_mode(request: PlanRequest, now: float | None) -> float:
    """Limit that the fewest masses have to meet; `now` is what those that are fitted come to.

    Raises InvalidInput where none is stated, or the method proves none.
    """
    if request.method == "modified_jaya":
        raise InvalidInput(
            Message("invalid_input.jaya_proves_nothing", mode=request.mode), field="method", value=request.method
        )
    if request.limit is not None:
        return request.limit
    if now is not None:
        return now
    if request.objective == "residual_vibration" and request.norm in (None, "max"):
        return 1.0
    raise InvalidInput(Message("invalid_input.limit_missing", objective=request.objective), field="limit", value=None)


def _fewest(
    problem: SelectionProblem, limit: float, late: Callable[[], bool], stop: Callable[[], bool]
) -> SelectionResult:
    """The fewest masses that meet the limit; where there is no time to prove them, some that meet it."""
    found = solve_fewest(problem, limit, stop=late)
    if found.status != "limit_reached" or found.value <= limit:
        return found
    state = last_state(search_exact(problem), lambda now: now.value <= limit or now.proved or stop(), patient=True)
    if state.value > limit:
        return found
    pieces = sum(map(len, state.selection))
    message = Message("limit_met.open_between", pieces=pieces, least=found.details["at_least"])
    evaluations = found.evaluations + state.evaluations
    return result_of(
        problem, state.selection, "limit_reached", message, evaluations, state.lower_bound, details=found.details
    )


def _first_answer(problem: SelectionProblem, seed: int, stop: Callable[[], bool]) -> SelectionResult:
    """A short run of the modified Jaya: the exact search needs only something to compare with."""
    return solve_jaya(problem, seed, members=FIRST_MEMBERS, generations=FIRST_GENERATIONS, stop=stop)


def _refuse_unheard(request: PlanRequest) -> None:
    """Raise InvalidInput for what this mode or method would pass over in silence."""
    unheard: list[tuple[str, object, Word]] = []
    if request.mode != "best" or request.method == "modified_jaya":
        unheard += [("alternatives", request.alternatives, Word("mode_best"))]
        unheard += [("slack", request.slack, Word("mode_best"))]
    if request.mode == "best":
        unheard += [("limit", request.limit, Word("mode_fewest"))]
    for field_name, value, belongs_to in unheard:
        if value:
            raise InvalidInput(
                Message(
                    "invalid_input.option_without_meaning",
                    name=field_name,
                    value=value,
                    mode=request.mode,
                    method=request.method,
                    others=belongs_to,
                ),
                field=field_name,
                value=value,
            )


def _others(problem: SelectionProblem, state: ExactState, uncertainty: float) -> tuple[SelectionResult, ...]:
    """The next best selections of a search, with the bound of them all; proved means that nothing comes between."""
    out = []
    for rank, (selection, value) in enumerate(zip(state.selections[1:], state.values[1:], strict=True), start=1):
        gap = value - state.lower_bound
        status: Status = "limit_reached"
        message = Message("selection_stopped", gap=gap)
        if state.proved:
            status = "optimal"
            message = Message("selection_proved.ranked", count=rank)
        elif gap <= uncertainty:
            status = "within_uncertainty"
            message = Message("selection_within_uncertainty", gap=gap)
        out.append(result_of(problem, selection, status, message, state.evaluations, state.lower_bound))
    return tuple(out)
