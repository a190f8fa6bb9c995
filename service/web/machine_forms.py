"""The form of a machine: fields named like the document's, holes as a count or as a list of angles."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from service.model.machine import Bearing, Machine, Plane, Sensor
from service.web import numbers
from service.web.forms import Form
from service.web.language import N_
from service.web.rendering import Page
from service.web.units import KILOGRAMS, NEWTONS, TURNS

MOST_PLANES, MOST_SENSORS = 8, 16
UNITS = {
    "mm/s": "velocity",
    "in/s": "velocity",
    "um": "displacement",
    "mil": "displacement",
    "m/s2": "acceleration",
    "g": "acceleration",
}
DETECTIONS = {"rms": "rms", "peak": N_("peak"), "peak_to_peak": N_("peak to peak")}
ROTATIONS = {"cw": N_("clockwise"), "ccw": N_("counter-clockwise")}
ANGLE_SENSES = {"against_rotation": N_("against the rotation"), "with_rotation": N_("with the rotation")}
PHASE_SENSES = {"lag": N_("lag (usual)"), "lead": N_("lead")}
CHOICES: dict[str, Any] = {
    "units": UNITS,
    "detections": DETECTIONS,
    "rotations": ROTATIONS,
    "angle_senses": ANGLE_SENSES,
    "phase_senses": PHASE_SENSES,
}
LONGEST_LABEL = 100
_EVEN = 1e-6


def blank(page: Page) -> Form:
    """An empty form: two planes of 18 holes, a sensor at each end."""
    values = {"planes": "2", "sensors": "2", "rotation": "cw", "balance_grade_mm_s": "16"}
    for index in range(2):
        values |= {f"planes[{index}].name": str(index + 1), f"planes[{index}].holes": "18"}
        values |= {f"planes[{index}].max_masses": "3", f"planes[{index}].masses_per_position": "1"}
        values |= {f"planes[{index}].first_deg": "0", f"sensors[{index}].name": "AB"[index]}
    return Form(values, page.language)


def filled(page: Page, machine: Machine) -> Form:
    """The form of a stored machine."""
    show, values = page.display, {"planes": str(len(machine.planes)), "sensors": str(len(machine.sensors))}
    for name in ("name", "type", "seen_from"):
        values[name] = getattr(machine, name) or ""
    for name in ("rotor_mass_kg", "service_speed_rpm", "balance_grade_mm_s"):
        values[name] = show.plain(getattr(machine, name))
    limit = machine.vibration_limit_mm_s
    values["vibration_limit_mm_s"] = show.plain(limit)
    values |= {"rotation": machine.rotation, "angle_sense": machine.angle_sense, "phase_sense": machine.phase_sense}
    for index, plane in enumerate(machine.planes):
        values |= {f"planes[{index}].{name}": text for name, text in _plane_values(page, plane).items()}
    for index, sensor in enumerate(machine.sensors):
        values |= {f"sensors[{index}].{name}": text for name, text in _sensor_values(page, sensor).items()}
    return Form(values, page.language)


def count(form: Form, name: str) -> int:
    """How many planes or sensors the form has."""
    text = form.value(name, "1")
    most = MOST_PLANES if name == "planes" else MOST_SENSORS
    return min(max(int(text), 1), most) if text.isdecimal() and len(text) < 4 else 1


def resized(form: Form) -> bool:
    """Whether a plane or sensor was asked for or given up, with the form's own buttons."""
    for name in ("planes", "sensors"):
        for button, change in (("more", 1), ("fewer", -1)):
            if form.value(f"{button}_{name}"):
                form.values[name] = str(max(count(form, name) + change, 1))
                return True
    return False


def read(page: Page, form: Form, before: Machine | None = None) -> Machine | None:
    """The machine that was typed; None where a field is wrong. What the form does not show stays as it was before."""
    name = form.text("name", required=True)
    speed = form.number("service_speed_rpm", above=0.0, high=1e6, unit=TURNS)
    mass = form.number("rotor_mass_kg", above=0.0, high=1e6, unit=KILOGRAMS, required=False)
    grade = form.number("balance_grade_mm_s", above=0.0, high=1e5, required=False)
    limit = form.number("vibration_limit_mm_s", above=0.0, high=1e5, required=False)
    kind, side = form.text("type"), form.text("seen_from")
    rotation = form.choice("rotation", ROTATIONS)
    angle_sense = form.choice("angle_sense", ANGLE_SENSES, required=False) or "against_rotation"
    phase_sense = form.choice("phase_sense", PHASE_SENSES, required=False) or "lag"
    planes = [_plane(page, form, index, before) for index in range(count(form, "planes"))]
    placed = [_sensor(page, form, index, before) for index in range(count(form, "sensors"))]
    if not form.ok or name is None or speed is None:
        return None
    sensors = tuple(one for one in placed if one is not None)
    bearings = stated_bearings(before) or _derived(sensors)
    known = {bearing.name for bearing in bearings}
    return Machine(
        name=name,
        type=kind,
        rotor_mass_kg=mass,
        service_speed_rpm=speed,
        rotation=rotation or "ccw",  # type: ignore[arg-type]
        seen_from=side,
        balance_grade_mm_s=grade,
        vibration_limit_mm_s=limit,
        iso_20816=None if before is None else before.iso_20816,
        angle_sense=angle_sense,  # type: ignore[arg-type]
        phase_sense=phase_sense,  # type: ignore[arg-type]
        bearings=bearings,
        planes=tuple(one for one in planes if one is not None),
        sensors=tuple(one if one.bearing in known else replace(one, bearing=None) for one in sensors),
    )


