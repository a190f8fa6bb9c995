"""Degrees and senses at the edge, complex numbers inside.

Inside, a mass angle counts against the rotation and a phase is a lag: then a mass moved by some degrees moves the phase
by as many, and v = v0 + A u holds. An angle stated `with_rotation`, or a phase stated as `lead`, is mirrored here and
nowhere else.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

AngleSense = Literal["against_rotation", "with_rotation"]
PhaseSense = Literal["lag", "lead"]
ComplexArray = NDArray[np.complex128]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_MIRRORED = frozenset({"with_rotation", "lead"})


def to_radians(degrees: float, sense: AngleSense | PhaseSense) -> float:
    """Angle in radians in the internal sense, for an angle in degrees in `sense`."""
    return math.radians(-degrees if sense in _MIRRORED else degrees)


def to_degrees(radians: float, sense: AngleSense | PhaseSense) -> float:
    """Angle in degrees in `sense`, 0 <= angle < 360, for an internal angle in radians."""
    return normal_degrees(math.degrees(-radians if sense in _MIRRORED else radians))


def normal_degrees(degrees: float) -> float:
    """The same direction with 0 <= angle < 360; 360 becomes 0."""
    turned = math.fmod(degrees, 360.0)
    if turned < 0.0:
        turned += 360.0
    return 0.0 if turned >= 360.0 else turned + 0.0


def phasor(magnitude: float, degrees: float, sense: AngleSense | PhaseSense) -> complex:
    """Complex vector in the internal sense, in the magnitude's unit."""
    angle = to_radians(degrees, sense)
    return complex(magnitude * math.cos(angle), magnitude * math.sin(angle))


def polar(vector: complex, sense: AngleSense | PhaseSense) -> tuple[float, float]:
    """Magnitude, and angle in degrees in `sense`, of an internal vector."""
    return abs(vector), to_degrees(math.atan2(vector.imag, vector.real), sense)
