"""What searches that use values alone share: a checked population, its evaluation and Deb's order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.errors import NumericsError
from service.messages import Message
from service.optimize.problem import FloatArray, IntArray, MixedProblem, validate
from service.optimize.search import Progress, total_violation

BoolArray = NDArray[np.bool_]
MIN_MEMBERS = 4


@dataclass
class Population:
    """Members x (n, d), objective (n,), violation (n,); evaluations counts every call, the first ones included.

    failures: evaluations that were not a number; they count as infeasible.
    """

    problem: MixedProblem
    x: FloatArray
    value: FloatArray
    violation: FloatArray
    evaluations: int
    failures: int = 0
    number: int = 1

    @classmethod
    def random(
        cls, problem: MixedProblem, members: int, rng: np.random.Generator, start: FloatArray | None = None
    ) -> Population:
        """Uniform members; the first ones are those of `start` (k, d). Raises NumericsError for fewer than 4."""
        validate(problem)
        if members < MIN_MEMBERS:
            raise NumericsError(
                Message("population_too_small", least=MIN_MEMBERS, value=members), field="members", value=members
            )
        x = rng.uniform(problem.lower, problem.upper, (members, len(problem.variables)))
        if start is not None:
            x[: len(start)] = start[:members]
        x = problem.snap(np.clip(x, problem.lower, problem.upper))
        population = cls(problem, x, np.empty(members), np.empty(members), 0)
        population.value, population.violation = population.evaluated(x)
        return population

    def evaluated(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Objective and violation (n,) of trials (n, d)."""
        value, g = self.problem.evaluate(x)
        failed = np.isnan(value)
        self.evaluations += len(x)
        self.failures += int(failed.sum())
        violation = total_violation(g)
        return np.where(failed, np.inf, value), np.where(failed, np.inf, violation)

    def order(self) -> IntArray:
        """Indices from best to worst: feasible first, then by objective, infeasible ones by violation."""
        return np.lexsort((np.where(self.violation > 0.0, 0.0, self.value), self.violation))

    def take_better(self, x: FloatArray, *, equal: bool = False) -> None:
        """Replace members by trials (n, d) that are strictly better (or as good)."""
        value, violation = self.evaluated(x)
        both = (violation <= 0.0) & (self.violation <= 0.0)
        better = np.where(both, value < self.value, violation < self.violation)
        if equal:
            better |= (violation == self.violation) & (value == self.value)
        self.x = np.where(better[:, None], x, self.x)
        self.value = np.where(better, value, self.value)
        self.violation = np.where(better, violation, self.violation)

    def progress(self) -> Progress:
        """The best member."""
        best = int(self.order()[0])
        return Progress(
            self.number, self.x[best].copy(), float(self.value[best]), float(self.violation[best]), self.evaluations
        )
