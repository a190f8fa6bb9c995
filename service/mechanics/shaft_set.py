"""Three aims of balancing a shaft set with several planes and many sensors, weighed by fuzzy goals.

x = v0 + A w: residual vibration (n,) for complex masses w (planes,); F1 = sum |x|^2, F2 = max |x|,
F3 = max |x| - min |x|. Membership mu = clip((M - F) / (M - m), 0, 1) is 1 at the best attainable value m and 0 at the
worst accepted one M; H is their weighted sum, to be maximised. (Differential Search paper, Vibroengineering Procedia 4,
2014; limits in closed form instead of those of a random population.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from service.mechanics.bodies import ComplexArray, FloatArray
from service.mechanics.refusals import Refusal
from service.messages import Message

ILL_CONDITIONED = 1e3
"""Condition of the influence matrix above which planes can hardly be told apart."""
SINGULAR = 1e10
NOTHING_TO_GAIN = 1e-12


@dataclass(frozen=True)
class ShaftSet:
    """Vibration v0 (n,) without correction and influence A (n, planes), in one angle sense; per unit of mass."""

    initial: ComplexArray
    influence: ComplexArray

    def __post_init__(self) -> None:
        """Refuse shapes that do not fit, values that are not finite, and planes that cannot be told apart."""
        n, planes = self.influence.shape
        if self.initial.shape != (n,):
            raise Refusal(Message("shaft_shapes", field="influence", value=n, sensors=len(self.initial)))
        if not (np.isfinite(self.initial).all() and np.isfinite(self.influence).all()):
            raise Refusal(Message("not_finite", field="influence", value=float("nan")))
        if n < planes:
            raise Refusal(Message("shaft_too_few_sensors", field="influence", value=n, planes=planes))
        if self.condition > SINGULAR:
            raise Refusal(Message("shaft_planes_alike", field="influence", value=self.condition, planes=self.alike))

    @cached_property
    def condition(self) -> float:
        """Condition number of the influence matrix."""
        return float(np.linalg.cond(self.influence))

    @property
    def alike(self) -> str:
        """Numbers of the planes that the sensors tell apart least, from 1."""
        weakest = np.abs(np.linalg.svd(self.influence)[2][-1])
        return ", ".join(str(i + 1) for i in np.flatnonzero(weakest > 0.3 * weakest.max()))

    def residual(self, w: ComplexArray) -> ComplexArray:
        """Vibration x (..., n) for masses w (..., planes)."""
        return np.asarray(self.initial + w @ self.influence.T)

    @cached_property
    def least_squares(self) -> ComplexArray:
        """Masses (planes,) of the least sum of squares."""
        return np.asarray(np.linalg.lstsq(self.influence, -self.initial, rcond=None)[0])


@dataclass(frozen=True)
class FuzzyGoals:
    """Weights (3,) with sum 1, best (3,) and worst (3,) values of the aims F1, F2, F3."""

    weights: FloatArray
    best: FloatArray
    worst: FloatArray

    @classmethod
    def of(
        cls, shaft: ShaftSet, weights: FloatArray, best: FloatArray | None = None, worst: FloatArray | None = None
    ) -> FuzzyGoals:
        """Goals with limits in closed form where they are not given (NaN or None).

        m1: least-squares residual; m2: sqrt(m1 / n), which the largest is never below; m3 = 0. M: without correction.
        """
        least = float(aims(shaft.residual(shaft.least_squares))[0])
        attainable = np.array([least, np.sqrt(least / len(shaft.initial)), 0.0])
        without = aims(shaft.initial)
        m = attainable if best is None else np.where(np.isnan(best), attainable, best)
        M = without if worst is None else np.where(np.isnan(worst), without, worst)
        return cls(weights / weights.sum(), m, M)

    @property
    def gained(self) -> FloatArray:
        """Whether there is something to gain for each aim (3,), as 0 or 1."""
        return np.asarray((self.worst - self.best > NOTHING_TO_GAIN * np.abs(self.worst)).astype(np.float64))

    def memberships(self, values: FloatArray) -> FloatArray:
        """Membership (..., 3) of aims (..., 3); 1 where there is nothing to gain."""
        span = np.where(self.gained > 0.0, self.worst - self.best, 1.0)
        mu = np.clip((self.worst - values) / span, 0.0, 1.0)
        return np.asarray(np.where(self.gained > 0.0, mu, 1.0))

    def h(self, values: FloatArray) -> FloatArray:
        """Weighted sum H (...) of the memberships."""
        return np.asarray(self.memberships(values) @ self.weights)


def aims(x: ComplexArray) -> FloatArray:
    """F1, F2, F3 (..., 3) of residual vibrations x (..., n)."""
    size = np.abs(x)
    largest = size.max(axis=-1)
    return np.stack([(size**2).sum(axis=-1), largest, largest - size.min(axis=-1)], axis=-1)
