"""Fronts of two smooth objectives: the first is minimised under a bound of the second, along a grid of bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.front import undominated
from service.optimize.problem import FloatArray
from service.optimize.smooth import Objective, SmoothProblem
from service.optimize.sqp import descend

PRECISION = 1e-11
"""Of a point's objective; the gap between points is a thousand times as wide."""


@dataclass(frozen=True)
class TwoObjectives:
    """regions: problems with the first objective, whose union is feasible; second: the other objective.

    power: objectives are shown as their power-th root; 2 where squares are minimised, which are smooth at 0.
    """

    regions: tuple[SmoothProblem, ...]
    second: Objective
    power: int = 1

    def shown(self, x: FloatArray) -> FloatArray:
        """Both objectives (2,) as they are shown."""
        pair = np.array([self.regions[0].objective(x)[0], self.second(x)[0]])
        return np.asarray(np.maximum(pair, 0.0) ** (1.0 / self.power) if self.power > 1 else pair)


@dataclass(frozen=True)
class FrontPoint:
    """A point of the front. bound: of the second objective, as shown; violation: 0 where the point is feasible."""

    number: int
    x: FloatArray
    objectives: FloatArray
    bound: float
    violation: float
    evaluations: int


class EpsilonConstraint(Iterator[FrontPoint]):
    """One step finds one point. The first two are the ends: least first, then least second objective.

    points: bounds of the second objective between its values at the ends. starts: random starts at each point, besides
    the neighbours. ceiling: greatest bound of interest, such as the reference of a hypervolume. Raises NumericsError
    for fewer than 2 points.
    """

    def __init__(
        self,
        problem: TwoObjectives,
        points: int,
        rng: np.random.Generator,
        *,
        starts: int = 2,
        end_starts: int = 10,
        ceiling: float = np.inf,
    ) -> None:
        if points < 2:
            raise NumericsError(Message("front_points", value=points), field="points", value=points)
        self._problem, self._rng, self._starts, self._ends = problem, rng, starts, end_starts
        self._points, self._ceiling = points, ceiling
        self._bounds: FloatArray = np.zeros(0)
        self.found: list[FrontPoint] = []
        self.evaluations = 0

    def __next__(self) -> FrontPoint:
        """The next point; StopIteration after the last."""
        number = len(self.found)
        if number == 0:
            point = self._best(self._problem.regions, np.inf, self._ends)
        elif number == 1:
            point = self._least_second()
            self._spread(point)
        elif number - 2 < len(self._bounds):
            bound = float(self._bounds[number - 2])
            point = self._best(self._bounded(bound), bound, self._starts)
        else:
            raise StopIteration
        self.found.append(point)
        return point

    def front(self) -> tuple[FloatArray, FloatArray]:
        """Objectives (k, 2) and designs (k, d) of the feasible points that no other dominates."""
        good = [one for one in self.found if one.violation <= 0.0]
        if not good:
            return np.zeros((0, 2)), np.zeros((0, len(self._problem.regions[0].lower)))
        objectives = np.array([one.objectives for one in good])
        kept = undominated(objectives)
        return objectives[kept], np.array([one.x for one in good])[kept]

    def _spread(self, last: FrontPoint) -> None:
        most = min(float(self.found[0].objectives[1]), self._ceiling)
        least = float(last.objectives[1])
        if most > least:
            self._bounds = np.linspace(most, least, self._points)[:-1]

    def _least_second(self) -> FrontPoint:
        """Least second objective, then the least first one that keeps it."""
        alone = tuple(replace(region, objective=self._problem.second) for region in self._problem.regions)
        least = self._best(alone, np.inf, self._ends)
        bound = float(least.objectives[1]) * (1.0 + 1e-7) + 1e-12
        point = self._best(self._bounded(bound), bound, self._starts, (least.x,))
        return point if point.violation <= 0.0 else least

    def _bounded(self, bound: float) -> tuple[SmoothProblem, ...]:
        level = bound**self._problem.power
        second = self._problem.second

        def with_second(region: SmoothProblem) -> SmoothProblem:
            def constraints(x: FloatArray) -> tuple[FloatArray, FloatArray]:
                g, jacobian = region.constraints(x)
                value, slope = second(x)
                scale = abs(level) or 1.0
                return np.append(g, (value - level) / scale), np.vstack([jacobian, slope / scale])

            return replace(region, constraints=constraints)

        return tuple(with_second(region) for region in self._problem.regions)

    def _best(
        self, regions: tuple[SmoothProblem, ...], bound: float, random: int, near: tuple[FloatArray, ...] = ()
    ) -> FrontPoint:
        first = regions[0]
        given = [] if first.starts is None else list(first.starts)
        # The neighbour, and once the end of the least first objective: the branch that the sweep may have left.
        known = self.found[-1:] if random == 0 else [*self.found[-1:], *self.found[:1]]
        starts = [*near, *(one.x for one in known), *(given if not self.found else [])]
        starts += [self._rng.uniform(first.lower, first.upper) for _ in range(random)]
        best: tuple[float, float, FloatArray] | None = None
        for start in starts:
            for region in regions:
                x, evaluations = descend(region, start, polish=False, precision=PRECISION)
                self.evaluations += evaluations
                now = (region.violation(x), float(region.objective(x)[0]), x)
                if best is None or now[:2] < best[:2]:
                    best = now
        if best is None:
            raise NumericsError(Message("front_starts"), field="starts")
        shown = self._problem.shown(best[2])
        return FrontPoint(len(self.found) + 1, best[2], shown, bound, best[0], self.evaluations)
