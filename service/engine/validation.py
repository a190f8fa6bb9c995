"""Validate what types cannot: names that must exist, angles that must be positions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import get_args

from service.balancing.rotor.phasors import normal_degrees
from service.balancing.rotor.units import Scale, is_unit_of
from service.errors import InvalidInput, NumericsError
from service.messages import Message, Quantity, Word
from service.model.machine import Catalogue, CatalogueItem, Machine, Plane, Sensor, Unit
from service.model.run import MassOnRotor
from service.model.session import AsFoundPiece

OVER_SPEED = 1.02
"""Measured over service speed at most: the reading of a tachometer, not a licence to run faster."""
POSITION_TOLERANCE_DEG = 1e-6
"""How far a stated angle may lie from a position and still name it: the rounding of a decimal, no more."""


def normalised(machine: Machine) -> Machine:
    """The machine with its positions in 0 <= angle < 360, once all its rules hold. Raises InvalidInput."""
    for field in ("planes", "sensors", "bearings"):
        require_unique(field, [part.name for part in getattr(machine, field)])
    for index, sensor in enumerate(machine.sensors):
        _check_sensor(machine, f"sensors[{index}]", sensor)
    places = [bearing.axial_mm for bearing in machine.bearings]
    if len(set(places)) != len(places):
        raise InvalidInput(Message("invalid_input.bearings_coincide", places=places), field="bearings", value=places)
    planes = tuple(_checked_plane(f"planes[{index}]", plane) for index, plane in enumerate(machine.planes))
    return replace(machine, planes=planes)


def highest_speed(machine: Machine) -> float:
    """The speed, r/min, above which the machine is run too fast."""
    return OVER_SPEED * machine.service_speed_rpm


def check_catalogue(catalogue: Catalogue) -> None:
    """A mass appears once in a box. Raises InvalidInput."""
    require_unique("items", [item.mass_g for item in catalogue.items])


def plane_index(machine: Machine, name: str, field: str) -> int:
    """Index of a plane. Raises InvalidInput."""
    return _index([plane.name for plane in machine.planes], name, field, "correction plane")


def sensor_index(machine: Machine, name: str, field: str) -> int:
    """Index of a sensor. Raises InvalidInput."""
    return _index([sensor.name for sensor in machine.sensors], name, field, "sensor")


def position_index(plane: Plane, angle_deg: float, field: str) -> int:
    """Index of the position at this angle. Raises InvalidInput."""
    place = hole_at(plane, angle_deg)
    if place is not None:
        return place.index
    raise InvalidInput(
        Message(
            "invalid_input.not_a_position",
            angle=Quantity(angle_deg, "deg"),
            plane=plane.name,
            positions=[Quantity(p, "deg") for p in plane.positions_deg],
        ),
        field=field,
        value=angle_deg,
    )


@dataclass(frozen=True)
class Hole:
    """A position of a plane: its index, and its label as on the drum."""

    index: int
    label: str


def same_angle(one_deg: float, other_deg: float) -> bool:
    """Whether two angles name the same position."""
    away = abs(one_deg - other_deg) % 360.0
    return min(away, 360.0 - away) <= POSITION_TOLERANCE_DEG


def hole_at(plane: Plane, angle_deg: float) -> Hole | None:
    """The position at this angle; None where there is none."""
    for index, position in enumerate(plane.positions_deg):
        if same_angle(position, angle_deg):
            return Hole(index, hole_label(plane, index))
    return None


def label_at(plane: Plane, angle_deg: float) -> str | None:
    """The label of the position at this angle; None where there is none."""
    place = hole_at(plane, angle_deg)
    return None if place is None else place.label


def hole_label(plane: Plane, position: int) -> str:
    """What the technician finds beside a position: its label, else its number in the order of the positions."""
    return plane.hole_labels[position] if plane.hole_labels else str(position + 1)


def check_masses(machine: Machine, masses: Iterable[MassOnRotor], field: str = "masses") -> None:
    """Every mass is in a plane of the machine and is a mass. Raises InvalidInput."""
    for index, mass in enumerate(masses):
        plane_index(machine, mass.plane, f"{field}[{index}].plane")
        if mass.mass_g == 0.0:
            raise InvalidInput(Message("invalid_input.zero_mass"), field=f"{field}[{index}].mass_g", value=0.0)


def check_answer(machine: Machine, masses: Sequence[MassOnRotor]) -> None:
    """A balancer's answer states each plane once; 0 g says that nothing is needed there. Raises InvalidInput."""
    check_masses(machine, (mass for mass in masses if mass.mass_g != 0.0))
    for index, mass in enumerate(masses):
        plane_index(machine, mass.plane, f"masses[{index}].plane")
    named = [mass.plane for mass in masses]
    if len(set(named)) != len(named):
        raise InvalidInput(Message("invalid_input.answer_plane_twice"), field="masses", value=named)


