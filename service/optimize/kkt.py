"""How near a point is to an optimum of a smooth problem: multipliers, residuals, a proved bound, a last polish."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from service.optimize.problem import FEASIBILITY, FloatArray, IntArray
from service.optimize.smooth import SmoothProblem

ACTIVE = 1e-7
"""A scaled constraint, or a part of the width of the bounds, within which a limit is active."""
STEP = 1e-6
"""Step of the differences that give second derivatives, part of the width of the bounds."""


@dataclass(frozen=True)
class Kkt:
    """Residuals at a point, for variables scaled to their bounds and the objective to its slope.

    multipliers: (c,) of the constraints, (d,) of the lower and (d,) of the upper bounds, for the unscaled objective.
    bound: proved lower bound of the objective if the problem is convex.
    """

    stationarity: float
    feasibility: float
    complementarity: float
    multipliers: FloatArray
    bound: float

    @property
    def residual(self) -> float:
        """The greatest of the three."""
        return max(self.stationarity, self.feasibility, self.complementarity)


def residuals(problem: SmoothProblem, x: FloatArray) -> Kkt:
    """Residuals and bound at x (d,), with the multipliers that fit best (non-negative least squares)."""
    width = np.where(problem.upper > problem.lower, problem.upper - problem.lower, 1.0)
    f, slope = problem.objective(x)
    g, jacobian = problem.constraints(x)
    slope, jacobian = slope * width, jacobian * width
    z = (x - problem.lower) / width
    top = (problem.upper - x) / width
    rows = np.concatenate([jacobian, -np.eye(len(x)), np.eye(len(x))])
    levels = np.concatenate([g, -z, -top])
    active = levels > -ACTIVE
    scale = max(float(np.abs(slope).max()), 1e-300)
    multipliers = np.zeros(len(levels))
    if active.any():
        norms = np.maximum(np.linalg.norm(rows[active], axis=1), 1e-300)
        found, _ = nnls((rows[active] / norms[:, None]).T, -slope / scale, maxiter=100 * len(levels))
        multipliers[active] = found * scale / norms
    left = slope + rows.T @ multipliers
    constraints = multipliers[: len(g)]
    # Over a convex problem the linear part of the Lagrangian at x bounds the objective from below within the bounds.
    tilt = slope + jacobian.T @ constraints
    bound = f + float(constraints @ g) + float(np.minimum(-tilt * z, tilt * top).sum())
    return Kkt(
        stationarity=float(np.abs(left).max()) / scale,
        feasibility=max(float(levels.max(initial=0.0)), 0.0),
        complementarity=float(np.abs(multipliers * levels).max(initial=0.0)) / scale,
        multipliers=multipliers,
        bound=bound,
    )


def polished(problem: SmoothProblem, x: FloatArray, rounds: int = 4) -> FloatArray:
    """A point nearer to the optimum by Newton steps on the active limits; x itself where they lead nowhere better."""
    best, level = x, residuals(problem, x).residual
    for _ in range(rounds):
        moved = _newton(problem, best)
        if moved is None:
            break
        now = residuals(problem, moved).residual
        if not now < level or problem.violation(moved) > problem.violation(best):
            break
        best, level = moved, now
    return best


def _newton(problem: SmoothProblem, x: FloatArray) -> FloatArray | None:
    at = residuals(problem, x)
    width = problem.upper - problem.lower
    free = width > 0.0
    slope = problem.objective(x)[1] * width
    g, jacobian = problem.constraints(x)
    held = np.flatnonzero(at.multipliers[: len(g)] > 0.0)
    d = len(x)
    lower, upper = at.multipliers[len(g) : len(g) + d], at.multipliers[len(g) + d :]
    free &= ~((lower > 0.0) & (x - problem.lower <= ACTIVE * width))
    free &= ~((upper > 0.0) & (problem.upper - x <= ACTIVE * width))
    index = np.flatnonzero(free)
    if index.size == 0:
        return None
    rows = (jacobian * width)[np.ix_(held, index)]
    hessian = _hessian(problem, x, at.multipliers[: len(g)], index)
    system = np.block([[hessian, rows.T], [rows, np.zeros((len(held), len(held)))]])
    # Aimed slightly inside, so that rounding leaves the point within its limits.
    right = -np.concatenate([slope[index], g[held] + 0.1 * FEASIBILITY])
    step = np.linalg.lstsq(system, right, rcond=1e-13)[0][: index.size]
    moved = x.copy()
    moved[index] += step * width[index]
    moved[(upper > 0.0) & ~free] = problem.upper[(upper > 0.0) & ~free]
    moved[(lower > 0.0) & ~free] = problem.lower[(lower > 0.0) & ~free]
    return np.clip(moved, problem.lower, problem.upper) if np.isfinite(moved).all() else None


def _hessian(problem: SmoothProblem, x: FloatArray, multipliers: FloatArray, index: IntArray) -> FloatArray:
    """Second derivatives of the Lagrangian in scaled variables, by central differences of exact slopes."""
    width = problem.upper - problem.lower

    def slope(y: FloatArray) -> FloatArray:
        return (problem.objective(y)[1] + problem.constraints(y)[1].T @ multipliers) * width

    columns = []
    for i in index:
        step = np.zeros_like(x)
        step[i] = STEP * width[i]
        columns.append((slope(x + step) - slope(x - step))[index] / (2.0 * STEP))
    hessian = np.array(columns)
    return np.asarray((hessian + hessian.T) / 2.0)