def stated_bearings(machine: Machine | None) -> tuple[Bearing, ...]:
    """Bearings of a machine that do not merely stand where its sensors do: no field of the form shows them."""
    return () if machine is None or machine.bearings == _derived(machine.sensors) else machine.bearings


def _derived(sensors: tuple[Sensor, ...]) -> tuple[Bearing, ...]:
    """Two sensors at places of their own stand for the two bearings."""
    places = {sensor.axial_mm: sensor.name for sensor in sensors if sensor.axial_mm is not None}
    return tuple(Bearing(name=name, axial_mm=at) for at, name in places.items()) if len(places) == 2 else ()


def _plane(page: Page, form: Form, index: int, machine: Machine | None) -> Plane | None:
    where, unit = f"planes[{index}]", page.display.length_unit()
    name = form.text(f"{where}.name", required=True)
    radius = form.number(f"{where}.radius_mm", above=0.0, high=1e5, unit=unit)
    axial = form.number(f"{where}.axial_mm", low=-1e5, high=1e5, unit=unit, required=False)
    positions = _positions(form, where)
    per_hole = form.whole(f"{where}.masses_per_position", low=1, high=20)
    most = form.whole(f"{where}.max_masses", low=1, high=20)
    force = form.number(f"{where}.max_force_n", above=0.0, high=1e7, unit=NEWTONS, required=False)
    labels = _labels(form, where)
    if not form.ok or name is None or radius is None or per_hole is None or most is None:
        return None
    before = next((one for one in machine.planes if one.name == name), None) if machine is not None else None
    return Plane(
        name=name,
        radius_mm=radius,
        axial_mm=axial,
        positions_deg=positions,
        hole_labels=labels,
        masses_per_position=per_hole,
        max_masses=most,
        max_total_mass_g=None if before is None else before.max_total_mass_g,
        max_force_n=force,
    )


def _positions(form: Form, where: str) -> tuple[float, ...]:
    """Evenly spaced holes from the first one, or the angles as listed."""
    listed = form.text(f"{where}.positions_deg", most=4000, listed=True)
    if listed:
        out = []
        for part in listed.replace(";", " ").split():
            try:
                angle = numbers.read(part, form.language)
                if abs(angle) > 360.0:
                    form.wrong(f"{where}.positions_deg", N_("Angles lie within a turn: 0 to 360 degrees."))
                out.append(angle)
            except numbers.NotANumber as wrong:
                form.wrong(f"{where}.positions_deg", str(wrong))
        return tuple(out)
    count = form.whole(f"{where}.holes", low=1, high=360)
    first = form.angle(f"{where}.first_deg", required=False) or 0.0
    return tuple(round(first + 360.0 * n / count, 6) % 360.0 for n in range(count)) if count else ()


def _labels(form: Form, where: str) -> tuple[str, ...] | None:
    listed = form.text(f"{where}.hole_labels", most=4000, listed=True)
    labels = tuple(listed.replace(";", " ").split()) if listed else None
    if any(len(label) > LONGEST_LABEL for label in labels or ()):
        form.wrong(f"{where}.hole_labels", N_("At most %(most)s characters in one label."), most=LONGEST_LABEL)
    return labels


def _sensor(page: Page, form: Form, index: int, machine: Machine | None) -> Sensor | None:
    where = f"sensors[{index}]"
    name = form.text(f"{where}.name", required=True)
    axial = form.number(f"{where}.axial_mm", low=-1e5, high=1e5, unit=page.display.length_unit(), required=False)
    unit = form.choice(f"{where}.unit", UNITS, required=False) or "mm/s"
    detection = form.choice(f"{where}.detection", DETECTIONS, required=False) or "rms"
    limit = form.number(f"{where}.limit", above=0.0, high=1e6, required=False)
    serial = form.text(f"{where}.serial")
    if not form.ok or name is None:
        return None
    before = next((one for one in machine.sensors if one.name == name), None) if machine is not None else None
    return Sensor(
        name=name,
        axial_mm=axial,
        bearing=None if before is None else before.bearing,
        direction=None if before is None else before.direction,
        quantity=UNITS[unit],  # type: ignore[arg-type]
        unit=unit,  # type: ignore[arg-type]
        detection=detection,  # type: ignore[arg-type]
        limit=limit,
        serial=serial,
    )


def _plane_values(page: Page, plane: Plane) -> dict[str, str]:
    show, unit = page.display, page.display.length_unit()
    values = {
        "name": plane.name,
        "radius_mm": show.plain(unit.show(plane.radius_mm)),
        "axial_mm": "" if plane.axial_mm is None else show.plain(unit.show(plane.axial_mm)),
        "masses_per_position": str(plane.masses_per_position),
        "max_masses": str(plane.max_masses),
        "max_force_n": show.plain(plane.max_force_n),
        "hole_labels": " ".join(plane.hole_labels or ()),
    }
    angles, step = plane.positions_deg, 360.0 / len(plane.positions_deg)
    even = all(abs((at - angles[0] - n * step + 180.0) % 360.0 - 180.0) < _EVEN for n, at in enumerate(angles))
    if even:
        return values | {"holes": str(len(angles)), "first_deg": show.plain(angles[0])}
    return values | {"positions_deg": "; ".join(show.plain(at) for at in angles)}


def _sensor_values(page: Page, sensor: Sensor) -> dict[str, str]:
    at = sensor.axial_mm
    return {
        "name": sensor.name,
        "axial_mm": "" if at is None else page.display.plain(page.display.length_unit().show(at)),
        "unit": sensor.unit,
        "detection": sensor.detection,
        "limit": page.display.plain(sensor.limit),
        "serial": sensor.serial or "",
    }
