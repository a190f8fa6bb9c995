"""Machines, runs and a whole session for pictures, and how a drawn picture is read back."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any
from xml.etree import ElementTree as ET

from service.model.machine import Machine, Plane, Sensor
from service.model.run import MassOnRotor, Run, RunReading
from service.web.pictures.drawing import Group, Item, Picture
from service.web.pictures.svg import to_svg

WHEN = datetime(2026, 3, 14, 9, 26, tzinfo=UTC)
HOLES = (10.0, 55.0, 90.0, 200.0, 333.0)


def machine(**changes: Any) -> Machine:
    """A machine with two planes of five uneven holes and two sensors."""
    planes = tuple(Plane(name=name, radius_mm=330.0, positions_deg=HOLES, max_masses=5) for name in ("L", "R"))
    sensors = (Sensor(name="P", limit=0.7), Sensor(name="Q", quantity="displacement", unit="um", detection="peak"))
    usual: dict[str, Any] = {"name": "drum", "service_speed_rpm": 460.0, "planes": planes, "sensors": sensors}
    return Machine(**{**usual, **changes})


def run(number: int, kind: Any, vectors: dict[str, tuple[float, float | None]], *masses: MassOnRotor) -> Run:
    """A run with these amplitudes and phases."""
    readings = tuple(RunReading(sensor=s, amplitude=a, phase_deg=p) for s, (a, p) in vectors.items())
    return Run(
        id=f"r{number}",
        number=number,
        kind=kind,
        masses=masses,
        readings=readings,
        nominal_speed_rpm=460.0,
        taken_at=WHEN,
    )


def items(picture: Picture | Group) -> Iterator[Item]:
    """Every part of a picture, groups and what is in them."""
    for item in picture.items:
        yield item
        if isinstance(item, Group):
            yield from items(item)


def words_of(picture: Picture) -> list[str]:
    """Every word that is written in a picture, as the browser finds it; its SVG is well formed."""
    root = ET.fromstring(to_svg(picture, standalone=True))
    return [node.text or "" for node in root.iter("{http://www.w3.org/2000/svg}text")]
