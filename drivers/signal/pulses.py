"""Several marks a turn, told from the vibration: it turns once in this many pulses of the key-phasor.

With k marks the rotor's own component lies at order 1/k of what is taken for the speed. No other machine keeps to such
a share exactly, and none stands so far above the component at order 1.
"""

from __future__ import annotations

import math

import numpy as np

from drivers.signal.block import Floats, dot
from drivers.signal.orders import Course
from drivers.signal.windows import half_width, taper

MAX_PULSES = 12
ABOVE_ONE_X = 8.0
"""Times the component at order 1 that one at order 1/k must have, in the quantity that was sampled."""
ABOVE_BESIDE = 4.0
"""Times what lies two widths of the taper to each side, so that slow drifting is no such component."""


def pulses_seen(course: Course, rest: Floats, one_x: float) -> int | None:
    """How many pulses of the key-phasor the vibration takes for a turn; None: one, as far as can be seen.

    rest (n,): the samples without the fitted orders, evenly in angle or nearly. one_x: amplitude of order 1, in the
    unit of rest.
    """
    weights = taper("blackman_harris", course.place)
    whole = float(weights.sum())
    lines = 2 * half_width("blackman_harris")  # to each side, where the taper has let go

    def size(order: float) -> float:
        angle = order * course.angle
        even, odd = dot(weights * np.cos(angle), rest), dot(weights * np.sin(angle), rest)
        return 2.0 * math.hypot(even, odd) / whole

    for pulses in range(2, MAX_PULSES + 1):
        if course.turns < lines * pulses:
            return None  # too few turns to tell it from a trend
        here = size(1.0 / pulses)
        if here <= ABOVE_ONE_X * one_x:
            continue
        beside = max(size(1.0 / pulses - lines / course.turns), size(1.0 / pulses + lines / course.turns))
        if here > ABOVE_BESIDE * beside:
            return pulses
    return None
