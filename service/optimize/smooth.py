"""A smooth problem: minimise f(x) under g(x) <= 0 within finite bounds, with slopes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.problem import FEASIBILITY, FloatArray

Objective = Callable[[FloatArray], tuple[float, FloatArray]]
Constraints = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


def unconstrained(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """No constraint: g (0,) and its slopes (0, d)."""
    return np.zeros(0), np.zeros((0, len(x)))


@dataclass(frozen=True)
class SmoothProblem:
    """Bounds (d,); objective: x (d,) -> f and its slopes (d,); constraints: x -> scaled g (c,) and slopes (c, d).

    labels: names of the first constraints; the last name stands for all that follow it.
    starts: (k, d) points to begin at before random ones. convex: f and g are convex, so that a stationary point is
    the optimum and its multipliers prove a bound.
    """

    lower: FloatArray
    upper: FloatArray
    objective: Objective
    constraints: Constraints = unconstrained
    starts: FloatArray | None = None
    convex: bool = False
    labels: tuple[str, ...] = ()

    def violation(self, x: FloatArray) -> float:
        """Sum of constraints above their tolerance; bounds count in parts of their width."""
        g = self.constraints(x)[0]
        width = np.maximum(self.upper - self.lower, 1e-300)
        out = np.maximum((self.lower - x) / width, (x - self.upper) / width)
        over = np.concatenate([g, out])
        return float(np.where(over > FEASIBILITY, over, 0.0).sum())


def validate_smooth(problem: SmoothProblem) -> None:
    """Raise NumericsError unless the bounds are finite, of one shape and not crossed."""
    if problem.lower.shape != problem.upper.shape or problem.lower.ndim != 1 or problem.lower.size == 0:
        raise NumericsError(
            Message("bounds_shape", lower=problem.lower.shape, upper=problem.upper.shape), field="lower"
        )
    wrong = ~(np.isfinite(problem.lower) & np.isfinite(problem.upper) & (problem.lower <= problem.upper))
    if wrong.any():
        i = int(wrong.argmax())
        raise NumericsError(
            Message("bounds_crossed", variable=i, lower=problem.lower[i], upper=problem.upper[i]), field=f"variable {i}"
        )
