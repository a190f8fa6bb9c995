"""Balance quality, static and couple parts, trial masses: what follows from a fit and the rotor's geometry."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from service.balancing.influence.static_couple import decompose
from service.balancing.influence.trial_mass import examine_force, suggest
from service.balancing.rotor.phasors import ComplexArray, FloatArray, to_degrees
from service.balancing.rotor.tolerance import Permissible, in_bearing_planes, permissible, reached
from service.engine import mapping
from service.engine.validation import highest_speed, plane_index
from service.errors import InvalidInput, NumericsError
from service.messages import Message, Quantity
from service.model.correction import Assumption, BearingTolerance, StaticCouple, Tolerance
from service.model.diagnostic import Diagnostic, diagnostic
from service.model.influence import TrialMassSuggestion
from service.model.machine import Machine
from service.model.run import MassOnRotor, RunReading

ASSUMPTIONS: tuple[Assumption, ...] = ("rigid_rotor", "no_bow")
"""What a balance quality from vibration assumes: runs at one speed cannot show either."""


def tolerance_of(machine: Machine, still_needed: ComplexArray, covariance: FloatArray, dof: float) -> Tolerance | None:
    """Balance quality (ISO 21940-11) of a rotor that still needs the masses `still_needed` (P,) complex g.

    None where grade, rotor mass, two bearings about the mass centre or the planes' places are not stated.
    """
    asked = _permissible(machine)
    places = mapping.plane_places(machine)
    bearings = mapping.bearing_places(machine)
    if asked is None or places is None or bearings is None or machine.balance_grade_mm_s is None:
        return None
    names, at = bearings
    radius = np.array([plane.radius_mm for plane in machine.planes])
    now = reached(asked, machine.balance_grade_mm_s, still_needed, covariance, dof, radius, places, at)
    return Tolerance(
        grade_mm_s=machine.balance_grade_mm_s,
        permissible_gmm=asked.total_g_mm,
        specific_um=asked.specific_um,
        bearings=tuple(
            BearingTolerance(bearing=name, permissible_gmm=float(most), residual_gmm=float(abs(left)))
            for name, most, left in zip(names, asked.bearing_g_mm, now.bearing_g_mm, strict=True)
        ),
        grade_reached_mm_s=now.grade_mm_s,
        interval=mapping.interval(now.low, now.high),
        within=now.within,
        surely=now.surely,
        assumptions=ASSUMPTIONS,
    )


def share_of_permissible(machine: Machine) -> FloatArray | None:
    """Unbalance in the bearing planes over what is permissible there (2, P), per g in each plane, by ISO 21940-11.

    None where no balance quality can be stated, see `tolerance_missing`.
    """
    asked, places, bearings = _permissible(machine), mapping.plane_places(machine), mapping.bearing_places(machine)
    if asked is None or places is None or bearings is None:
        return None
    radius = np.array([plane.radius_mm for plane in machine.planes])
    each = np.diag(radius).astype(np.complex128)
    per_gram = np.stack([in_bearing_planes(row, places, bearings[1]) for row in each], axis=1)
    return np.asarray(per_gram.real / asked.bearing_g_mm[:, None], dtype=np.float64)


def tolerance_missing(machine: Machine) -> Message | None:
    """Why no balance quality can be stated although the machine has a grade; None without a grade, or where it can."""
    if machine.balance_grade_mm_s is None:
        return None
    if machine.rotor_mass_kg is None:
        return Message("grade_not_judged.rotor_mass_missing")
    bearings = mapping.bearing_places(machine)
    if bearings is None or mapping.plane_places(machine) is None:
        return Message("grade_not_judged.bearings_missing")
    try:
        permissible(machine.balance_grade_mm_s, machine.rotor_mass_kg, machine.service_speed_rpm, bearings[1])
    except NumericsError as error:
        return Message("grade_not_judged.not_permissible", cause=error.data)
    return None


def static_couple_of(machine: Machine, masses: ComplexArray) -> StaticCouple | None:
    """Masses of two planes taken apart; None but for two planes with the mass centre between them."""
    places = mapping.plane_places(machine)
    if len(masses) != 2 or places is None or not places[0] * places[1] < 0.0:
        return None
    parts = decompose(masses, np.array([plane.radius_mm for plane in machine.planes]), places)
    return StaticCouple(
        static=mapping.plane_masses(machine, parts.static),
        couple=mapping.plane_masses(machine, parts.couple),
        unbalance_gmm=abs(parts.unbalance),
        moment_gmm2=abs(parts.moment),
    )


def trial_masses(
    machine: Machine, influence: ComplexArray | None, vibration: ComplexArray | None
) -> tuple[TrialMassSuggestion, ...]:
    """Trial mass of each plane; influence (S, P) and vibration (S,) from earlier sessions and the initial run, if any.

    Raises InvalidInput where the machine does not state its rotor's mass.
    """
    if machine.rotor_mass_kg is None:
        raise InvalidInput(Message("invalid_input.rotor_mass_missing"), field="rotor_mass_kg", value=None)
    asked = _permissible(machine)
    out = []
    for p, plane in enumerate(machine.planes):
        found = suggest(
            carried_kg(machine, p),
            plane.radius_mm,
            machine.service_speed_rpm,
            None if asked is None else asked.total_g_mm / len(machine.planes),
            None if influence is None else influence[:, p],
            vibration,
        )
        out.append(
            TrialMassSuggestion(
                plane=plane.name,
                mass_g=found.mass_g,
                rule=found.rule,
                force_n=found.force_n,
                angle_deg=None if found.angle is None else to_degrees(found.angle, machine.angle_sense),
                candidates={str(rule): mass for rule, mass in found.candidates.items()},
            )
        )
    return tuple(out)


def trial_warnings(machine: Machine, masses: Iterable[MassOnRotor]) -> tuple[Diagnostic, ...]:
    """Warn of a trial mass that pulls with more than a tenth of the static load, with its force in N."""
    if machine.rotor_mass_kg is None:
        return ()
    out = []
    for mass in masses:
        p = plane_index(machine, mass.plane, "masses.plane")
        plane = machine.planes[p]
        found = examine_force(mass.mass_g, plane.radius_mm, machine.service_speed_rpm, carried_kg(machine, p), p)
        if found is not None:
            out.append(diagnostic(found.data, found.severity, planes=(plane.name,)))
    return tuple(out)


def speed_warnings(machine: Machine, nominal_rpm: float, readings: Iterable[RunReading]) -> tuple[Diagnostic, ...]:
    """Warn of a run above service speed, which was taken already: refused, it would be lost. Speeds in r/min."""
    fast = {one.sensor: one.speed_rpm for one in readings if (one.speed_rpm or 0.0) > highest_speed(machine)}
    fastest = max(nominal_rpm, *(speed for speed in fast.values() if speed is not None), 0.0)
    if fastest <= highest_speed(machine):
        return ()
    told = Message(
        "over_speed", speed=Quantity(fastest, "r/min"), service_speed=Quantity(machine.service_speed_rpm, "r/min")
    )
    return (diagnostic(told, "warning", sensors=tuple(fast)),)


def _permissible(machine: Machine) -> Permissible | None:
    bearings = mapping.bearing_places(machine)
    if machine.balance_grade_mm_s is None or machine.rotor_mass_kg is None or bearings is None:
        return None
    try:
        return permissible(machine.balance_grade_mm_s, machine.rotor_mass_kg, machine.service_speed_rpm, bearings[1])
    except NumericsError:
        # An overhung rotor: its tolerances follow other rules, and there is nothing to state here.
        return None


def carried_kg(machine: Machine, p: int) -> float:
    """Mass that the bearing next to plane p carries; half the rotor's where the places are not stated."""
    mass = machine.rotor_mass_kg or 0.0
    bearings, place = mapping.bearing_places(machine), machine.planes[p].axial_mm
    if bearings is None or place is None:
        return mass / 2.0
    a, b = bearings[1]
    if not a * b < 0.0:
        return mass / 2.0
    near_a = abs(place - a) <= abs(place - b)
    return float(mass * abs(b if near_a else a) / abs(b - a))
