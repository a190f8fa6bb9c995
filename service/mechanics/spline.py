"""Clamped cubic B-spline curves on uniform knots: the ends are interpolated, inner control points attract."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline

from service.errors import NumericsError
from service.mechanics.bodies import FloatArray
from service.messages import Message

DEGREE = 3
FEWEST = 4
"""Fewest control points of a cubic curve."""


def segments(count: int) -> int:
    """Number of segments of a curve with `count` control points; its parameter runs from 0 to that."""
    if count < FEWEST:
        raise NumericsError(
            Message("spline_points", least=FEWEST, value=count),
            field="thickness",
            value=count,
        )
    return count - DEGREE


def basis(count: int, u: FloatArray, derivative: int = 0) -> FloatArray:
    """Basis functions (n, count) at parameters u (n,), or a derivative of theirs."""
    return np.asarray(_curve(count)(u, nu=derivative))


@lru_cache(maxsize=32)
def _curve(count: int) -> BSpline:
    last = segments(count)
    knots = np.concatenate([np.zeros(DEGREE), np.arange(last + 1.0), np.full(DEGREE, float(last))])
    return BSpline(knots, np.eye(count), DEGREE)
