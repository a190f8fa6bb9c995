"""Units of design documents, each with its factor to SI. Angles are in rad inside, speeds in rad/s."""

from __future__ import annotations

import math
from collections.abc import Mapping

UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254},
    "mass": {"kg": 1.0, "g": 1e-3, "lb": 0.45359237},
    "inertia": {"kg m2": 1.0, "kg mm2": 1e-6, "kg cm2": 1e-4, "g mm2": 1e-9, "lb in2": 0.45359237 * 0.0254**2},
    "angle": {"deg": math.pi / 180.0, "rad": 1.0},
    "speed": {"rad/s": 1.0, "r/min": math.pi / 30.0},
    "acceleration": {"m/s2": 1.0},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3},
    "stress": {"MPa": 1e6, "Pa": 1.0, "N/mm2": 1e6, "GPa": 1e9},
    "force": {"N": 1.0, "kN": 1e3},
    "moment": {"N m": 1.0, "N mm": 1e-3},
    "power": {"W": 1.0, "kW": 1e3},
    "energy": {"J": 1.0, "kJ": 1e3},
    "vibration": {"um": 1.0, "mm/s": 1.0, "mil": 1.0},
    "trial_mass": {"g": 1.0, "kg": 1e3},
    "velocity": {"m/s": 1.0},
    "width": {"mm": 1.0},
    "mass_moment": {"kg m": 1.0},
}
"""Factor of each unit to SI; the first is the one that answers use where a document states none. Vibration stays in
the unit that is stated, and masses on a shaft in g, as everywhere in balancing."""
PURE = "1"
"""Quantity of a number without a unit."""


def unit_of(quantity: str, stated: Mapping[str, str]) -> str:
    """The unit in which a quantity is shown: the one stated by the document, else the first of `UNITS`."""
    return "" if quantity == PURE else stated.get(quantity, next(iter(UNITS[quantity])))


def shown(value: float, quantity: str, stated: Mapping[str, str]) -> float:
    """A value in SI as a number in the unit of `unit_of`."""
    return value if quantity == PURE else value / UNITS[quantity][unit_of(quantity, stated)]
