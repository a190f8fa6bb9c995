"""What the resolution of a source leaves unknown: the step of its values, and the least scatter that follows from it.

A source that states 3.7 mm/s means anything within half a step of it. Readings that are all the same do not show this:
their spread is zero, or the rounding error of the mean. The standard uncertainty of a value that is rounded to steps of
q is q / sqrt(12), and it does not become smaller with the number of equal readings (JCGM 100:2008, F.2.2.1).
"""

from __future__ import annotations

import math

import numpy as np

from service.balancing.rotor.phasors import FloatArray

MIN_SCATTER = 1e-15
"""The least scatter that a document may state, in the sensor's unit."""
MIN_RELATIVE = 1e-12
"""A scatter below this share of the amplitude is rounding error: a sum of a million doubles is exact to 1e-13."""
MAX_DIGITS = 9
"""Significant digits of a value that is taken for rounded: a double that was measured has 16."""
MAX_ULPS = 1e-15
"""What a number times a factor may be off the decimal number it stands for: 901 x 0.001 is not the double 0.901."""
MIN_VALUES = 5
"""From so few values on a gap between two of them is taken for a step: fewer may have left a step out."""


def quantisation_step(values: FloatArray) -> float | None:
    """Step of the grid on which all values (N,) stand, in their unit; None where they show none.

    Values of few decimals stand on a decimal grid, or on a coarser one that their differences have in common. Others
    show a grid by repeating: measured doubles never do. One value alone shows none: 3.0 may be 3 or 3.00.
    """
    distinct = np.unique(values[np.isfinite(values)])
    if len(distinct) < 2:
        return None
    largest = float(np.abs(distinct).max())
    last = MAX_DIGITS - 1 - math.floor(math.log10(largest))
    # Whole numbers are the coarsest grid that is looked for: 120 alone does not tell steps of 10.
    for decimals in range(min(0, last), last + 1):
        if all(math.isclose(round(value, decimals), value, rel_tol=MAX_ULPS) for value in distinct.tolist()):
            return _common_step(distinct, decimals, len(values)) * 10.0**-decimals
    gaps = np.diff(distinct)
    repeating = len(gaps) > 0 and len(values) >= max(MIN_VALUES, 2 * len(distinct))
    return float(gaps.min()) if repeating else None


def _common_step(distinct: FloatArray, decimals: int, count: int) -> int:
    """Greatest common divisor of the differences, in units of the last decimal; 1 where there are too few values."""
    units = [round(value * 10.0**decimals) for value in distinct.tolist()]
    step = math.gcd(*(unit - units[0] for unit in units))
    return step if step and count >= MIN_VALUES else 1


def scatter_floor(amplitude: float, amplitude_step: float | None, phase_step_deg: float | None) -> float:
    """Least scatter per real component of a vector whose size and angle come in steps; 0 where no step is known.

    amplitude and amplitude_step in the sensor's unit, phase_step_deg in degrees. The greater of the two directions,
    along the vector and across it, counts for both.
    """
    along = amplitude_step or 0.0
    across = amplitude * math.radians(phase_step_deg or 0.0)
    return max(along, across) / math.sqrt(12.0)


def known_scatter(scatter: float | None, amplitude: float, floor: float = 0.0) -> float | None:
    """The scatter, at least `floor`; None where it is no more than rounding error and no floor is known."""
    least = max(MIN_SCATTER, MIN_RELATIVE * amplitude)
    if scatter is None:
        return None
    raised = max(scatter, floor)
    return raised if raised >= least else None
