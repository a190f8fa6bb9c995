"""The default method: modified Jaya for a first answer, the exact search to improve and prove it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.selection.exact.search import ExactState, Stop, exact_result, never, search_exact
from service.balancing.selection.jaya import JayaState, search_jaya
from service.balancing.selection.placements import result_of
from service.balancing.selection.problem import SelectionProblem, SelectionResult
from service.messages import Message

FIRST_MEMBERS, FIRST_GENERATIONS = 20, 15
"""Budget of the first answer; the exact search needs only something to compare with."""


@dataclass(frozen=True)
class CertifiedState:
    """After one step: where modified Jaya stands, and the exact search once it has begun."""

    first: JayaState
    exact: ExactState | None = None

    @property
    def value(self) -> float:
        """Best value so far."""
        return self.first.value if self.exact is None else self.exact.value

    @property
    def lower_bound(self) -> float:
        """What no selection is below; 0 before the exact search has begun."""
        return 0.0 if self.exact is None else self.exact.lower_bound

    @property
    def proved(self) -> bool:
        """Whether nothing better is left."""
        return self.exact is not None and self.exact.proved


@dataclass(frozen=True)
class Certified:
    """What modified Jaya found by itself (`first`), and the answer (`result`).

    details of `result`: `seed`, `first_value`, and `improvement`, the part by which the answer is below it.
    """

    first: SelectionResult
    result: SelectionResult


def search_certified(problem: SelectionProblem, seed: int) -> Iterator[CertifiedState]:
    """Return an iterator over both methods' steps, ending with the proof or with what memory allows."""
    for jaya in search_jaya(problem, np.random.default_rng(seed), members=FIRST_MEMBERS):
        yield CertifiedState(jaya)
        if jaya.generation == FIRST_GENERATIONS:
            for exact in search_exact(problem, start=jaya.selection):
                yield CertifiedState(jaya, exact)
            return


def solve_certified(problem: SelectionProblem, seed: int, *, uncertainty: float = 0.0, stop: Stop = never) -> Certified:
    """Best selection with its proof; status and message of `result` as in `exact.solve_exact`.

    uncertainty: in the objective's unit; what could be better by less is not searched for. `stop()` is asked between
    steps of some ten milliseconds. Raises NumericsError for an invalid problem.
    """
    for state in search_certified(problem, seed):
        if stop() or (state.exact is not None and state.value - state.lower_bound <= uncertainty):
            break
        if stop is never and state.exact is not None and state.exact.exhausted:
            break
    return certified_result(problem, seed, state, uncertainty)


def certified_result(
    problem: SelectionProblem, seed: int, state: CertifiedState, uncertainty: float = 0.0
) -> Certified:
    """Results of a search that ended in `state`; both are modified Jaya's where the exact search had not begun."""
    jaya = state.first
    first = result_of(
        problem,
        jaya.selection,
        "heuristic",
        Message("jaya_first", generations=jaya.generation, members=FIRST_MEMBERS),
        jaya.evaluations,
        details={"generations": jaya.generation, "members": FIRST_MEMBERS, "seed": seed},
    )
    if state.exact is None:
        return Certified(first, first)
    found = exact_result(problem, state.exact, uncertainty)
    improvement = (first.value - found.value) / first.value if first.value > 0.0 else 0.0
    return Certified(
        first,
        replace(
            found,
            evaluations=first.evaluations + found.evaluations,
            details={"seed": seed, "first_value": first.value, "improvement": improvement},
        ),
    )
