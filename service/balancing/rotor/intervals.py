"""Confidence intervals of the magnitude of a vector whose error is circular and normal."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import ComplexArray, FloatArray

# Above this ratio of amplitude to scatter the Rice quantiles equal r - s^2 / 2r +- z s to 0.1 % of s.
_RICE_RATIO = 30.0
# Student's t of more degrees of freedom is as good as normal.
_MANY = 1e6


def amplitude_interval(
    vibration: ComplexArray, scatter: FloatArray, dof: FloatArray, confidence: float = 0.95
) -> tuple[FloatArray, FloatArray]:
    """Interval of the true |v| for an estimate `vibration` (S,) complex with `scatter` (S,) per real component.

    The amplitude of an estimate follows Rice's law about the true one, so its quantiles are inverted rather than taken
    as r +- 1.96 s, which near zero misses half the time. A scatter estimated from `dof` (S,) degrees of freedom, inf
    where it was stated, is widened by Student's t over z. The upper end is never below the one-sided limit of a vector
    predicted to vanish, sqrt(2 F(confidence; 2, dof)) s. Returns low and high (S,), nan where the scatter is unknown.
    """
    tail = 0.5 * (1.0 - confidence)
    z = _normal_quantile(1.0 - tail)
    known = np.isfinite(scatter) & (dof > 0)
    student, vanishing = _quantiles(np.where(known, dof, math.inf), confidence)
    amplitude = np.abs(vibration)
    wide = np.where(known, scatter * student / z, np.nan)
    ratio = np.divide(amplitude, wide, out=np.full(amplitude.shape, np.inf), where=known & (wide > 0.0))
    near = ratio < _RICE_RATIO
    square = np.where(near, ratio, 1.0) ** 2
    # Below these the amplitude is small enough to come from no vibration at all, and the quantile has no inverse.
    lowest, highest = wide * _root(square, near, 1.0 - tail), wide * _root(square, near, tail)
    shift = amplitude - 0.5 * wide / np.where(np.isfinite(ratio) & (ratio > 0.0), ratio, np.inf)
    low = np.where(near, lowest, shift - z * wide)
    high = np.where(near, highest, shift + z * wide)
    return low, np.where(known, np.maximum(high, vanishing * scatter), np.nan)


def _quantiles(dof: FloatArray, confidence: float) -> tuple[FloatArray, FloatArray]:
    """Two-sided quantile of Student's t, and that of the length of a vector predicted to vanish, sqrt(2 F(2, dof))."""
    miss = 1.0 - confidence
    student = np.full(dof.shape, _normal_quantile(1.0 - 0.5 * miss))
    vanishing = np.full(dof.shape, math.sqrt(-2.0 * math.log(miss)))
    few = dof <= _MANY
    if few.any():
        from scipy.special import stdtrit  # takes longer to load than a session to solve; stated scatters spare it

        student[few] = stdtrit(dof[few], 1.0 - 0.5 * miss)
        # F(2, n) has a quantile in closed form.
        vanishing[few] = np.sqrt(dof[few] * (miss ** (-2.0 / dof[few]) - 1.0))
    return student, vanishing


@lru_cache(maxsize=16)
def _normal_quantile(probability: float) -> float:
    from statistics import NormalDist

    return NormalDist().inv_cdf(probability)


def _root(square: FloatArray, near: NDArray[np.bool_], probability: float) -> FloatArray:
    """Distance, in scatters, from which an amplitude of root `square` is exceeded with 1 - `probability`.

    Only where it is asked for (`near`); 0 elsewhere.
    """
    possible = near & (square > -2.0 * math.log1p(-probability))
    found = np.zeros(square.shape)
    if possible.any():
        from scipy.special import chndtrinc  # as above: few amplitudes are near their scatter

        found[possible] = np.sqrt(chndtrinc(square[possible], 2.0, probability))
    return found
