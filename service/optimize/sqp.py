"""Sequential quadratic programming from many starts, with exact slopes (SciPy's SLSQP)."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.optimize import minimize

from service.optimize.kkt import polished, residuals
from service.optimize.problem import FEASIBILITY, FloatArray
from service.optimize.search import Evidence, Progress
from service.optimize.smooth import SmoothProblem, validate_smooth

AGREEMENT = 1e-6
"""Starts whose objectives differ by no more than this part of the best ended in the same optimum."""
INSIDE = 0.1 * FEASIBILITY
"""How far inside the limits the programme is aimed, so that rounding leaves the answer within them."""
ITERATIONS = 400
RESTORATIONS = 5


class _Counted:
    """A problem in variables scaled to [0, 1], that remembers its last point and counts evaluations."""

    def __init__(self, problem: SmoothProblem, scale: float) -> None:
        self.problem, self.scale, self.evaluations = problem, scale, 0
        self.width = problem.upper - problem.lower
        self._objective: tuple[bytes, tuple[float, FloatArray]] | None = None
        self._constraints: tuple[bytes, tuple[FloatArray, FloatArray]] | None = None

    def at(self, z: FloatArray) -> FloatArray:
        return self.problem.lower + np.clip(z, 0.0, 1.0) * self.width

    def objective(self, z: FloatArray) -> tuple[float, FloatArray]:
        key = z.tobytes()
        if self._objective is None or self._objective[0] != key:
            self.evaluations += 1
            f, slope = self.problem.objective(self.at(z))
            self._objective = (key, (f / self.scale, slope * self.width / self.scale))
        return self._objective[1]

    def inside(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """SciPy's sign: at least 0 where satisfied."""
        key = z.tobytes()
        if self._constraints is None or self._constraints[0] != key:
            g, jacobian = self.problem.constraints(self.at(z))
            self._constraints = (key, (-g - INSIDE, -jacobian * self.width))
        return self._constraints[1]


def descend(
    problem: SmoothProblem, x: FloatArray, *, polish: bool = True, precision: float = 1e-15
) -> tuple[FloatArray, int]:
    """A local optimum near x (d,), feasible where one was found, and the evaluations it took.

    precision: change of the objective, part of its value at x, at which the programme ends.
    """
    start = np.clip(x, problem.lower, problem.upper)
    scale = abs(problem.objective(start)[0]) or 1.0
    counted = _Counted(problem, scale)
    width = np.where(counted.width > 0.0, counted.width, 1.0)
    z = (start - problem.lower) / width
    options: Any = {"maxiter": ITERATIONS, "ftol": precision}
    constrained = problem.constraints(start)[0].size > 0
    limits: list[Any] = [{"type": "ineq", "fun": lambda y: counted.inside(y)[0], "jac": lambda y: counted.inside(y)[1]}]
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        found = minimize(
            counted.objective,
            z,
            jac=True,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(z),
            constraints=limits if constrained else [],
            options=options,
        )
        if not np.isfinite(found.x).all():
            return start, counted.evaluations
        best = restored(problem, counted.at(found.x))
        if polish:
            best = polished(problem, best)
    return best, counted.evaluations


def restored(problem: SmoothProblem, x: FloatArray) -> FloatArray:
    """A nearby feasible point: least corrections of the violated constraints; x where that fails."""
    width = problem.upper - problem.lower
    point = x
    for _ in range(RESTORATIONS):
        g, jacobian = problem.constraints(point)
        broken = g > FEASIBILITY
        if not broken.any():
            return point
        near = g > -FEASIBILITY
        rows = jacobian[near] * width
        step = np.linalg.lstsq(rows, -(g[near] + INSIDE), rcond=None)[0]
        point = np.clip(point + step * width, problem.lower, problem.upper)
    return point if problem.violation(point) < problem.violation(x) else x


class MultiStart(Iterator[Progress]):
    """One step descends from one start: the problem's own starts first, then uniform random ones.

    regions: the feasible set is the union of these problems' (same bounds and objective); each step takes one start
    in each. outcomes: objective where every feasible start ended.
    """

    def __init__(self, regions: tuple[SmoothProblem, ...], rng: np.random.Generator, *, polish: bool = True) -> None:
        for problem in regions:
            validate_smooth(problem)
        self._regions, self._rng, self._polish = regions, rng, polish
        first = regions[0]
        self._given = [] if first.starts is None else list(first.starts)
        self._best: tuple[float, float, FloatArray, SmoothProblem] | None = None
        self.number = 0
        self.evaluations = 0
        self.outcomes: list[float] = []

    def __next__(self) -> Progress:
        """Descend from the next start in every region."""
        first = self._regions[0]
        drawn = self._rng.uniform(first.lower, first.upper)
        start = self._given[self.number] if self.number < len(self._given) else drawn
        for problem in self._regions:
            x, evaluations = descend(problem, start, polish=self._polish)
            self.evaluations += evaluations
            value, violation = float(problem.objective(x)[0]), problem.violation(x)
            if not np.isfinite(value):
                violation = np.inf
            if violation <= 0.0:
                self.outcomes.append(value)
            if self._best is None or (violation, value) < self._best[:2]:
                self._best = (violation, value, x, problem)
        self.number += 1
        violation, value, x, _ = self._told()
        return Progress(self.number, x, value, violation, self.evaluations)

    def evidence(self) -> Evidence:
        """What speaks for the best: a proved bound if the problem is convex, residuals and agreeing starts else."""
        violation, value, x, problem = self._told()
        if violation > 0.0:
            return Evidence("none", starts=self.number)
        at = residuals(problem, x)
        near = sum(one <= value + AGREEMENT * max(abs(value), 1e-12) for one in self.outcomes)
        proved = problem.convex and len(self._regions) == 1
        return Evidence(
            kind="proved_bound" if proved else "kkt" if at.residual < 1e-6 else "starts_agree",
            bound=at.bound if proved else None,
            residual=at.residual,
            agreeing=near,
            starts=self.number,
        )

    def _told(self) -> tuple[float, float, FloatArray, SmoothProblem]:
        if self._best is None:
            next(self)
        assert self._best is not None  # noqa: S101  a step sets it
        return self._best
