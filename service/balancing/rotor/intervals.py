"""Confidence intervals of the magnitude of a vector whose error is circular and normal."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray

# Above this ratio of amplitude to scatter the Rice quantiles equal r - s^2 / 2r +- z s to 0.1 % of s.
_RICE_RATIO = 30.0


def amplitude_interval(
    vibration: ComplexArray, scatter: FloatArray, dof: IntArray, confidence: float = 0.95
) -> tuple[FloatArray, FloatArray]:
    """Interval of the true |v| for an estimate `vibration` (S,) complex with `scatter` (S,) per real component.

    The amplitude of an estimate follows Rice's law about the true one, so its quantiles are inverted rather than taken
    as r +- 1.96 s, which near zero misses half the time. A scatter estimated from `dof` (S,) degrees of freedom is
    widened by Student's t over z. The upper end is never below the one-sided limit of a vector predicted to vanish,
    sqrt(2 F(confidence; 2, dof)) s. Returns low and high (S,), nan where the scatter is unknown.
    """
    from scipy import special

    ratio_of = np.maximum(dof, 1).astype(np.float64)
    tail = 0.5 * (1.0 - confidence)
    z = float(special.ndtri(1.0 - tail))
    known = np.isfinite(scatter) & (dof > 0)
    many = ratio_of > 1e6
    student = np.where(many, z, special.stdtrit(np.where(many, 1.0, ratio_of), 1.0 - tail))
    vanishing = np.where(
        many,
        np.sqrt(-2.0 * np.log(1.0 - confidence)),
        np.sqrt(2.0 * special.fdtri(2.0, np.where(many, 1.0, ratio_of), confidence)),
    )
    amplitude = np.abs(vibration)
    wide = np.where(known, scatter * student / z, np.nan)
    ratio = np.divide(amplitude, wide, out=np.full(amplitude.shape, np.inf), where=known & (wide > 0.0))
    near = ratio < _RICE_RATIO
    square = np.where(near, ratio, 1.0) ** 2
    # Below these the amplitude is small enough to come from no vibration at all, and the quantile has no inverse.
    lowest = wide * _root(special.chndtrinc, square, 1.0 - tail)
    highest = wide * _root(special.chndtrinc, square, tail)
    shift = amplitude - 0.5 * wide / np.where(np.isfinite(ratio) & (ratio > 0.0), ratio, np.inf)
    low = np.where(near, lowest, shift - z * wide)
    high = np.where(near, highest, shift + z * wide)
    return low, np.where(known, np.maximum(high, vanishing * scatter), np.nan)


def _root(inverse: Callable[..., FloatArray], square: FloatArray, probability: float) -> FloatArray:
    """Distance, in scatters, from which an amplitude of root `square` is exceeded with 1 - `probability`."""
    possible = square > -2.0 * math.log1p(-probability)
    return np.where(possible, np.sqrt(inverse(np.where(possible, square, 40.0), 2.0, probability)), 0.0)
