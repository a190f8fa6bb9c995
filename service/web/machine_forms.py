"""The form of a machine: fields named like the document's, holes as a count or as a list of angles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from service.model.machine import Bearing, Machine, Plane, Sensor
from service.web import numbers
from service.web.forms import LONGEST, Form
from service.web.language import N_
from service.web.rendering import Page
from service.web.units import KILOGRAMS, NEWTONS, TURNS

MAX_PLANES, MAX_SENSORS = 8, 64
UNITS = {
    "mm/s": "velocity",
    "in/s": "velocity",
    "um": "displacement",
    "mm": "displacement",
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
MAX_LABEL = 100
_EVEN = 1e-6
FIELDS_OF = {"positions_deg": ("holes", "first_deg", "positions_deg")}
"""Fields of the form for what has several."""


def blank(page: Page) -> Form:
    """An empty form: two planes of 18 holes, a sensor at each end."""
    values = {"planes": "2", "sensors": "2"}
    for index in range(2):
        values |= {f"planes[{index}].name": str(index + 1), f"planes[{index}].holes": "18"}
        values |= {f"planes[{index}].max_masses": "3", f"planes[{index}].masses_per_position": "1"}
        values |= {f"planes[{index}].first_deg": "0", f"sensors[{index}].name": "AB"[index]}
    return Form(values, page.preferences)


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
    return Form(values, page.preferences)


def count(form: Form, name: str) -> int:
    """How many planes or sensors the form has."""
    text = form.value(name, "1")
    most = MAX_PLANES if name == "planes" else MAX_SENSORS
    return min(max(int(text), 1), most) if text.isdecimal() and len(text) < 4 else 1


def resized(form: Form) -> bool:
    """Whether a plane or sensor was asked for or given up, with the form's own buttons."""
    for name in ("planes", "sensors"):
        for button, change in (("more", 1), ("fewer", -1)):
            if form.value(f"{button}_{name}"):
                form.values[name] = str(max(count(form, name) + change, 1))
                return True
    return False


class _Edit:
    """A form against what the page showed of the stored machine: a field no one touched keeps its stored value.

    Shown and typed again a value may change (units, rounding), or have no field at all.
    """

    def __init__(self, page: Page, form: Form, before: Machine | None) -> None:
        self.page = page
        self.form = form
        self.before = before
        self._shown = {} if before is None else filled(page, before).values

    def untouched(self, *names: str) -> bool:
        """Whether fields hold what the page showed of the stored machine."""
        typed = (self.form.value(name).strip() for name in names)
        return self.before is not None and all(
            text == self._shown.get(name, "")[:LONGEST].strip() for name, text in zip(names, typed, strict=True)
        )

    def changes(self, where: str, readers: Mapping[str, Callable[[], Any]]) -> dict[str, Any]:
        """What was typed into the fields of a part that were touched; readers: how each is read."""
        return {
            name: read_field()
            for name, read_field in readers.items()
            if not self.untouched(*(f"{where}{field}" for field in FIELDS_OF.get(name, (name,))))
        }


def read(page: Page, form: Form, before: Machine | None = None) -> Machine | None:
    """The machine that was typed; None where a field is wrong. What was not touched stays as it was before."""
    edit = _Edit(page, form, before)
    typed = edit.changes(
        "",
        {
            "name": lambda: form.text("name", required=True),
            "service_speed_rpm": lambda: form.number("service_speed_rpm", above=0.0, high=1e6, unit=TURNS),
            "rotor_mass_kg": lambda: form.number("rotor_mass_kg", above=0.0, high=1e6, unit=KILOGRAMS, required=False),
            "balance_grade_mm_s": lambda: form.number("balance_grade_mm_s", above=0.0, high=1e5, required=False),
            "vibration_limit_mm_s": lambda: form.number("vibration_limit_mm_s", above=0.0, high=1e5, required=False),
            "type": lambda: form.text("type"),
            "seen_from": lambda: form.text("seen_from", required=True),
            "rotation": lambda: form.choice("rotation", ROTATIONS) or "ccw",
            "angle_sense": lambda: form.choice("angle_sense", ANGLE_SENSES) or "against_rotation",
            "phase_sense": lambda: form.choice("phase_sense", PHASE_SENSES, required=False) or "lag",
        },
    )
    planes = [_plane(edit, index) for index in range(count(form, "planes"))]
    sensors = [_sensor(edit, index) for index in range(count(form, "sensors"))]
    if not form.ok:
        return None
    typed |= {
        "planes": tuple(p for p in planes if p is not None),
        "sensors": tuple(s for s in sensors if s is not None),
    }
    if before is None:
        return Machine(**typed, bearings=_derived(typed["sensors"]))
    return _with_bearings(before, replace(_plain(before), **typed))


def _plain(machine: Machine) -> Machine:
    """The machine alone, of one that is stored."""
    return Machine(**{name: getattr(machine, name) for name in Machine.__dataclass_fields__})


def _with_bearings(before: Machine, machine: Machine) -> Machine:
    """The machine with its bearings: as stated, or where the sensors stand now where they did before."""
    places = [[(one.name, one.axial_mm) for one in of.sensors] for of in (before, machine)]
    if places[0] == places[1]:
        return machine
    bearings = stated_bearings(before) or _derived(machine.sensors)
    known = {bearing.name for bearing in bearings}
    sensors = tuple(one if one.bearing in known else replace(one, bearing=None) for one in machine.sensors)
    return replace(machine, bearings=bearings, sensors=sensors)


