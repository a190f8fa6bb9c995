"""Changes of masses as a page shows them: in order, with the force of each piece."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from service.balancing.influence.trial_mass import centrifugal_force
from service.engine.rotor_state import mass_on_rotor_g
from service.model.machine import Machine
from service.model.plan import Change

Action = Literal["off", "on", "stay"]
_ACTIONS: dict[str, Action] = {"remove": "off", "add": "on", "keep": "stay"}
_ORDER = {"off": 0, "on": 1, "stay": 2}


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
    """A piece that did not come from the box: of the as-found rotor, or a trial mass."""


def moves(machine: Machine, changes: Iterable[Change]) -> list[Move]:
    """Changes in the order they are done in: taking off first, then bolting on; by plane and angle."""
    planes = [plane.name for plane in machine.planes]
    out = [_move(machine, change) for change in changes]
    return sorted(out, key=lambda m: (_ORDER[m.action], planes.index(m.plane), m.angle_deg))


def force(machine: Machine, plane: str, mass_g: float) -> float:
    """Centrifugal force in N of a mass in g in a plane, at service speed."""
    radius = next(one.radius_mm for one in machine.planes if one.name == plane)
    return centrifugal_force(abs(mass_g), radius, machine.service_speed_rpm)


def _move(machine: Machine, change: Change) -> Move:
    piece = change.placement
    grams = mass_on_rotor_g(piece)
    return Move(
        action=_ACTIONS[change.action],
        plane=piece.plane,
        hole=piece.hole or None,
        angle_deg=piece.position_deg,
        mass_g=grams,
        force_n=force(machine, piece.plane, grams),
        as_found=not piece.from_box,
    )
