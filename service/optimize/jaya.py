"""Modified Jaya for mixed variables: no tuning parameter besides population size and generations.

`rules="published"` is the algorithm as printed (thesis, chapter 4 and appendix B, without its slips of code):
x' = x + r1 (best - |x|) - r2 (worst - |x|), a fixed penalty of 1e5 per violated constraint, greedy acceptance.
`rules="improved"` drops the modulus, which fails where an optimum is negative; ranks feasible before infeasible, two
feasible by objective, two infeasible by total violation (Deb 2000); takes as "worst" of each member a random member of
lower rank; and draws everybody but the best anew when the population has collapsed to one value.

Several independent runs advance together: populations are (runs, members, d).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from service.errors import NumericsError
from service.messages import Message
from service.optimize.problem import FEASIBILITY, FloatArray, MixedProblem, validate

Rules = Literal["improved", "published"]
Stop = Callable[[], bool]
BoolArray = NDArray[np.bool_]

PENALTY = 1e5
"""Added per violated constraint, published form (Eq 4.2)."""
COLLAPSED = 1e-9
"""Relative spread of the objective below which a population has collapsed."""


@dataclass(frozen=True)
class Generation:
    """State after one generation: best member of all runs; violation is 0 where it is feasible."""

    number: int
    x: FloatArray
    value: float
    violation: float
    evaluations: int


@dataclass(frozen=True)
class JayaResult:
    """Best member of all runs, and of each run.

    status: `budget_spent` or `stopped`. x: (d,). values: (runs,) objective of each run's best, inf where that best
    is infeasible. seed: as given to `solve`, to repeat it.
    """

    status: Literal["budget_spent", "stopped"]
    x: FloatArray
    value: float
    violation: float
    values: FloatArray
    generations: int
    evaluations: int
    seed: int


class Jaya(Iterator[Generation]):
    """Iterator over generations; the first one is the initial population.

    problem: validated here. members: population size, at least 2. start: optional (k, d), first members of every run.
    """

    def __init__(
        self,
        problem: MixedProblem,
        members: int,
        rng: np.random.Generator,
        *,
        runs: int = 1,
        rules: Rules = "improved",
        start: FloatArray | None = None,
    ) -> None:
        validate(problem)
        if members < 2 or runs < 1:
            raise NumericsError(Message("numerics.jaya_members", members=members, runs=runs))
        self._problem, self._rng, self._rules = problem, rng, rules
        self._lower, self._upper = problem.lower, problem.upper
        self._shape = (runs, members, len(problem.variables))
        self._rows = np.arange(runs)[:, None]
        # A circle has no bounds; away from circles a turn of nothing is taken off, however far.
        circular = problem.periods > 0.0
        self._least = np.where(circular, -np.inf, self._lower)
        self._most = np.where(circular, np.inf, self._upper)
        self._turn, self._around = problem.periods, np.where(circular, problem.periods, np.inf)
        self._start = start
        self.generation = 0
        self.evaluations = 0
        self.x = np.empty(self._shape)
        self.value = np.full((runs, members), np.inf)
        self.violation = np.full((runs, members), np.inf)

    def __next__(self) -> Generation:
        """Advance every run by one generation."""
        if self.generation == 0:
            self._accept(self._first(), np.ones(self._shape[:2], dtype=bool))
        else:
            self._order()
            fresh = self._collapsed()
            moved = self._published_step() if self._rules == "published" else self._improved_step()
            if fresh.any():
                moved = np.where(fresh[:, :, None], self._random(), moved)
            self._accept(self._within(moved), fresh)
        self.generation += 1
        return self._best()

    def run_values(self) -> FloatArray:
        """Objective of each run's best feasible member, (runs,); inf where there is none."""
        return np.asarray(np.where(self.violation <= 0.0, self.value, np.inf).min(axis=1), dtype=np.float64)

    def run_bests(self) -> FloatArray:
        """Each run's best member, (runs, d)."""
        best = np.lexsort(self._keys(), axis=1)[:, 0]
        return np.asarray(self.x[np.arange(len(best)), best], dtype=np.float64)

    def _random(self) -> FloatArray:
        return self._rng.uniform(self._lower, self._upper, self._shape)

    def _first(self) -> FloatArray:
        x = self._random()
        if self._start is not None:
            given = self._start[: self._shape[1]]
            x[:, : len(given)] = given
        return self._within(x)

    def _within(self, x: FloatArray) -> FloatArray:
        x = np.minimum(np.maximum(x, self._least), self._most)
        return self._problem.snap(x.reshape(-1, self._shape[2])).reshape(self._shape)

    def _order(self) -> None:
        """Sort every run from best to worst."""
        rank = np.lexsort(self._keys(), axis=1)
        self.x = self.x[self._rows, rank]
        self.value = self.value[self._rows, rank]
        self.violation = self.violation[self._rows, rank]

    def _keys(self) -> tuple[FloatArray, FloatArray]:
        """Sort keys, the last one first: violation before objective, or the penalised objective alone."""
        if self._rules == "published":
            return self.violation, self.value
        return np.where(self.violation > 0.0, 0.0, self.value), self.violation

    def _collapsed(self) -> BoolArray:
        """Whom to draw anew, (runs, members)."""
        fresh = np.zeros(self._shape[:2], dtype=bool)
        if self._rules == "improved":
            spread = self.value.max(axis=1) - self.value.min(axis=1)
            fresh[:] = (spread <= COLLAPSED * np.abs(self.value.min(axis=1)))[:, None]
            fresh &= (self.violation.max(axis=1) <= self.violation.min(axis=1))[:, None]
            fresh[:, 0] = False
        return fresh

    def _difference(self, target: FloatArray, x: FloatArray) -> FloatArray:
        """Target - x, the short way round for circular variables."""
        away = target - x
        return np.asarray(away - self._turn * np.round(away / self._around))

    def _published_step(self) -> FloatArray:
        r1, r2 = self._rng.random(self._shape), self._rng.random(self._shape)
        size = np.abs(self.x)
        return np.asarray(self.x + r1 * (self.x[:, :1] - size) - r2 * (self.x[:, -1:] - size))

    def _improved_step(self) -> FloatArray:
        runs, members, _ = self._shape
        r1, r2 = self._rng.random(self._shape), self._rng.random(self._shape)
        below = np.minimum(np.arange(members) + 1, members - 1)
        worse = self._rng.integers(below, members, size=(runs, members))
        bad = self.x[self._rows, worse]
        return np.asarray(self.x + r1 * self._difference(self.x[:, :1], self.x) - r2 * self._difference(bad, self.x))

    def _accept(self, x: FloatArray, anyway: BoolArray) -> None:
        """Keep a moved member where it is strictly better, or `anyway`."""
        runs, members, d = self._shape
        value, g = self._problem.evaluate(x.reshape(-1, d))
        over = np.where(g > FEASIBILITY, g, 0.0)
        violation = over.sum(axis=1).reshape(runs, members)
        value = np.where(np.isnan(value), np.inf, value).reshape(runs, members)
        if self._rules == "published":
            value = value + PENALTY * (over > 0.0).sum(axis=1).reshape(runs, members)
            better = value < self.value
        else:
            both_feasible = (violation <= 0.0) & (self.violation <= 0.0)
            better = np.where(both_feasible, value < self.value, violation < self.violation)
        keep = better | anyway
        self.x = np.where(keep[:, :, None], x, self.x)
        self.value = np.where(keep, value, self.value)
        self.violation = np.where(keep, violation, self.violation)
        self.evaluations += runs * members

    def _best(self) -> Generation:
        second, first = self._keys()
        run, member = divmod(int(np.lexsort((second.ravel(), first.ravel()))[0]), self._shape[1])
        return Generation(
            number=self.generation,
            x=self.x[run, member].copy(),
            value=float(self.value[run, member]),
            violation=float(self.violation[run, member]),
            evaluations=self.evaluations,
        )


def solve(
    problem: MixedProblem,
    members: int,
    generations: int,
    seed: int,
    *,
    runs: int = 1,
    rules: Rules = "improved",
    stop: Stop = lambda: False,
) -> JayaResult:
    """Run `generations` generations, or until `stop()`; the initial population counts as the first of them."""
    if generations < 1:
        raise NumericsError(
            Message("numerics.generations", generations=generations), field="generations", value=generations
        )
    search = Jaya(problem, members, np.random.default_rng(seed), runs=runs, rules=rules)
    state = next(search)
    while state.number < generations and not stop():
        state = next(search)
    done = state.number >= generations
    return JayaResult(
        status="budget_spent" if done else "stopped",
        x=state.x,
        value=state.value,
        violation=state.violation,
        values=search.run_values(),
        generations=state.number,
        evaluations=state.evaluations,
        seed=seed,
    )
