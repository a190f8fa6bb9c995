"""Suggested mass, place and force of the first trial mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.balancing.influence.diagnosis.findings import Finding
from service.balancing.rotor.phasors import ComplexArray
from service.balancing.rotor.units import angular_speed
from service.errors import NumericsError
from service.messages import Message, Quantity

GRAVITY = 9.80665
SHARE_OF_LOAD = 0.1
"""Share of the static load at a plane that the force of a trial mass should not pass: the usual rule of the field."""
TIMES_PERMISSIBLE = 10.0
"""Trial unbalance over permissible residual unbalance of the plane: 5 to 10 is usual."""
CHANGE = 0.5
"""Change of the vibration, as a share of it, that an earlier coefficient is asked for: well above 30 %."""

Rule = Literal["static_load", "permissible_unbalance", "earlier_coefficient"]


@dataclass(frozen=True)
class TrialMass:
    """Suggested mass in g, the rule that gave it (the smallest of `candidates`), and its force in N while it turns.

    angle: radians, internal sense, opposite to the unbalance by the earlier coefficients; None without them.
    """

    mass_g: float
    rule: Rule
    force_n: float
    candidates: dict[Rule, float]
    angle: float | None = None


def centrifugal_force(mass_g: float, radius_mm: float, speed_rpm: float) -> float:
    """Force in N of a mass in g at a radius in mm."""
    return mass_g * 1e-3 * radius_mm * 1e-3 * angular_speed(speed_rpm) ** 2


def suggest(
    carried_kg: float,
    radius_mm: float,
    speed_rpm: float,
    permissible_g_mm: float | None = None,
    influence: ComplexArray | None = None,
    vibration: ComplexArray | None = None,
) -> TrialMass:
    """Suggest a trial mass for one plane: the smallest of the rules that can be applied.

    carried_kg: mass that the bearing next to the plane carries. permissible_g_mm: permissible residual unbalance of the
    plane. influence: (S,) earlier coefficients of the plane per g; vibration: (S,) as found, internal sense. Without
    them there is no angle. Raises NumericsError unless load, radius and speed are positive.
    """
    for name, value in (("carried_kg", carried_kg), ("radius_mm", radius_mm)):
        if not (np.isfinite(value) and value > 0.0):
            raise NumericsError(
                Message("numerics.trial_mass_not_positive", name=name, value=value), field=name, value=str(value)
            )
    omega = angular_speed(speed_rpm)
    candidates: dict[Rule, float] = {
        "static_load": SHARE_OF_LOAD * carried_kg * GRAVITY / (radius_mm * 1e-3 * omega**2) * 1e3
    }
    if permissible_g_mm is not None:
        candidates["permissible_unbalance"] = TIMES_PERMISSIBLE * permissible_g_mm / radius_mm
    angle = None
    if influence is not None and vibration is not None and np.abs(influence).max() > 0.0:
        strongest = int(np.argmax(np.abs(influence)))
        candidates["earlier_coefficient"] = float(CHANGE * np.abs(vibration[strongest]) / np.abs(influence[strongest]))
        # The correction that least squares would make with this plane alone.
        angle = float(np.angle(-np.vdot(influence, vibration)))
    rule = min(candidates, key=lambda name: candidates[name])
    mass = candidates[rule]
    return TrialMass(mass, rule, centrifugal_force(mass, radius_mm, speed_rpm), candidates, angle)


def examine_force(mass_g: float, radius_mm: float, speed_rpm: float, carried_kg: float, plane: int) -> Finding | None:
    """Warn, without refusing, of a trial mass whose force passes a tenth of the static load at its plane."""
    force = centrifugal_force(abs(mass_g), radius_mm, speed_rpm)
    load = carried_kg * GRAVITY
    if force <= SHARE_OF_LOAD * load * (1.0 + 1e-9):
        return None
    return Finding(
        Message(
            "trial_mass_large",
            mass=Quantity(abs(mass_g), "g"),
            radius=Quantity(radius_mm, "mm"),
            force=Quantity(force, "N"),
            speed=Quantity(speed_rpm, "r/min"),
            share=force / load,
            load=Quantity(load, "N"),
        ),
        "warning",
        planes=(plane,),
    )
