"""Which solvers a method of a plan runs, under one deadline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from db.documents.plan import Method
from service.balancing.exact import solve_exact
from service.balancing.jaya import solve_jaya
from service.balancing.selection import SelectionProblem, SelectionResult

JAYA_SHARE = 0.2
"""Share of the time limit that `certified` leaves to the modified Jaya."""


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
    problem: SelectionProblem, method: Method, seed: int, limit_s: float, monotonic: Callable[[], float]
) -> Solved:
    """Solve within `limit_s` seconds of `monotonic`; the best selection so far is returned when they are over."""
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
        result = add("exact", lambda: solve_exact(problem, start=start, stop=over(1.0)))
    assert result is not None  # noqa: S101
    return Solved(result, tuple(parts), monotonic() - begun)
