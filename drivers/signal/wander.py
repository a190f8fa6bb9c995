"""What the 1x vector does within a block: it follows the speed, and it may drift on for a reason that nothing tells.

Near a resonance the vector changes with the speed: c(w) = c0 + c1 d + c2 d^2, d the relative difference from the mean
speed. The reading belongs to the mean speed, so c0 is wanted, and the mean vector is off by c2 times the variance of d.
A vector that drifts while the speed does not is a tone that makes less than half a beat in the block, a clock of the
key-phasor that is not that of the samples, or a machine that warms up: one block cannot know, so it goes into the
scatter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drivers.signal.block import Floats, dot
from drivers.signal.orders import Course, normal_equations

LEAST_SPREAD = 5e-4
"""Standard deviation of the relative speed from which on its effect is looked for."""
BENT, DRIFTS = 3.0, 9.0
"""Ratio F from which on c2, and a drift, are believed."""
ALIKE = 0.5
"""Square of the correlation of speed and time above which the one cannot be told from the other."""
UNKNOWN = 0.4
"""Share of the change over the block that the mean vector may be off by, as a standard deviation: a tone of 0.2 beats
changes by 1.26 of its amplitude, all of which is in the mean; a clock that is off, by twice what it moves the mean."""


@dataclass(frozen=True, slots=True, eq=False)
class SpeedEffect:
    """shift: what the 1x vector lacks, complex peak. rest (n,): without the effect. off: standard deviation besides.

    widening: by how much that of the vector grows with what was fitted.
    """

    shift: complex
    rest: Floats
    widening: float = 1.0
    off: float = 0.0


def speed_rows(course: Course, basis: Floats) -> Floats:
    """Rows (0 or 4, n) of the 1x component's change with the speed and its square; none where the speed is even."""
    change = course.speed / float(course.speed.mean()) - 1.0
    if float(np.sqrt(np.mean(change**2))) < LEAST_SPREAD:
        return np.empty((0, len(change)))
    return np.stack([change * basis[2], change * basis[3], change**2 * basis[2], change**2 * basis[3]])


def drift_of(course: Course, basis: Floats, rest: Floats, weights: Floats) -> tuple[float, Floats]:
    """Standard deviation for a drift that nothing explains, and the rest (n,) without it; 0 where there is none."""
    seen = (weights > 0.0).astype(float)
    trend = 2.0 * course.place - 1.0
    change = course.speed - float(course.speed.mean())
    together = dot(trend, change) ** 2 / max(dot(trend, trend) * dot(change, change), 1e-300)
    if together > ALIKE and float(np.std(change)) > LEAST_SPREAD * float(course.speed.mean()):
        return 0.0, rest
    rows = np.vstack([basis[:4], trend * basis[2], trend * basis[3]])
    coefficients, ratio = _fitted(rows, 4, seen, rest)
    if ratio < DRIFTS:
        return 0.0, rest
    left = rest - seen * np.einsum("k,kn->n", coefficients, rows)
    return UNKNOWN * 2.0 * math.hypot(coefficients[4], coefficients[5]), left


def speed_effect(course: Course, basis: Floats, rest: Floats, weights: Floats) -> SpeedEffect:
    """What the speed does to the vector, looked for in the rest (n,) that the orders leave under weights (n,)."""
    change = course.speed / (dot(weights, course.speed) / float(weights.sum())) - 1.0
    variance = dot(weights, change**2) / float(weights.sum())
    if math.sqrt(variance) < LEAST_SPREAD:
        return SpeedEffect(0j, rest)
    rows = np.vstack([basis[:4], *(change**power * basis[row] for power in (1, 2) for row in (2, 3))])
    seen = (weights > 0.0).astype(float)
    coefficients, ratio = _fitted(rows, 6, weights, rest)
    if ratio < BENT:
        straight, _ = _fitted(rows[:6], 4, weights, rest)
        left = rest - seen * np.einsum("k,kn->n", straight, rows[:6])
        return SpeedEffect(0j, left, off=0.5 * variance * math.hypot(coefficients[6], coefficients[7]))
    matrix, _ = normal_equations(rows, weights**2, rest)
    plain, _ = normal_equations(rows, weights, rest)
    inverse = np.linalg.pinv(plain, hermitian=True)
    joint = inverse @ matrix @ inverse
    alone = np.linalg.inv(plain[:4, :4]) @ matrix[:4, :4] @ np.linalg.inv(plain[:4, :4])
    widening = math.sqrt(float((joint[2, 2] + joint[3, 3]) / (alone[2, 2] + alone[3, 3])))
    left = rest - seen * np.einsum("k,kn->n", coefficients, rows)
    return SpeedEffect(complex(coefficients[2], -coefficients[3]), left, widening)


def _fitted(rows: Floats, before: int, weights: Floats, values: Floats) -> tuple[Floats, float]:
    """Coefficients (k,) of rows (k, n), and the ratio F of what those from `before` on explain to what is left."""
    matrix, side = normal_equations(rows, weights, values)
    found = np.asarray(np.linalg.lstsq(matrix, side, rcond=1e-12)[0], float)
    fewer = np.asarray(np.linalg.lstsq(matrix[:before, :before], side[:before], rcond=1e-12)[0], float)
    total = dot(weights, values**2)
    left = max(total - dot(found, side), 1e-30 * total, 1e-300)
    explained = dot(found, side) - dot(fewer, side[:before])
    free = float(weights.sum()) ** 2 / dot(weights, weights) - len(rows)
    return found, explained / (len(rows) - before) / left * max(free, 1.0)
