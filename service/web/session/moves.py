"""Which pieces go on, come off or stay, from what is on the rotor now to what is to be on it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from service.balancing.influence.trial_mass import centrifugal_force
from service.engine import mapping
from service.model.machine import Machine
from service.model.plan import Placement
from service.model.run import MassOnRotor
from service.web.session.guide import hole_at

Action = Literal["off", "on", "stay"]
_ORDER = {"off": 0, "on": 1, "stay": 2}
_SAME_G = 0.05
"""Two statements of one piece differ by no more: a tenth of a gram is what a field balance reads."""
_SAME_DEG = 1e-3


@dataclass(frozen=True)
class Move:
    """One piece: mass in g (fastener included), angle in degrees, force in N at service speed."""

    action: Action
    plane: str
    hole: str | None
    angle_deg: float
    mass_g: float
    force_n: float
    as_found: bool = False
    """A piece that was on the rotor before anything was done to it."""


def moves(machine: Machine, present: Iterable[MassOnRotor], wanted: Iterable[MassOnRotor]) -> list[Move]:
    """What to do, taking off first; masses of as-found pieces that are off are negative in both."""
    left, out = list(present), []
    for mass in wanted:
        same = next((one for one in left if _alike(one, mass)), None)
        if same is not None:
            left.remove(same)
            if mass.mass_g > 0.0:
                out.append(_move(machine, "stay", mass))
        else:
            out.append(_move(machine, "on" if mass.mass_g > 0.0 else "off", mass))
    out += [_move(machine, "off" if mass.mass_g > 0.0 else "on", mass) for mass in left]
    planes = [plane.name for plane in machine.planes]
    return sorted(out, key=lambda m: (_ORDER[m.action], planes.index(m.plane), m.angle_deg))


def wanted_by(placements: Sequence[Placement], taken_off: Sequence[Placement]) -> tuple[MassOnRotor, ...]:
    """The masses of a plan, relative to the as-found rotor."""
    off = tuple(
        MassOnRotor(plane=m.plane, mass_g=-m.mass_g, angle_deg=m.angle_deg) for m in mapping.as_masses(taken_off)
    )
    return (*mapping.as_masses(placements), *off)


def force(machine: Machine, plane: str, mass_g: float) -> float:
    """Centrifugal force in N of a mass in g in a plane, at service speed."""
    radius = next(one.radius_mm for one in machine.planes if one.name == plane)
    return centrifugal_force(abs(mass_g), radius, machine.service_speed_rpm)


def _move(machine: Machine, action: Action, mass: MassOnRotor) -> Move:
    plane = next(one for one in machine.planes if one.name == mass.plane)
    return Move(
        action=action,
        plane=mass.plane,
        hole=hole_at(plane, mass.angle_deg),
        angle_deg=mass.angle_deg,
        mass_g=abs(mass.mass_g),
        force_n=force(machine, mass.plane, mass.mass_g),
        as_found=mass.mass_g < 0.0,
    )


def _alike(one: MassOnRotor, other: MassOnRotor) -> bool:
    turn = abs(one.angle_deg - other.angle_deg) % 360.0
    same_place = one.plane == other.plane and min(turn, 360.0 - turn) < _SAME_DEG
    return same_place and abs(one.mass_g - other.mass_g) < _SAME_G
