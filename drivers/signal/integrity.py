"""Integrity of samples: clipped tops and dropouts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.signal.block import Floats

FLAT_TOP = 3
"""Equal samples in a row at the very top or bottom that make it flat."""
FROZEN = 8
"""Equal samples in a row anywhere else that no signal from a shed shows."""
STEP = 8.0
"""Steps of the converter that a signal must jump at the end of a level stretch. The top of a sine coarsely converted is
level too: over 3 samples and more it leaves by fewer than 3 steps, and noise below 8 steps may repeat a value."""
AT_FULL_SCALE = 0.999
SAME = 1e-9
"""Share of the range by which values may differ that are one: less than the step of any converter."""
PILE, MIN_PILE, BESIDE = 4.0, 6, 12
"""Times as many samples, and how many, have the extreme value as any of the next values to it, for it to be cut off.
The top of a sine coarsely converted has 2.4 times as many as the next step."""


@dataclass(frozen=True, slots=True, eq=False)
class Integrity:
    """clipped: number of samples cut off. lost (n,): samples that were never measured. step: the converter's.

    piled: samples at the extreme values that only clipping explains, unless there is no noise.
    """

    clipped: int
    lost: NDArray[np.bool_]
    step: float = 0.0
    piled: int = 0


def integrity_of(samples: Floats, full_scale: float | None = None) -> Integrity:
    """Inspect samples (n,), raw; NaN is lost. full_scale: greatest value the input can take, in the same unit.

    Clipped: at or above 99.9 % of the full scale; or 3 or more equal samples at the greatest or least value, left by
    more than 8 steps of the converter. Lost: 8 or more equal samples elsewhere, left in the same way; all of them where
    the signal never moves.
    """
    lost = np.isnan(samples)
    seen = samples[~lost]
    if seen.size == 0 or seen.min() == seen.max():
        return Integrity(0, np.ones_like(lost))
    starts, lengths, values, jumps = _level_stretches(samples)
    step = _step(seen)
    sudden = jumps > STEP * step
    extreme = (values == seen.min()) | (values == seen.max())
    flat = extreme & sudden & (lengths >= FLAT_TOP)
    frozen = ~extreme & sudden & (lengths >= FROZEN)
    clipped = int(lengths[flat].sum())
    if full_scale is not None:
        clipped = max(clipped, int(np.count_nonzero(np.abs(seen) >= AT_FULL_SCALE * full_scale)))
    for start, length in zip(starts[frozen], lengths[frozen], strict=True):
        lost[start : start + length] = True
    return Integrity(clipped, lost, step, _piled_up(seen))


def _piled_up(seen: Floats) -> int:
    """Samples at a greatest or least value that far more of them have than have any other near it.

    So few samples a turn that none of its tops is level over three of them show clipping in this way alone.
    """
    # At a true top time hardly matters: arithmetic leaves equal values there that it leaves a little apart elsewhere.
    grain = SAME * float(np.ptp(seen))
    levels, counts = np.unique(np.round(seen / grain), return_counts=True)
    if len(levels) < 3 * BESIDE:
        return 0
    found = 0
    for end, near in ((counts[-1], counts[-1 - BESIDE : -1]), (counts[0], counts[1 : 1 + BESIDE])):
        if end >= MIN_PILE and end > PILE * near.max():
            found += int(end)
    return found


def _step(seen: Floats) -> float:
    """The converter's step: the least distance of two values of the block, whenever they came.

    Differences of neighbours alone would be greater where the sampling keeps to the turn and shows few places of it.
    """
    levels = np.unique(seen)
    gaps = np.diff(levels)
    # Values that went through arithmetic differ by rounding where they were equal.
    return float(gaps[gaps > 1e-12 * max(abs(levels[0]), abs(levels[-1]))].min(initial=np.inf))


def bridged(samples: Floats, lost: NDArray[np.bool_]) -> Floats:
    """Samples (n,) with straight lines over the lost ones; not all may be lost."""
    if not lost.any():
        return samples
    places = np.arange(len(samples))
    return np.interp(places, places[~lost], samples[~lost])


def _level_stretches(samples: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats, Floats]:
    """Start, length and value of each stretch of at least 3 equal samples, and its greater jump at an end.

    The jump is that over half the stretch's length: a smooth top, level over some samples for the converter's step,
    has fallen by a few steps there, one that was cut off by far more.
    """
    change = np.flatnonzero(samples[1:] != samples[:-1]) + 1  # NaN differs from everything
    starts = np.concatenate([[0], change])
    lengths = np.diff(np.append(starts, len(samples)))
    long = lengths >= FLAT_TOP
    starts, lengths = starts[long], lengths[long]
    reach = np.maximum(lengths // 2, 1)
    before = samples[np.maximum(starts - reach, 0)]
    after = samples[np.minimum(starts + lengths - 1 + reach, len(samples) - 1)]
    values = samples[starts]
    return starts, lengths, values, np.fmax(np.abs(before - values), np.abs(after - values))
