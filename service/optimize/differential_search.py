"""Differential Search (Civicioglu; the author's code of 2013), with Deb's order.

Per generation a set of directions, a map of active coordinates for each member, and one scalar R for all; a stopover
x + R map (direction - x) replaces its member if it is strictly better. A component out of its range is drawn anew or
put on the bound, as chance has it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, get_args

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.population import Population
from service.optimize.problem import FloatArray, MixedProblem
from service.optimize.search import Progress

Directions = Literal["bijective", "surjective", "elitist_1", "elitist_2"]
Step = Literal["2013", "2012", "normal"]


class DifferentialSearch(Iterator[Progress]):
    """Iterator over generations; the first one is the initial population.

    directions: a permutation of the population, members of the best, one member of random rank, or the best.
    step: R = 1 / Gamma(1, 0.5), R = Gamma(2U, 1)(U - U), or 4 N(0, 1). start: optional (k, d) first members.
    """

    def __init__(
        self,
        problem: MixedProblem,
        members: int,
        rng: np.random.Generator,
        directions: Directions = "bijective",
        *,
        step: Step = "2013",
        start: FloatArray | None = None,
    ) -> None:
        if directions not in get_args(Directions) or step not in get_args(Step):
            raise NumericsError(
                Message("search_variant.differential_search", directions=directions, step=step), field="directions"
            )
        self._problem, self._members, self._rng, self._start = problem, members, rng, start
        self._directions, self._step = directions, step
        self.population: Population | None = None

    def __next__(self) -> Progress:
        """Advance by one generation."""
        if self.population is None:
            self.population = Population.random(self._problem, self._members, self._rng, self._start)
            return self.population.progress()
        population = self.population
        towards = self._towards(population)
        moved = population.x + self._scalar() * self._map(population.x.shape) * (towards - population.x)
        population.take_better(self._problem.snap(self._within(moved)))
        population.number += 1
        return population.progress()

    def _towards(self, population: Population) -> FloatArray:
        x, rng = population.x, self._rng
        n = len(x)
        if self._directions == "bijective":
            return np.asarray(x[rng.permutation(n)])
        order = population.order()
        if self._directions == "surjective":
            top = max(1, math.ceil(rng.random() * n))
            return np.asarray(x[order[rng.integers(top, size=n)]])
        if self._directions == "elitist_1":
            return np.broadcast_to(x[order[max(0, math.ceil(rng.random() * n) - 1)]], x.shape)
        return np.broadcast_to(x[order[0]], x.shape)

    def _scalar(self) -> float:
        rng = self._rng
        if self._step == "2013":
            return 1.0 / max(float(rng.gamma(1.0, 0.5)), 1e-300)
        if self._step == "2012":
            return float(rng.gamma(2.0 * rng.random(), 1.0) * (rng.random() - rng.random()))
        return 4.0 * float(rng.standard_normal())

    def _map(self, shape: tuple[int, ...]) -> FloatArray:
        """Active coordinates (n, d), as 0 and 1; one strategy for the whole generation."""
        rng = self._rng
        n, d = shape
        p1, p2 = 0.3 * rng.random(), 0.3 * rng.random()
        active = np.zeros((n, d))
        if rng.random() < rng.random():
            if rng.random() < p1:
                return np.asarray((rng.random((n, d)) < rng.random((n, 1))).astype(np.float64))
            active[np.arange(n), rng.integers(d, size=n)] = 1.0
            return active
        drawn = rng.integers(d, size=(n, math.ceil(p2 * d)))
        np.put_along_axis(active, drawn, 1.0, axis=1)
        return active

    def _within(self, x: FloatArray) -> FloatArray:
        lower, upper, rng = self._problem.lower, self._problem.upper, self._rng
        drawn = rng.uniform(lower, upper, x.shape)
        anew = rng.random(x.shape) < rng.random(x.shape)
        outside = (x < lower) | (x > upper)
        return np.asarray(np.where(outside & anew, drawn, np.clip(x, lower, upper)))
