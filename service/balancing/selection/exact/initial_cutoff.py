"""Initial cutoff: the level at which the exact search begins."""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np

from service.balancing.selection.exact.bounds import Bounds
from service.balancing.selection.exact.level_ellipsoid import Ellipsoid, ellipsoid
from service.balancing.selection.exact.meet_in_middle import Split

EXPECTED = 4.0
"""Joint selections that the first level is sized to hold."""

FEW_ENOUGH = 1e4
"""Joint selections that are looked at in any case rather than passing over every plane again at a higher level."""


def first_level(bounds: Bounds, splits: list[Split], highest: float) -> Generator[None, None, float]:
    """Level, at most `highest`, by the density of sums at the continuous optimum; yields now and then, for a stop."""
    density = 0.0
    for split, u in zip(splits, bounds.continuous, strict=True):
        density += math.log(max(_density(split, u), 1e-9))
    if bounds.dual is None:
        whole = ellipsoid(bounds, highest)
        enough = max(FEW_ENOUGH, sum(split.asked for split in splits) / 2.0)
        if whole is not None and density + _log_volume(whole) <= math.log(enough):
            return highest
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


def _density(split: Split, centre: complex) -> float:
    """Estimate selections per g^2 near `centre`, the sums taken as normally distributed."""
    mean, variance = split.moments()
    variance += 1e-6
    return (
        split.selections / (2.0 * math.pi * variance) * math.exp(-min(abs(centre - mean) ** 2 / (2.0 * variance), 12.0))
    )


def _log_volume(region: Ellipsoid) -> float:
    n = len(region.centre)
    return n / 2.0 * math.log(math.pi) - math.lgamma(n / 2.0 + 1.0) - 0.5 * float(np.linalg.slogdet(region.form)[1])
