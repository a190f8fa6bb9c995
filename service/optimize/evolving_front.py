"""What evolutionary searches for fronts share: several objectives, a population, survival by rank and crowding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.front import crowding, front_ranks, undominated
from service.optimize.population import MIN_MEMBERS
from service.optimize.problem import FloatArray, IntArray
from service.optimize.search import total_violation

EvaluateAll = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class FrontSearchProblem:
    """Bounds (d,), and `evaluate`: (n, d) -> objectives (n, k), minimised, and scaled constraints (n, c) <= 0."""

    lower: FloatArray
    upper: FloatArray
    evaluate: EvaluateAll

    def __post_init__(self) -> None:
        """Refuse bounds that are crossed or not finite."""
        if not (np.isfinite(self.lower).all() and np.isfinite(self.upper).all() and (self.lower <= self.upper).all()):
            raise NumericsError(Message("bounds_crossed.some"), field="lower")


@dataclass(frozen=True)
class FrontGeneration:
    """State after one generation: feasible objectives (m, k) and designs (m, d) that no other dominates."""

    number: int
    objectives: FloatArray
    x: FloatArray
    evaluations: int


class Members:
    """A population with objectives (n, k), violations, ranks and crowding distances."""

    def __init__(self, problem: FrontSearchProblem, members: int, rng: np.random.Generator) -> None:
        if members < MIN_MEMBERS:
            raise NumericsError(
                Message("population_too_small", least=MIN_MEMBERS, value=members), field="members", value=members
            )
        self.problem, self.size, self.evaluations, self.number = problem, members, 0, 1
        self.x = rng.uniform(problem.lower, problem.upper, (members, len(problem.lower)))
        self.objectives, self.violation = self.evaluated(self.x)
        self.ranks: IntArray = np.zeros(members, dtype=np.int64)
        self.distance: FloatArray = np.zeros(members)
        self._keep(np.arange(members))

    def evaluated(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Objectives and violation of trials; what is not a number is infeasible."""
        objectives, g = self.problem.evaluate(x)
        self.evaluations += len(x)
        failed = np.asarray(np.isnan(objectives).any(axis=1))
        violation = np.where(failed, np.inf, total_violation(g))
        return np.where(failed[:, None], np.inf, objectives), violation

    def join(self, x: FloatArray) -> None:
        """Merge with trials and keep the best `size` by rank, then by crowding distance."""
        objectives, violation = self.evaluated(x)
        self.x = np.concatenate([self.x, x])
        self.objectives = np.concatenate([self.objectives, objectives])
        self.violation = np.concatenate([self.violation, violation])
        self._keep(None)

    def generation(self) -> FrontGeneration:
        """What the population has found."""
        good = np.flatnonzero((self.violation <= 0.0) & (self.ranks == 0))
        if self.objectives.shape[1] == 2 and good.size:
            good = good[undominated(self.objectives[good])]
        return FrontGeneration(self.number, self.objectives[good], self.x[good], self.evaluations)

    def _keep(self, kept: IntArray | None) -> None:
        ranks = front_ranks(self.objectives, self.violation)
        distance = np.zeros(len(ranks))
        for rank in range(int(ranks.max()) + 1):
            members = np.flatnonzero(ranks == rank)
            distance[members] = crowding(self.objectives[members])
        chosen = np.lexsort((-distance, ranks))[: self.size] if kept is None else np.lexsort((-distance, ranks))
        self.x, self.objectives, self.violation = self.x[chosen], self.objectives[chosen], self.violation[chosen]
        self.ranks, self.distance = ranks[chosen], distance[chosen]
