"""Coefficients learned on one geometry, taken to another: converted where that is exact, refused where it is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from service.balancing.rotor.units import Scale, convert_amplitude
from service.errors import Conflict
from service.messages import Message
from service.model.influence import InfluenceRow, LearnedOn, PlaneLearnedOn, SavedInfluence, SensorLearnedOn, Vector
from service.model.machine import Machine, Plane, Sensor

SAME_PLACE_MM = 0.01
"""Axial positions that differ by no more are the same: a place typed in another unit is rounded."""


def learned_on(machine: Machine) -> LearnedOn:
    """What coefficients of a machine hold for."""
    return LearnedOn(
        rotation=machine.rotation,
        planes=tuple(PlaneLearnedOn(name=p.name, radius_mm=p.radius_mm, axial_mm=p.axial_mm) for p in machine.planes),
        sensors=tuple(
            SensorLearnedOn(
                name=s.name,
                quantity=s.quantity,
                unit=s.unit,
                detection=s.detection,
                axial_mm=s.axial_mm,
                direction=s.direction,
            )
            for s in machine.sensors
        ),
    )


def for_machine(saved: SavedInfluence, machine: Machine, learned: LearnedOn | None = None) -> SavedInfluence:
    """Return the coefficients as they are on a machine whose radii, units or detections are others.

    A mass acts by its unbalance, so that a coefficient per gram grows with the radius; unit and detection are factors.
    learned: what they were learned on, where they do not say it. Raises Conflict where a plane or sensor sits
    elsewhere, a sensor measures another quantity or direction, or the rotor turns the other way: then the coefficients
    are others, and nothing tells which.
    """
    before = saved.learned_on or learned
    if before is None:
        return saved
    moved = _moved(before, machine)
    if moved:
        raise Conflict(Message("influence_of_other_geometry", parts=moved), field="source", value="saved_influence")
    radii = {plane.name: plane.radius_mm for plane in before.planes}
    now = {plane.name: plane.radius_mm for plane in machine.planes}
    columns = np.array([now[p] / radii[p] if p in now and p in radii else 1.0 for p in saved.planes])
    sensors = {sensor.name: sensor for sensor in machine.sensors}
    factors = {
        old.name: convert_amplitude(1.0, _scale(old), _scale(sensors[old.name]))
        for old in before.sensors
        if old.name in sensors
    }
    rows = tuple(_scaled(row, factors.get(row.sensor, 1.0) * columns) for row in saved.rows)
    return replace(saved, rows=rows, learned_on=learned_on(machine))


def _moved(before: LearnedOn, machine: Machine) -> list[str]:
    """Names of the planes and sensors that are not what they were."""
    planes = {plane.name: plane for plane in machine.planes}
    sensors = {sensor.name: sensor for sensor in machine.sensors}
    out = [old.name for old in before.planes if old.name in planes and _elsewhere(old, planes[old.name])]
    for old in before.sensors:
        new = sensors.get(old.name)
        if new is None:
            continue
        turned = None not in (old.direction, new.direction) and old.direction != new.direction
        if old.quantity != new.quantity or turned or _elsewhere(old, new):
            out.append(old.name)
    return [*out, machine.name] if before.rotation != machine.rotation else out


def _elsewhere(old: PlaneLearnedOn | SensorLearnedOn, new: Plane | Sensor) -> bool:
    return old.axial_mm is not None and new.axial_mm is not None and abs(old.axial_mm - new.axial_mm) > SAME_PLACE_MM


def _scale(sensor: Sensor | SensorLearnedOn) -> Scale:
    # The texts of a stored document are those of the sensor it was made of.
    as_sensor = cast("Sensor", sensor)
    return Scale(as_sensor.quantity, as_sensor.unit, as_sensor.detection)


def _scaled(row: InfluenceRow, factors: np.ndarray[tuple[int], np.dtype[np.float64]]) -> InfluenceRow:
    spread = row.covariance
    return replace(
        row,
        influence=tuple(_times(v, float(f)) for v, f in zip(row.influence, factors, strict=True)),
        covariance=None
        if spread is None
        else tuple(_line(line, float(f) * factors) for line, f in zip(spread, factors, strict=True)),
    )


def _line(line: Sequence[Vector], factors: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[Vector, ...]:
    return tuple(_times(v, float(f)) for v, f in zip(line, factors, strict=True))


def _times(vector: Vector, factor: float) -> Vector:
    return vector[0] * factor, vector[1] * factor
