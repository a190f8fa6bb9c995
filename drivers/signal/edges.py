"""Key-phasor edges in a sampled tachometer signal."""

from __future__ import annotations

from typing import Literal

import numpy as np

from drivers.checks import require
from drivers.errors import SignalRefused
from drivers.signal.block import Floats

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

    Raises `InvalidSetting` for a wrong shape or rate, `SignalRefused` for a signal that does not move.
    """
    require(tacho.ndim == 1, f"shape {tacho.shape} of a tachometer signal", "be (n,)")
    require(0.0 < sample_rate_hz < float("inf"), f"sample_rate_hz {sample_rate_hz}", "be a number above 0")
    require(slope in ("rising", "falling"), f"slope {slope!r}", "be rising or falling")
    signal = np.where(np.isfinite(tacho), tacho, np.nan)
    seen = signal[~np.isnan(signal)]
    if seen.size < 2 or seen.min() == seen.max():
        raise SignalRefused(
            "the tachometer signal never moves: check the key-phasor, its cable and its supply", code="tacho"
        )
    low, high = _levels(seen)
    level = (low + high) / 2.0 if threshold is None else threshold
    half = (0.3 * (high - low) if hysteresis is None else hysteresis) / 2.0
    require(half >= 0.0, f"hysteresis {hysteresis}", "be >= 0")
    sign = 1.0 if slope == "rising" else -1.0
    return _crossings(sign * (signal - level), half) / sample_rate_hz


def _levels(seen: Floats) -> tuple[float, float]:
    """Low and high level; the extremes themselves where the pulses are too short for the quantiles to see them."""
    low, high = np.quantile(seen, (0.001, 0.999))
    spread = float(seen.max() - seen.min())
    return (float(low), float(high)) if high - low > 0.3 * spread else (float(seen.min()), float(seen.max()))


def _crossings(above: Floats, half: float) -> Floats:
    """Places, in samples, where `above` crosses 0 upwards, each armed by a sample below -half, fired by one >= half."""
    kind = np.where(above < -half, -1, np.where(above >= half, 1, 0))
    if half == 0.0:
        kind = np.where(above < 0.0, -1, np.where(above >= 0.0, 1, 0))
    decided = np.flatnonzero(kind)
    fires = decided[1:][(kind[decided[1:]] > 0) & (kind[decided[:-1]] < 0)]
    armed = decided[:-1][(kind[decided[1:]] > 0) & (kind[decided[:-1]] < 0)]
    places = np.empty(len(fires))
    for index, (before, after) in enumerate(zip(armed, fires, strict=True)):
        span = np.arange(before, after + 1)
        span = span[~np.isnan(above[span])]
        last_below = int(np.flatnonzero(above[span] < 0.0)[-1])  # `before` itself is below, `after` is not
        i, j = span[last_below], span[last_below + 1]
        places[index] = i + (j - i) * above[i] / (above[i] - above[j])
    return places
