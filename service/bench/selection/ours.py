"""The product's own methods on one problem, run as a plan runs them."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass

import numpy as np

from service.balancing.selection.exact.search import ExactState, last_state, search_exact
from service.balancing.selection.jaya import budget, search_jaya
from service.balancing.selection.problem import SelectionResult
from service.bench.selection.problems import Case
from service.engine.plan_methods import run_method
from service.model.plan import Method, PlanRequest

REPEATS = 5
SAME = 1e-9
"""Values that agree to this part are the same."""


@dataclass(frozen=True)
class Answer:
    """A plan's answer and its median time, s."""

    result: SelectionResult
    seconds: float


@dataclass(frozen=True)
class Runs:
    """Values of one searcher's runs, and the time of a run, s. broken: runs that break a limit."""

    values: tuple[float, ...]
    seconds: float
    broken: int = 0

    def reached(self, optimum: float) -> int:
        """How many runs found the optimum."""
        return sum(value <= optimum * (1.0 + SAME) for value in self.values)

    @property
    def median(self) -> float:
        """Median value."""
        return statistics.median(self.values)


def request_of(method: Method, limit_s: float) -> PlanRequest:
    """A plan's request; its objective is the problem's."""
    return PlanRequest(correction_id="bench", objective="residual_vibration", method=method, time_limit_s=limit_s)


def answer_of(case: Case, method: Method, limit_s: float, repeats: int = REPEATS) -> Answer:
    """Solve as a plan does, once to warm up; a call that takes long is not repeated."""
    request = request_of(method, limit_s)
    taken = []
    for _ in range(repeats + 1):
        solved = run_method(case.problem, request, case.uncertainty, time.perf_counter)
        taken.append(solved.seconds)
        if solved.seconds > 2.0:
            break
    return Answer(solved.result, statistics.median(taken[1:] or taken))


def proved(case: Case, limit_s: float) -> tuple[ExactState, float]:
    """The exact search until the proof, whatever the readings can tell, or until the limit."""
    begun = time.perf_counter()
    state = last_state(search_exact(case.problem), lambda s: s.proved or time.perf_counter() - begun > limit_s)
    return state, time.perf_counter() - begun


def jaya_runs(case: Case, runs: int, *, as_published: bool, limit_s: float) -> Runs:
    """Independent runs of modified Jaya together, by their budget (population x generations) or until the limit.

    `seconds` is each run's share of the time.
    """
    rounds = budget(case.problem, as_published=as_published)[1]
    begun = time.perf_counter()
    search = search_jaya(case.problem, np.random.default_rng(1), runs=runs, as_published=as_published)
    state = next(search)
    while state.generation < rounds and time.perf_counter() - begun <= limit_s:
        state = next(search)
    return Runs(state.values, (time.perf_counter() - begun) / runs)


def budget_of(case: Case, *, as_published: bool) -> str:
    """Population x generations of one run."""
    members, generations = budget(case.problem, as_published=as_published)
    return f"{members} x {generations}"
