"""The contract of every search: an iterator whose steps tell the best so far, and one loop that bounds it.

A search takes an explicit random generator; the loop takes a stop, and a deadline on a clock that it is given. The
same seed and budget give the same answer, whatever the deadline, as long as it is not reached.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.problem import FEASIBILITY, FloatArray

Status = Literal["optimal", "converged", "limit_reached", "stopped", "infeasible"]
Stop = Callable[[], bool]
Clock = Callable[[], float]


def never() -> bool:
    """A stop that does not."""
    return False


def no_clock() -> float:
    """A clock that stands still: no deadline is reached."""
    return 0.0


@dataclass(frozen=True)
class Progress:
    """The best after one step. violation: sum of scaled constraints above their tolerance, 0 where feasible."""

    number: int
    x: FloatArray
    value: float
    violation: float
    evaluations: int


class Search(Protocol):
    """An iterator of progress that can say whether it has converged, and with what evidence."""

    def __next__(self) -> Progress:
        """Advance by one step; raises StopIteration when there is nothing left to try."""

    def __iter__(self) -> Iterator[Progress]:
        """The search itself."""


@dataclass(frozen=True)
class Evidence:
    """What speaks for an answer.

    kind: proved_bound, kkt, starts_agree or none. bound: proved limit of the objective; residual: greatest of
    stationarity, feasibility and complementarity; agreeing: starts that ended within 1e-6 of the best, of starts.
    """

    kind: Literal["proved_bound", "kkt", "starts_agree", "none"]
    bound: float | None = None
    residual: float | None = None
    agreeing: int | None = None
    starts: int | None = None


@dataclass(frozen=True)
class SearchResult:
    """Outcome of a search. history: rows (evaluations, value, violation) where the best became better."""

    status: Status
    x: FloatArray
    value: float
    violation: float
    steps: int
    evaluations: int
    seconds: float
    seed: int
    evidence: Evidence = Evidence("none")
    history: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def feasible(self) -> bool:
        """Whether no constraint is violated."""
        return self.violation <= 0.0


def run(
    search: Search,
    steps: int,
    seed: int,
    *,
    stop: Stop = never,
    clock: Clock = no_clock,
    deadline_s: float = math.inf,
    watch: Callable[[Progress], None] = lambda _: None,
) -> SearchResult:
    """Advance a search by up to `steps` steps; at least one is taken. watch: called after each.

    seed: of the search's generator, kept in the result. Raises NumericsError for fewer than one step.
    """
    if steps < 1:
        raise NumericsError(Message("budget_too_small", value=steps), field="steps", value=steps)
    began = clock()
    best, history, status = next(search), [], "limit_reached"
    history.append((best.evaluations, best.value, best.violation))
    watch(best)
    while True:
        if best.number >= steps:
            break
        if stop():
            status = "stopped"
            break
        if clock() - began >= deadline_s:
            break
        try:
            now = next(search)
        except StopIteration:
            status = "converged"
            break
        if (now.violation, now.value) != (best.violation, best.value):
            history.append((now.evaluations, now.value, now.violation))
        best = now
        watch(best)
    if best.violation > 0.0:
        status = "infeasible" if status != "stopped" else status
    return SearchResult(
        status=status,  # type: ignore[arg-type]
        x=best.x,
        value=best.value,
        violation=best.violation,
        steps=best.number,
        evaluations=best.evaluations,
        seconds=clock() - began,
        seed=seed,
        history=np.array(history, dtype=np.float64),
    )


def total_violation(g: FloatArray) -> FloatArray:
    """Sum of the constraints (..., c) above their tolerance; infinite where one is not a number."""
    over = np.where(g > FEASIBILITY, g, 0.0)
    return np.asarray(np.where(np.isnan(g).any(axis=-1), np.inf, over.sum(axis=-1)))
