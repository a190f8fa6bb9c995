"""What the scale cannot tell: the scatter of the residual and of the objective from the parts' masses.

Each reading of the scale has the standard deviation s; the default is its resolution / sqrt(12), the deviation of a
value rounded to it. The residual changes by the gain of the part's place times the error; where the drum was measured
or in balance with the present parts on, by the difference of the gains of the new and the present place.
"""

from __future__ import annotations

import math

import numpy as np

from service.balancing.arrangement.problem import EMPTY
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.problem import Objective


def scale_deviation(resolution_g: float) -> float:
    """Standard deviation, in g, of a reading rounded to `resolution_g`."""
    return resolution_g / math.sqrt(12.0)


def residual_covariance(
    gains: ComplexArray, arrangement: IntArray, present: IntArray | None, readings_g: FloatArray
) -> FloatArray:
    """Covariance (2S, 2S), real and imaginary parts in turn, of the residual.

    gains: (P, 2, S), residual per gram at each end of a place. arrangement: (P,). present: (P,) where the offset was
    measured or in balance with the present parts on, else None. readings_g: (K, E, 2), what one standard deviation of
    each of up to E readings of a part adds to the masses of its ends; 0 where there is no such reading.
    """
    size = gains.shape[2]
    covariance = np.zeros((2 * size, 2 * size))
    for part, readings in enumerate(readings_g):
        gain = _gain(gains, arrangement, part)
        if present is not None:
            gain = gain - _gain(gains, present, part)
        for error in readings:
            real = np.ascontiguousarray(error @ gain).view(np.float64)
            covariance += np.outer(real, real)
    return covariance


def objective_deviation(objective: Objective, covariance: FloatArray) -> float:
    """Standard deviation of the objective near 0, first order: as a plan's scatter is propagated.

    covariance: (2S, 2S) of the unweighted residual.
    """
    variance = np.diag(covariance).reshape(-1, 2).sum(axis=1)
    spread = objective.weights * np.sqrt(variance)
    if objective.norm == "max":
        return float(spread.max())
    mean_or_sum = np.mean if objective.norm == "rms" else np.sum
    return float(np.sqrt(mean_or_sum(spread**2)))


def _gain(gains: ComplexArray, arrangement: IntArray, part: int) -> ComplexArray:
    place = np.flatnonzero(arrangement == part)
    if part == EMPTY or not len(place):
        return np.zeros(gains.shape[1:], dtype=np.complex128)
    return np.asarray(gains[int(place[0])])
