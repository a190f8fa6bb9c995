"""NSGA-II (Deb and others, 2002): binary tournaments, simulated binary crossover, polynomial mutation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from service.optimize.evolving_front import FrontGeneration, FrontSearchProblem, Members
from service.optimize.problem import FloatArray

CROSSOVER_ETA, CROSSOVER_RATE, MUTATION_ETA = 15.0, 0.9, 20.0
SAME = 1e-14


class Nsga2(Iterator[FrontGeneration]):
    """Iterator over generations; the first one is the initial population."""

    def __init__(self, problem: FrontSearchProblem, members: int, rng: np.random.Generator) -> None:
        self._problem, self._size, self._rng = problem, members, rng
        self.members: Members | None = None

    def __next__(self) -> FrontGeneration:
        """Advance by one generation."""
        if self.members is None:
            self.members = Members(self._problem, self._size, self._rng)
            return self.members.generation()
        members = self.members
        parents = members.x[self._tournament(members)]
        members.join(self._mutated(self._crossed(parents))[: self._size])
        members.number += 1
        return members.generation()

    def _tournament(self, members: Members) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
        """Winners of two by two; an even number of them."""
        count = self._size + self._size % 2
        pairs = self._rng.integers(len(members.x), size=(count, 2))
        # Members are kept sorted by rank and crowding distance: the lower index is the better one.
        return np.asarray(pairs.min(axis=1))

    def _crossed(self, parents: FloatArray) -> FloatArray:
        rng, (lower, upper) = self._rng, (self._problem.lower, self._problem.upper)
        first, second = parents[::2], parents[1::2]
        low, high = np.minimum(first, second), np.maximum(first, second)
        gap = high - low
        apart = gap > SAME
        width = np.where(apart, gap, 1.0)
        u = rng.random(first.shape)

        def spread(room: FloatArray) -> FloatArray:
            alpha = 2.0 - (1.0 + 2.0 * room / width) ** -(CROSSOVER_ETA + 1.0)
            inner = u * alpha
            power = 1.0 / (CROSSOVER_ETA + 1.0)
            return np.asarray(np.where(u <= 1.0 / alpha, inner**power, (1.0 / np.maximum(2.0 - inner, SAME)) ** power))

        one = 0.5 * (low + high - spread(low - lower) * gap)
        other = 0.5 * (low + high + spread(upper - high) * gap)
        swapped = rng.random(first.shape) < 0.5
        one, other = np.where(swapped, other, one), np.where(swapped, one, other)
        crossed = apart & (rng.random(first.shape) < 0.5) & (rng.random((len(first), 1)) < CROSSOVER_RATE)
        children = np.empty_like(parents)
        children[::2], children[1::2] = np.where(crossed, one, first), np.where(crossed, other, second)
        return np.clip(children, lower, upper)

    def _mutated(self, x: FloatArray) -> FloatArray:
        rng, (lower, upper) = self._rng, (self._problem.lower, self._problem.upper)
        width = np.where(upper > lower, upper - lower, 1.0)
        u, power = rng.random(x.shape), 1.0 / (MUTATION_ETA + 1.0)
        below, above = (x - lower) / width, (upper - x) / width
        left = (2.0 * u + (1.0 - 2.0 * u) * (1.0 - below) ** (MUTATION_ETA + 1.0)) ** power - 1.0
        right = 1.0 - (2.0 * (1.0 - u) + 2.0 * (u - 0.5) * (1.0 - above) ** (MUTATION_ETA + 1.0)) ** power
        step = np.where(u <= 0.5, left, right)
        chosen = rng.random(x.shape) < 1.0 / x.shape[1]
        return np.clip(np.where(chosen, x + step * width, x), lower, upper)
