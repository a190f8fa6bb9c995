"""Edges of a key-phasor put on the smooth course that they follow, and how far that course may be off in time.

An edge in a sampled signal is off by up to half a sample, one from a worn mark by its jitter; the rotor turns smoothly.
Where a polynomial of low degree explains the edges within such errors, the rotor angle is taken from it: each edge's
own error would turn the angle to and fro, and make the 1x component smaller. Where none does, the edges stay.

Rounded edges bound the course: all courses that keep to every bound are equally likely, so the middle of those is taken
and their spread stated (estimation from bounded errors: M. Milanese, A. Vicino, Optimal estimation theory for dynamic
systems with set membership uncertainty, Automatica 27 (1991) 997-1009).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from drivers.signal.block import Floats
from drivers.signal.revolutions import Revolutions

MAX_DEGREE = 4
MIN_EDGES = 6
ROUNDED = 0.6
"""Sample intervals by which an edge may be off a course by least squares for rounding alone to explain it."""
WHITE = (1.4, 2.9)
"""Durbin-Watson statistic, sum of squared steps over sum of squares, of errors that know nothing of one another: 2."""
EXACT = 1e-6
"""Share of a turn below which errors are not worth a course."""
EVEN_95 = 0.96
"""A value between two bounds is within 95 % of them in 95 % of cases: so its standard deviation is stated."""
LEAST_SPREAD = 3.0
"""Sample intervals, over the number of edges, between the courses that all edges leave open, at least."""
SWEPT, BETWEEN = 0.35, 0.2
"""Widest part of the sample interval without an edge, and share of it by which edges are off, for a signal whose flank
takes several samples, so that its edges lie between them."""


@dataclass(frozen=True, slots=True, eq=False)
class Steadied:
    """turns: on their course. together, each: standard deviation of the time by which all edges may be off, and one, s.

    each: 0 where its effect on the mean is in `together`.
    """

    turns: Revolutions
    together: float
    each: float


def steadied(turns: Revolutions, step_s: float) -> Steadied:
    """Put turns on their course. step_s: sample interval of the signal in which the edges were found; 0: exact."""
    t, y = turns.times, turns.numbers
    if len(t) < MIN_EDGES:
        return Steadied(turns, step_s / math.sqrt(12.0), 0.0)
    place = 2.0 * (y - y[0]) / (y[-1] - y[0]) - 1.0
    period = float((t[-1] - t[0]) / (y[-1] - y[0]))
    hann = np.asarray(0.5 + 0.5 * np.cos(math.pi * place), float)
    weights = np.asarray(hann / hann.sum(), float)
    for degree in range(1, min(MAX_DEGREE, len(t) // 3) + 1):
        course = np.polynomial.chebyshev.chebvander(place, degree)
        found = np.asarray(np.linalg.lstsq(course, t, rcond=None)[0], float)
        off = t - course @ found
        if step_s > 0.0 and float(np.abs(off).max()) <= ROUNDED * step_s:
            return _rounded(turns, course, found, off, weights, step_s)
        if _is_white(off):
            size = math.sqrt(float(off @ off) / (len(t) - degree - 1))
            if size <= EXACT * period:
                return Steadied(turns, 0.0, 0.0)
            lever = weights @ course @ np.linalg.pinv(course)
            together = size * math.sqrt(float(lever @ lever))
            return Steadied(_moved(turns, course @ found), math.hypot(together, step_s / math.sqrt(12.0 * len(t))), 0.0)
    return _as_they_are(turns, step_s, period)


def _is_white(off: Floats) -> bool:
    size = float(off @ off)
    steps = np.diff(off)
    return size == 0.0 or WHITE[0] <= float(steps @ steps) / size <= WHITE[1]


def _rounded(
    turns: Revolutions, course: Floats, found: Floats, off: Floats, weights: Floats, step_s: float
) -> Steadied:
    """The middle of the courses that keep within half a sample of every edge, and their spread in its middle."""
    places = np.sort((course @ found) / step_s % 1.0)
    widest = float(np.max(np.diff(np.append(places, places[0] + 1.0))))
    if widest < SWEPT and float(np.sqrt(np.mean(off**2))) < BETWEEN * step_s:
        step_s = max(math.sqrt(12.0 * float(np.mean(off**2))), 2.0 * float(np.abs(off).max()))
    half = 0.5 * step_s * (1.0 + 1e-9)
    goal = weights @ course
    rows, limits = np.vstack([course, -course]), np.concatenate([half + off, half - off]) / step_s
    low, high = (_extreme(sign * goal, rows, limits) for sign in (1.0, -1.0))
    if low is None or high is None:  # no course keeps to all: they jitter as well
        size = math.sqrt(float(off @ off) / (len(off) - course.shape[1]))
        together = math.hypot(size / math.sqrt(len(off)), widest * step_s / math.sqrt(12.0))
        return Steadied(_moved(turns, course @ found), together, 0.0)
    shift = 0.5 * step_s * (low + high)
    # Noise on the flanks shuts out courses that rounding alone would leave: less than this is not known of any.
    spread = step_s * max(float(abs(goal @ (high - low))), LEAST_SPREAD / len(off))
    return Steadied(_moved(turns, course @ (found + shift)), EVEN_95 * spread / math.sqrt(12.0), 0.0)


def _extreme(goal: Floats, rows: Floats, limits: Floats) -> Floats | None:
    """Coefficients with the least goal within limits; None where there are none."""
    answer = linprog(goal, A_ub=rows, b_ub=limits, bounds=(None, None), method="highs")
    return np.asarray(answer.x, float) if answer.status == 0 else None


def _moved(turns: Revolutions, times: Floats) -> Revolutions:
    return Revolutions(times, turns.numbers, turns.missed, turns.extra)


def _as_they_are(turns: Revolutions, step_s: float, period: float) -> Steadied:
    """Edges that no course explains: what they are off the line between their neighbours is their own error."""
    t, y = turns.times, turns.numbers
    share = (t[1:-1] - t[:-2]) / np.maximum(t[2:] - t[:-2], 1e-300)
    line = y[:-2] + share * (y[2:] - y[:-2])
    variance = float(np.mean((line - y[1:-1]) ** 2)) / 1.5 * period**2
    return Steadied(turns, step_s / math.sqrt(12.0), math.sqrt(max(variance - step_s**2 / 12.0, 0.0)))
