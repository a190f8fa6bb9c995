"""Horizontal, vertical and axial at one bearing: does it look like unbalance or not.

The signs of unbalance that field guides agree on: the 1x component dominates with little at its harmonics, horizontal
and vertical differ by no more than 3 : 1 and by 90 +- 30 degrees, and axial stays below radial (an overhung rotor
excepted). A rotor that breaks them may still be balanced, but something else is wrong as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drivers.checks import require
from drivers.quantities import PER_PEAK
from drivers.signal.chain import Measured

Doubt = Literal["one_x_not_dominant", "h_to_v_beyond_3", "h_to_v_not_90_deg", "axial_above_radial"]
DOMINANT = 0.8
"""Share of the overall rms from which on 1x dominates: the rest is then no more than 0.6 of the overall rms."""
HARMONIC = 0.33
"""Share of the 1x amplitude that a harmonic may have."""


@dataclass(frozen=True, slots=True)
class Directions:
    """Ratios of 1x amplitudes at a bearing; None where they are not defined.

    h_to_v: horizontal over vertical. h_minus_v_deg: phase of horizontal less that of vertical, -180 < x <= 180, in the
    phase sense of the measurements. axial_to_radial: axial over the greater of the other two.
    """

    h_to_v: float | None
    h_minus_v_deg: float
    axial_to_radial: float | None
    doubts: tuple[Doubt, ...]


def compare(horizontal: Measured, vertical: Measured, axial: Measured | None = None) -> Directions:
    """Compare measurements of one block at one bearing. Raises `InvalidSetting` for different units or detections."""
    given = [one for one in (horizontal, vertical, axial) if one is not None]
    stated = {(one.channel.quantity, one.channel.unit, one.channel.detection) for one in given}
    require(len(stated) == 1, f"quantities, units and detections {sorted(stated)}", "be the same in all directions")
    difference = -((vertical.phase_deg - horizontal.phase_deg + 180.0) % 360.0 - 180.0)
    h_to_v = _ratio(horizontal.amplitude, vertical.amplitude)
    axial_to_radial = None if axial is None else _ratio(axial.amplitude, max(horizontal.amplitude, vertical.amplitude))
    doubts: list[Doubt] = []
    if not (_dominant(horizontal) and _dominant(vertical)):
        doubts.append("one_x_not_dominant")
    if h_to_v is None or not 1.0 / 3.0 <= h_to_v <= 3.0:
        doubts.append("h_to_v_beyond_3")
    if not 60.0 <= abs(difference) <= 120.0:
        doubts.append("h_to_v_not_90_deg")
    if axial_to_radial is not None and axial_to_radial >= 1.0:
        doubts.append("axial_above_radial")
    return Directions(h_to_v, difference, axial_to_radial, tuple(doubts))


def _ratio(one: float, other: float) -> float | None:
    return one / other if other > 0.0 else None


def _dominant(measured: Measured) -> bool:
    """Whether 1x makes up most of the overall value and no harmonic comes near it."""
    one_x = measured.amplitude / PER_PEAK[measured.channel.detection] * PER_PEAK["rms"]
    quiet = all(one.amplitude <= HARMONIC * measured.amplitude for one in measured.components[1:])
    return quiet and one_x >= DOMINANT * measured.overall_rms