def stated_bearings(machine: Machine | None) -> tuple[Bearing, ...]:
    """Bearings of a machine that do not merely stand where its sensors do: no field of the form shows them."""
    return () if machine is None or machine.bearings == _derived(machine.sensors) else machine.bearings


def _derived(sensors: tuple[Sensor, ...]) -> tuple[Bearing, ...]:
    """Two sensors at places of their own stand for the two bearings."""
    places = {sensor.axial_mm: sensor.name for sensor in sensors if sensor.axial_mm is not None}
    return tuple(Bearing(name=name, axial_mm=at) for at, name in places.items()) if len(places) == 2 else ()


def _plane(edit: _Edit, index: int) -> Plane | None:
    form, where, unit = edit.form, f"planes[{index}].", edit.page.display.length_unit()
    number, whole = form.number, form.whole
    typed = edit.changes(
        where,
        {
            "name": lambda: form.text(f"{where}name", required=True),
            "radius_mm": lambda: number(f"{where}radius_mm", above=0.0, high=1e5, unit=unit),
            "axial_mm": lambda: number(f"{where}axial_mm", low=-1e5, high=1e5, unit=unit, required=False),
            "positions_deg": lambda: _positions(form, where),
            "hole_labels": lambda: _labels(form, where),
            "masses_per_position": lambda: whole(f"{where}masses_per_position", low=1, high=20),
            "max_masses": lambda: whole(f"{where}max_masses", low=1, high=20),
            "max_force_n": lambda: number(f"{where}max_force_n", above=0.0, high=1e7, unit=NEWTONS, required=False),
        },
    )
    known = edit.before.planes if edit.before is not None else ()
    if not form.ok:
        return None
    return replace(known[index], **typed) if index < len(known) else Plane(**typed)


def _positions(form: Form, where: str) -> tuple[float, ...]:
    """Evenly spaced holes from the first one, or the angles as listed."""
    listed = form.text(f"{where}positions_deg", most=4000, listed=True)
    if listed:
        out = []
        for part in listed.replace(";", " ").split():
            try:
                angle = numbers.read(part, form.language)
                if abs(angle) > 360.0:
                    form.wrong(f"{where}positions_deg", N_("Angles lie within a turn: 0 to 360 degrees."))
                out.append(angle)
            except numbers.NotANumber as wrong:
                form.wrong(f"{where}positions_deg", str(wrong))
        return tuple(out)
    count = form.whole(f"{where}holes", low=1, high=360)
    first = form.angle(f"{where}first_deg", required=False) or 0.0
    return tuple(round(first + 360.0 * n / count, 6) % 360.0 for n in range(count)) if count else ()


def _labels(form: Form, where: str) -> tuple[str, ...] | None:
    listed = form.text(f"{where}hole_labels", most=4000, listed=True)
    parted = [one.strip() for one in listed.split(";")] if listed and ";" in listed else (listed or "").split()
    labels = tuple(one for one in parted if one) or None
    if any(len(label) > MAX_LABEL for label in labels or ()):
        form.wrong(f"{where}hole_labels", N_("At most %(most)s characters in one label."), most=MAX_LABEL)
    return labels


def _sensor(edit: _Edit, index: int) -> Sensor | None:
    form, where, length = edit.form, f"sensors[{index}].", edit.page.display.length_unit()
    typed = edit.changes(
        where,
        {
            "name": lambda: form.text(f"{where}name", required=True),
            "axial_mm": lambda: form.number(f"{where}axial_mm", low=-1e5, high=1e5, unit=length, required=False),
            "unit": lambda: form.choice(f"{where}unit", UNITS, required=False) or "mm/s",
            "detection": lambda: form.choice(f"{where}detection", DETECTIONS, required=False) or "rms",
            "limit": lambda: form.number(f"{where}limit", above=0.0, high=1e6, required=False),
            "serial": lambda: form.text(f"{where}serial"),
        },
    )
    if "unit" in typed and typed["unit"] is not None:
        typed["quantity"] = UNITS[typed["unit"]]
    known = edit.before.sensors if edit.before is not None else ()
    if not form.ok:
        return None
    return replace(known[index], **typed) if index < len(known) else Sensor(**typed)


def _plane_values(page: Page, plane: Plane) -> dict[str, str]:
    show, unit = page.display, page.display.length_unit()
    values = {
        "name": plane.name,
        "radius_mm": show.plain(unit.show(plane.radius_mm)),
        "axial_mm": "" if plane.axial_mm is None else show.plain(unit.show(plane.axial_mm)),
        "masses_per_position": str(plane.masses_per_position),
        "max_masses": str(plane.max_masses),
        "max_force_n": show.plain(plane.max_force_n),
        "hole_labels": _listed(plane.hole_labels or ()),
    }
    angles, step = plane.positions_deg, 360.0 / len(plane.positions_deg)
    even = all(abs((at - angles[0] - n * step + 180.0) % 360.0 - 180.0) < _EVEN for n, at in enumerate(angles))
    if even:
        return values | {"holes": str(len(angles)), "first_deg": show.plain(angles[0])}
    return values | {"positions_deg": "; ".join(show.plain(at) for at in angles)}


def _listed(labels: Sequence[str]) -> str:
    """Labels parted by blanks, or by semicolons where one holds a blank."""
    return ("; " if any(" " in label for label in labels) else " ").join(labels)


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
