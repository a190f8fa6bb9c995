"""Scatter between runs that turn at slightly different speeds.

The scatter stated with a reading is that of its mean within one run, and knows nothing of this. Yet the vector changes
with the speed n: the force of an unbalance grows as n^2, and so does the displacement of a rotor well below its first
resonance (x = U n^2 / k); velocity grows as n^3, acceleration as n^4 (Rao, Mechanical Vibrations, rotating unbalance).
Above the resonance all of these are slower by n^2, next to it they are faster.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from service.balancing.influence.fit import RunSet
from service.balancing.rotor.phasors import FloatArray

SENSITIVITY = 3.0
"""Relative change of a vector over relative change of speed: of a velocity, well below the first resonance."""

# A change of size d |v| has d^2 |v|^2 / 2 in each of the two components that scatter is stated for.
_PER_COMPONENT = SENSITIVITY / np.sqrt(2.0)


def with_speed_scatter(
    runs: RunSet, speed_rpm: FloatArray | None, reference_rpm: FloatArray | float | None = None
) -> RunSet:
    """Return the runs with each stated scatter widened by what the run's own speed adds to it.

    speed_rpm: (K, S) measured, r/min, nan where it was not. reference_rpm: (S,) speed that the fit is to hold for; the
    median of each column where None, so that a machine which always turns a little fast loses nothing. A reading turned
    at the share d above or below it gets (SENSITIVITY d |v|)^2 / 2 added to its variance per real component. The
    vectors stay as measured: how a particular machine follows its speed is not known well enough to correct them. A
    scatter that is not stated stays so; without it the residuals tell, and they contain this.
    """
    if speed_rpm is None:
        return runs
    if reference_rpm is None:
        reference_rpm = _median(speed_rpm)
    off = np.abs(speed_rpm / reference_rpm - 1.0)
    added = _PER_COMPONENT * off * np.abs(runs.vibration)
    # 0, like nan, says that the scatter is unknown; nan added is a speed or a reading that is.
    widened = (runs.scatter > 0.0) & (added > 0.0)
    return replace(runs, scatter=np.hypot(runs.scatter, added, out=runs.scatter.copy(), where=widened))


def _median(speed_rpm: FloatArray) -> FloatArray:
    """Median of each column over the speeds that were measured; nan where none was."""
    ordered = np.sort(speed_rpm, axis=0)  # nan goes last
    count = len(ordered)
    if not np.isnan(ordered[-1]).any():
        return np.asarray(0.5 * (ordered[(count - 1) // 2] + ordered[count // 2]))
    known = count - np.isnan(ordered).sum(axis=0)
    columns = np.arange(speed_rpm.shape[1])
    return np.asarray(0.5 * (ordered[(known - 1) // 2, columns] + ordered[known // 2, columns]))
