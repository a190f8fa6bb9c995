"""Which solvers a method of a plan runs, under one deadline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from db.documents.plan import Method
from service.balancing.exhaustive import solve_exhaustive
from service.balancing.jaya import solve_jaya
from service.balancing.selection import SelectionProblem, SelectionResult


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

    def over() -> bool:
        return monotonic() - begun >= limit_s

    def timed(name: Method) -> Part:
        start = monotonic()
        result = solve_exhaustive(problem) if name == "exact" else solve_jaya(problem, seed, stop=over)
        return Part(name, result, monotonic() - start)

    part = timed("exact" if method == "exact" else "modified_jaya")
    return Solved(part.result, (part,), monotonic() - begun)
