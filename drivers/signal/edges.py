"""Key-phasor edges in a sampled tachometer signal."""

from __future__ import annotations

from typing import Literal

import numpy as np

from drivers.checks import require
from drivers.errors import SignalRefused
from drivers.signal.block import Floats

GREATEST = 1e12
"""Greatest sample that is computed with."""
Slope = Literal["rising", "falling"]


def find_edges(
    tacho: Floats,
    sample_rate_hz: float,
    *,
    slope: Slope = "rising",
    threshold: float | None = None,
    hysteresis: float | None = None,
) -> Floats:
    """Times (m,), s from the first sample, at which the signal crosses `threshold` in the direction of `slope`.

    tacho (n,), any unit; NaN samples are passed over. An edge counts once the signal has been on the other side by
    half the hysteresis, so that noise near the threshold makes one edge and not many. By default the threshold lies
    midway between the 0.1 % and 99.9 % quantiles and the hysteresis is 30 % of their distance. The time is found by a
    straight line between the two samples around the crossing: for a step shorter than a sample it is off by less than
    half a sample, evenly to both sides.

    Raises `InvalidSetting` for a wrong shape, rate or sample, `SignalRefused` for a signal that does not move.
    """
    require(tacho.ndim == 1, f"shape {tacho.shape} of a tachometer signal", "be (n,)")
    require(0.0 < sample_rate_hz < float("inf"), f"sample_rate_hz {sample_rate_hz}", "be a number above 0")
    require(slope in ("rising", "falling"), f"slope {slope!r}", "be rising or falling")
    seen = tacho[~np.isnan(tacho)]
    greatest = float(np.abs(seen).max(initial=0.0))
    require(greatest <= GREATEST, f"a sample of {greatest:g} in a tachometer signal", f"be within +-{GREATEST:g}")
    if seen.size < 2 or seen.min() == seen.max():
        raise SignalRefused(
            "the tachometer signal never moves: check the key-phasor, its cable and its supply", code="tacho"
        )
    low, high = _levels(seen)
    level = (low + high) / 2.0 if threshold is None else threshold
    half = (0.3 * (high - low) if hysteresis is None else hysteresis) / 2.0
    require(half >= 0.0, f"hysteresis {hysteresis}", "be >= 0")
    sign = 1.0 if slope == "rising" else -1.0
    return _crossings(sign * (tacho - level), half) / sample_rate_hz


def _levels(seen: Floats) -> tuple[float, float]:
    """Low and high level; the extremes themselves where the pulses are too short for the quantiles to see them."""
    low, high = np.quantile(seen, (0.001, 0.999))
    spread = float(seen.max() - seen.min())
    return (float(low), float(high)) if high - low > 0.3 * spread else (float(seen.min()), float(seen.max()))


def _crossings(above: Floats, half: float) -> Floats:
    """Places, in samples, where `above` crosses 0 upwards, each armed by a sample below -half, fired by one >= half."""
    seen = np.flatnonzero(~np.isnan(above))
    level = above[seen]
    kind = np.where(level < -half, -1, np.where(level >= half, 1, 0))
    decided = np.flatnonzero(kind)
    fires = decided[1:][(kind[decided[1:]] > 0) & (kind[decided[:-1]] < 0)]
    order = np.arange(len(level))
    before = np.maximum.accumulate(np.where(level < 0.0, order, 0))[fires]  # the last one below, then the crossing
    after = before + 1
    share = level[before] / (level[before] - level[after])
    return np.asarray(seen[before] + (seen[after] - seen[before]) * share, float)
