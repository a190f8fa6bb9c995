"""Standard deviation of the 1x vector of a block, from what is left around it once all that is known is taken out.

The rest is looked at as the 1x component was: under a Hann taper, at orders a whole number of lines from 1. Each of
these vectors scatters as the block's own would under that taper, where the disturbance is broadband. Few of them know
a standard deviation badly: it is stated so much larger that 95 % of the vectors lie within the region that it gives for
95 % (2.45 of it around), as where it is known. A tone near the 1x component is taken out before.
"""

from __future__ import annotations

import math

import numpy as np

from drivers.signal.block import Floats, dot
from drivers.signal.orders import Complexes, Course
from drivers.signal.windows import taper

NEAREST_LINE = 2
"""Lines from 1x to where the Hann taper has let go of what the fit took out."""
FARTHEST_ORDER = 0.5
"""Orders to each side of 1x that speak for it, where the block is long enough to give `ENOUGH` lines within."""
FURTHER_ORDER = 0.85
ENOUGH = 8
SHARED = 1.944
"""Lines of the Hann taper that know as much as one: 1 + 2 (2/3)^2 + 2 (1/6)^2."""
HANN_NOISE = 1.5
"""Equivalent noise bandwidth of the Hann taper, in lines."""
KNOWN = -math.log(0.05)
"""95 % quantile of F(2, infinite)."""


def scatter_of(course: Course, rest: Floats, weights: Floats) -> float | None:
    """Standard deviation per real component of the 1x vector, peak, in the unit of rest (n,): values without the fit.

    weights (n,): those of the block's own estimate; samples of weight 0 that the taper does not explain are left out.
    None below 4 turns, where no line lies between the orders.
    """
    lines = lines_of(course.turns)
    if not len(lines):
        return None
    vectors = _vectors(course, rest, weights > 0.0, lines)
    power = float(np.mean(np.abs(vectors) ** 2)) / 2.0
    noise = dot(weights, weights) * len(weights) / float(weights.sum()) ** 2  # bandwidth of the estimate, in lines
    return math.sqrt(power * noise / HANN_NOISE) * widened(2.0 * len(lines) / SHARED)


def lines_of(turns: int) -> Floats:
    """Orders (m,) at which the rest is looked at, in a block of this many turns."""
    for farthest in (FARTHEST_ORDER, FURTHER_ORDER):
        away = np.arange(NEAREST_LINE, math.floor(farthest * turns) + 1)
        if 2 * len(away) >= ENOUGH:
            break
    return np.asarray(1.0 + np.concatenate([-away[::-1], away]) / turns, float)


def widened(freedom: float) -> float:
    """Factor by which a standard deviation from this many degrees of freedom is stated larger.

    The square of a vector over 2 s^2 follows F(2, freedom), whose 95 % quantile is (freedom/2) (0.05^(-2/freedom) - 1).
    """
    return math.sqrt(0.5 * freedom * (0.05 ** (-2.0 / freedom) - 1.0) / KNOWN)


def _vectors(course: Course, rest: Floats, seen: np.ndarray, orders: Floats) -> Complexes:
    """Vectors (m,) of the rest at orders (m,), peak; thinned to what these orders need."""
    hann = taper("hann", course.place) * seen
    step = max(1, len(rest) // (16 * course.turns))
    count = len(rest) // step

    def thin(values: Floats) -> Floats:
        return np.asarray(values[: count * step].reshape(count, step).sum(axis=1), float)

    angle = thin(course.angle) / step
    kernel = np.exp(-1j * orders[:, None] * angle[None, :])
    return np.asarray(2.0 * (kernel @ thin(hann * rest)) / float(hann.sum()), complex)