def check_as_found(machine: Machine, pieces: Iterable[AsFoundPiece]) -> None:
    """Every piece on the as-found rotor sits in a position of the machine. Raises InvalidInput."""
    for index, piece in enumerate(pieces):
        plane = machine.planes[plane_index(machine, piece.plane, f"on_rotor[{index}].plane")]
        position_index(plane, piece.position_deg, f"on_rotor[{index}].position_deg")


def _check_sensor(machine: Machine, field: str, sensor: Sensor) -> None:
    try:
        Scale(sensor.quantity, sensor.unit, sensor.detection)
    except NumericsError as wrong:
        message = Message("invalid_input.sensor_scale", cause=wrong.data)
        if wrong.field == "unit":
            fitting = [unit for unit in get_args(Unit) if is_unit_of(sensor.quantity, unit)]
            message = Message("invalid_input.sensor_unit", cause=wrong.data, units=fitting)
        raise InvalidInput(message, field=f"{field}.{wrong.field}", value=wrong.value) from None
    if sensor.bearing is not None:
        _index([bearing.name for bearing in machine.bearings], sensor.bearing, f"{field}.bearing", "bearing")


def _checked_plane(field: str, plane: Plane) -> Plane:
    positions = tuple(normal_degrees(angle) for angle in plane.positions_deg)
    require_unique(f"{field}.positions_deg", [round(angle, 6) % 360.0 for angle in positions])
    if plane.hole_labels is not None:
        require_unique(f"{field}.hole_labels", plane.hole_labels)
        if len(plane.hole_labels) != len(positions):
            raise InvalidInput(
                Message("invalid_input.hole_labels", labels=len(plane.hole_labels), positions=len(positions)),
                field=f"{field}.hole_labels",
                value=len(plane.hole_labels),
            )
    room = len(positions) * plane.masses_per_position
    if plane.max_masses > room:
        raise InvalidInput(
            Message(
                "invalid_input.more_masses_than_room", masses=plane.max_masses, positions=len(positions), room=room
            ),
            field=f"{field}.max_masses",
            value=plane.max_masses,
        )
    return replace(plane, positions_deg=positions)


def require_unique(field: str, values: Iterable[object]) -> None:
    """Refuse a value that appears twice. Raises InvalidInput."""
    seen: set[object] = set()
    for value in values:
        if value in seen:
            raise InvalidInput(Message("invalid_input.twice", field=field, value=value), field=field, value=value)
        seen.add(value)


def _index(names: list[str], name: str, field: str, noun: str) -> int:
    if name in names:
        return names.index(name)
    raise InvalidInput(
        Message("invalid_input.unknown_part", noun=Word(noun), name=name, names=names), field=field, value=name
    )


def item_of(items: Sequence[CatalogueItem], mass_g: float, field: str) -> int:
    """Index of the item of this mass. Raises InvalidInput."""
    for index, item in enumerate(items):
        if item.mass_g == mass_g:
            return index
    raise InvalidInput(
        Message(
            "invalid_input.unknown_mass",
            mass=Quantity(mass_g, "g"),
            masses=[Quantity(item.mass_g, "g") for item in items[:20]],
        ),
        field=field,
        value=mass_g,
    )
