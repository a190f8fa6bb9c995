"""Which solvers a method of a plan runs, under one deadline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from db.documents.plan import Method
from service.balancing.exact import exact_result, search_exact
from service.balancing.jaya import solve_jaya
from service.balancing.placements import Selection
from service.balancing.selection import SelectionProblem, SelectionResult

JAYA_SHARE = 0.2
"""Share of the time limit that `certified` leaves to the modified Jaya."""

PATIENCE = 24
"""Steps of the exact search before it may end `within_uncertainty`; what takes fewer is proved in full.

Steps, not seconds, so that the same session gives the same answer on a busy machine.
"""


@dataclass(frozen=True)
class Part:
    """What one method found by itself."""

    method: Method
    result: SelectionResult
    seconds: float


@dataclass(frozen=True)
class Solved:
    """The answer, and the methods it comes from."""

    result: SelectionResult
    parts: tuple[Part, ...]
    seconds: float


def run_method(
    problem: SelectionProblem,
    method: Method,
    seed: int,
    limit_s: float,
    monotonic: Callable[[], float],
    uncertainty: float = 0.0,
) -> Solved:
    """Solve within `limit_s` seconds of `monotonic`; the best selection so far is returned when they are over.

    uncertainty: what the measurement cannot tell, in the objective's unit; a smaller gap is not worth a long search.
    """
    begun = monotonic()
    parts: list[Part] = []

    def over(share: float) -> Callable[[], bool]:
        return lambda: monotonic() - begun >= share * limit_s

    def add(name: Method, solve: Callable[[], SelectionResult]) -> SelectionResult:
        start = monotonic()
        result = solve()
        parts.append(Part(name, result, monotonic() - start))
        return result

    result: SelectionResult | None = None
    if method != "exact":
        share = JAYA_SHARE if method == "certified" else 1.0
        result = add("modified_jaya", lambda: solve_jaya(problem, seed, stop=over(share)))
    if method != "modified_jaya":
        start = None if result is None else result.pieces
        result = add("exact", lambda: prove(problem, start, over(1.0), uncertainty))
    assert result is not None  # noqa: S101
    return Solved(result, tuple(parts), monotonic() - begun)


def prove(
    problem: SelectionProblem, start: Selection | None, stop: Callable[[], bool], uncertainty: float
) -> SelectionResult:
    """The exact search, ended when it has proved its best, when `stop()` says so, or when more is not worth it."""
    for step, state in enumerate(search_exact(problem, start=start)):
        near = step >= PATIENCE and state.value - state.lower_bound <= uncertainty
        if state.proved or near or stop():
            break
    return exact_result(problem, state, uncertainty)
