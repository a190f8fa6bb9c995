"""How high the exact search begins: a level whose ellipsoid should hold a few joint selections."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from service.balancing.selection.exact.bounds import Bounds
from service.balancing.selection.exact.level_ellipsoid import Ellipsoid, ellipsoid
from service.balancing.selection.exact.meet_in_middle import Halves

EXPECTED = 4.0
"""Joint selections that the first level is sized to hold."""


def first_level(bounds: Bounds, halves: list[Halves], highest: float) -> Generator[None, None, float]:
    """Level, at most `highest`, by the density of sums at the continuous optimum; yields now and then, for a stop."""
    density = 0.0
    for half, u in zip(halves, bounds.continuous, strict=True):
        density += math.log(max(_density(half, u), 1e-9))
    above, too_low = max(highest - bounds.floor, 0.0), 0.0
    while above > 1.5 * too_low:
        middle = math.sqrt(above * too_low) if too_low > 0.0 else above / 4.0
        region = ellipsoid(bounds, bounds.floor + middle)
        yield
        if region is None or density + _log_volume(region) < math.log(EXPECTED):
            too_low = middle
        else:
            above = middle
        if above < 1e-12 * highest:
            break
    return bounds.floor + above


def _density(half: Halves, centre: complex) -> float:
    """Estimate selections per g^2 near `centre`, the sums taken as normally distributed."""
    parts = [v[:: 1 + len(v) // 100_000] for v in (half.first.vector, half.second.vector)]
    mean = sum(complex(v.mean()) for v in parts)
    spread = sum(float(v.real.var() + v.imag.var()) / 2.0 for v in parts) + 1e-6
    return half.selections / (2.0 * math.pi * spread) * math.exp(-min(abs(centre - mean) ** 2 / (2.0 * spread), 12.0))


def _log_volume(region: Ellipsoid) -> float:
    n = len(region.centre)
    return n / 2.0 * math.log(math.pi) - math.lgamma(n / 2.0 + 1.0) - 0.5 * float(np.linalg.slogdet(region.form)[1])
