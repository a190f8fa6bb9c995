"""Differential evolution in five variants (Storn and Price), with Deb's order instead of penalties.

standard: x_r3 + F (x_r1 - x_r2) · to_best: x_i + F (best - x_i) + F (x_r1 - x_r2), "parent centric" in the gear-pair
thesis · jitter: best + (F + 1e-4 U)(x_r1 - x_r2), U per element · dither_per_vector and dither_per_generation: standard
with F + (1 - F) U. Crossover is binomial with one coordinate forced. A coordinate out of its range is put between the
base and the bound. A trial is taken if it is not worse.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, get_args

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.population import Population
from service.optimize.problem import FloatArray, MixedProblem
from service.optimize.search import Progress

Variant = Literal["standard", "to_best", "jitter", "dither_per_vector", "dither_per_generation"]
VARIANTS: tuple[Variant, ...] = get_args(Variant)
SCALE, CROSSOVER = 0.85, 0.5
"""F is not given in the thesis; 0.85 is assumed. CR is."""
JITTER = 1e-4


class DifferentialEvolution(Iterator[Progress]):
    """Iterator over generations; the first one is the initial population. start: optional (k, d) first members."""

    def __init__(
        self,
        problem: MixedProblem,
        members: int,
        rng: np.random.Generator,
        variant: Variant = "standard",
        *,
        scale: float = SCALE,
        crossover: float = CROSSOVER,
        start: FloatArray | None = None,
    ) -> None:
        if variant not in VARIANTS:
            raise NumericsError(
                Message("search_variant", known=tuple(VARIANTS), value=variant), field="variant", value=variant
            )
        if not (0.0 < scale <= 2.0 and 0.0 <= crossover <= 1.0):
            raise NumericsError(Message("search_rates", scale=scale, crossover=crossover), field="scale", value=scale)
        self._rng, self._variant, self._scale, self._crossover = rng, variant, scale, crossover
        self._problem, self._members, self._start = problem, members, start
        self.population: Population | None = None

    def __next__(self) -> Progress:
        """Advance by one generation."""
        if self.population is None:
            self.population = Population.random(self._problem, self._members, self._rng, self._start)
            return self.population.progress()
        population = self.population
        base, mutant = self._mutants(population)
        lower, upper = self._problem.lower, self._problem.upper
        chance = self._rng.random(mutant.shape)
        mutant = np.where(mutant < lower, base + chance * (lower - base), mutant)
        mutant = np.where(mutant > upper, base + chance * (upper - base), mutant)
        n, d = mutant.shape
        crossed = self._rng.random((n, d)) < self._crossover
        crossed[np.arange(n), self._rng.integers(d, size=n)] = True
        population.take_better(self._problem.snap(np.where(crossed, mutant, population.x)), equal=True)
        population.number += 1
        return population.progress()

    def _mutants(self, population: Population) -> tuple[FloatArray, FloatArray]:
        """Base vectors and mutants (n, d)."""
        x, rng, F = population.x, self._rng, self._scale
        n, d = x.shape
        # Three members for each, all different and different from it: the first of a random order without itself.
        ranks = rng.random((n, n))
        np.fill_diagonal(ranks, 2.0)
        r1, r2, r3 = np.argpartition(ranks, 3, axis=1)[:, :3].T
        difference = x[r1] - x[r2]
        best = x[int(population.order()[0])]
        if self._variant == "to_best":
            return x, x + F * (best - x) + F * difference
        if self._variant == "jitter":
            base = np.broadcast_to(best, x.shape)
            return base, base + (F + JITTER * rng.random((n, d))) * difference
        if self._variant == "dither_per_vector":
            return x[r3], x[r3] + (F + (1.0 - F) * rng.random((n, 1))) * difference
        if self._variant == "dither_per_generation":
            return x[r3], x[r3] + (F + (1.0 - F) * rng.random()) * difference
        return x[r3], x[r3] + F * difference
