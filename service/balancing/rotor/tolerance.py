"""Permissible residual unbalance (ISO 21940-11), the grade reached, and vibration zones (ISO 20816-3).

e_per = G / Omega is the velocity of the mass centre over the angular speed: G is not the vibration of the casing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.balancing.rotor.intervals import amplitude_interval
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.rotor.units import angular_speed
from service.errors import NumericsError
from service.messages import Message, Quantity

MIN_SHARE, GREATEST_SHARE = 0.3, 0.7
"""Bounds of a bearing plane's share of the permissible unbalance; for a mass centre between the bearings."""

Zone = Literal["A", "B", "C", "D"]
Group = Literal[1, 2]
Support = Literal["rigid", "flexible"]

# mm/s rms; group 1 above 300 kW, group 2 from 15 to 300 kW. Seen in three independent public sources.
_ZONES: dict[tuple[int, str], tuple[float, float, float]] = {
    (2, "rigid"): (1.4, 2.8, 4.5),
    (2, "flexible"): (2.3, 4.5, 7.1),
    (1, "rigid"): (2.3, 4.5, 7.1),
    (1, "flexible"): (3.5, 7.1, 11.0),
}


@dataclass(frozen=True)
class Permissible:
    """specific_um: e_per. total_g_mm: U_per. bearing_g_mm: (2,) allocated to the bearing planes A and B."""

    specific_um: float
    total_g_mm: float
    bearing_g_mm: FloatArray


@dataclass(frozen=True)
class Reached:
    """bearing_g_mm: (2,) complex residual unbalance in the bearing planes. grade_mm_s: the grade that it meets.

    low, high: interval of the grade, nan where the scatter is unknown. within: whether the grade asked for is met;
    surely: whether even the upper end meets it.
    """

    bearing_g_mm: ComplexArray
    grade_mm_s: float
    low: float
    high: float
    within: bool
    surely: bool


def permissible(grade_mm_s: float, rotor_kg: float, speed_rpm: float, bearings_mm: FloatArray) -> Permissible:
    """Permissible residual unbalance of a rigid rotor and its allocation to the bearing planes.

    U_per = m G / Omega; U_A = U_per L_B / L and U_B = U_per L_A / L, each within 0.3 to 0.7 of U_per. bearings_mm: (2,)
    axial positions from the mass centre. Raises NumericsError for a mass centre that is not between the bearings: for
    overhung rotors the standard has limits of its own, and no free source was found that states them for certain.
    """
    for name, value in (("grade_mm_s", grade_mm_s), ("rotor_kg", rotor_kg)):
        if not (np.isfinite(value) and value > 0.0):
            raise NumericsError(
                Message("numerics.tolerance_not_positive", name=name, value=value), field=name, value=str(value)
            )
    a, b = (float(place) for place in bearings_mm)
    if not a * b < 0.0:
        raise NumericsError(
            Message("numerics.bearings_on_one_side", first=Quantity(a, "mm"), second=Quantity(b, "mm")),
            field="bearings",
            value=[a, b],
        )
    specific = 1000.0 * grade_mm_s / angular_speed(speed_rpm)
    total = rotor_kg * specific
    share = min(max(abs(b) / (abs(a) + abs(b)), MIN_SHARE), GREATEST_SHARE)
    return Permissible(specific, total, total * np.array([share, 1.0 - share]))


def in_bearing_planes(unbalance_g_mm: ComplexArray, planes_mm: FloatArray, bearings_mm: FloatArray) -> ComplexArray:
    """Unbalance (2,) in the bearing planes that pulls as `unbalance_g_mm` (P,) in planes at `planes_mm` (P,) does."""
    return np.asarray(_lever(planes_mm, bearings_mm) @ unbalance_g_mm)


def reached(
    limits: Permissible,
    grade_mm_s: float,
    still_needed: ComplexArray,
    covariance: FloatArray,
    dof: float,
    radius_mm: FloatArray,
    planes_mm: FloatArray,
    bearings_mm: FloatArray,
    confidence: float = 0.95,
) -> Reached:
    """Grade that a rotor meets which still needs the masses `still_needed` (P,) complex g to run without vibration.

    The residual unbalance is what they would cancel. covariance: (2P, 2P) g^2, of the correction. The grade is the
    greater of |U| / allocated over the bearing planes, times the grade asked for.
    """
    lever = _lever(planes_mm, bearings_mm) * radius_mm
    unbalance = -lever @ still_needed
    real = np.zeros((2, 2 * len(still_needed)), dtype=np.complex128)
    real[:, ::2], real[:, 1::2] = lever, 1j * lever
    spread = np.sqrt(0.5 * ((real @ covariance) * real.conj()).sum(axis=1).real)
    low, high = amplitude_interval(unbalance, spread, np.full(2, dof), confidence)
    scale = grade_mm_s / limits.bearing_g_mm
    grade = float((np.abs(unbalance) * scale).max())
    top = float((high * scale).max())
    return Reached(
        bearing_g_mm=unbalance,
        grade_mm_s=grade,
        low=float((low * scale).max()),
        high=top,
        within=grade <= grade_mm_s,
        surely=top <= grade_mm_s,
    )


def vibration_zone(velocity_mm_s_rms: float, group: Group, support: Support) -> Zone:
    """Find the zone of ISO 20816-3 for a broadband velocity, and a group that the user picked.

    It is for industrial machines above 15 kW, 120 to 15000 r/min; mobile machines are outside its scope.
    """
    if (group, support) not in _ZONES:
        raise NumericsError(Message("numerics.zone_unknown", group=group, support=support), field="group")
    if not velocity_mm_s_rms >= 0.0:
        raise NumericsError(
            Message("numerics.velocity_negative", velocity=velocity_mm_s_rms), field="velocity_mm_s_rms"
        )
    zones: tuple[Zone, ...] = ("A", "B", "C", "D")
    return zones[sum(velocity_mm_s_rms > limit for limit in _ZONES[group, support])]


def _lever(planes_mm: FloatArray, bearings_mm: FloatArray) -> FloatArray:
    """Shares (2, P) of unbalance in each plane that the bearings A and B take."""
    a, b = (float(place) for place in bearings_mm)
    if a == b:
        raise NumericsError(Message("numerics.bearings_at_one_place", at=Quantity(a, "mm")), field="bearings")
    to_b = (np.asarray(planes_mm) - a) / (b - a)
    return np.stack([1.0 - to_b, to_b])
