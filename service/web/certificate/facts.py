"""What a certificate says of the machine, its instruments and the conventions of its numbers."""

from __future__ import annotations

from service.engine import mapping
from service.model.machine import Machine, Plane, Sensor
from service.model.session import Session
from service.web.certificate.document import Facts, Lines, Table
from service.web.pictures.reader import Reader

DASH = "\N{EM DASH}"


def machine_facts(machine: Machine, reader: Reader) -> Facts:
    """Name, type, speed, mass, what is asked for."""
    _, show = reader.gettext, reader.show
    asked = [
        (_("Machine"), machine.name),
        (_("Type"), machine.type),
        (_("Service speed"), show.speed(machine.service_speed_rpm)),
        (
            _("Mass of the rotor"),
            None if machine.rotor_mass_kg is None else f"{reader.number(machine.rotor_mass_kg, 5)} kg",
        ),
        (_("Balance quality asked for"), grade(machine.balance_grade_mm_s, reader)),
        (_("Vibration limit"), _limit(machine, reader)),
    ]
    return Facts(tuple((name, value) for name, value in asked if value is not None))


def session_facts(session: Session, reader: Reader) -> Facts:
    """Who balanced when."""
    _ = reader.gettext
    asked = [
        (_("Balanced by"), session.technician),
        (_("Opened"), reader.moment(session.created_at)),
        (_("Closed"), None if session.closed_at is None else reader.moment(session.closed_at)),
        (_("Certificate"), number(session)),
        (_("Session"), session.id),
    ]
    return Facts(tuple((name, value) for name, value in asked if value is not None))


def number(session: Session) -> str:
    """A short number that a customer can quote: the day it was opened, and the beginning of the session's key."""
    return f"{session.created_at:%Y%m%d}-{session.id[:6].upper()}"


def note(session: Session, reader: Reader) -> Lines:
    """What was noted, if anything was."""
    return Lines((reader.gettext("Note: %(note)s") % {"note": session.note},) if session.note else ())


def sensors(machine: Machine, reader: Reader) -> Table:
    """The sensors: what they measure, where, and which one it was."""
    _, show = reader.gettext, reader.show
    directions = {
        "horizontal": _("horizontal"),
        "vertical": _("vertical"),
        "axial": _("axial"),
        "radial": _("radial"),
    }
    rows = tuple(
        (
            sensor.name,
            _measured(sensor, reader),
            directions.get(sensor.direction or "", DASH),
            sensor.bearing or DASH,
            show.length(sensor.axial_mm),
            _sensor_limit(machine, sensor, reader),
            sensor.serial or DASH,
        )
        for sensor in machine.sensors
    )
    heads = (_("Sensor"), _("Measures"), _("Direction"), _("Bearing"), _("Place"), _("Limit"), _("Serial number"))
    return Table(heads, rows, (14, 20, 11, 12, 12, 14, 17), frozenset({4, 5}))


def planes(machine: Machine, reader: Reader) -> Table:
    """The correction planes."""
    _, show = reader.gettext, reader.show

    def row(plane: Plane) -> tuple[str, ...]:
        return plane.name, show.length(plane.radius_mm), show.length(plane.axial_mm), str(len(plane.positions_deg))

    heads = (_("Correction plane"), _("Radius"), _("Place"), _("Holes"))
    return Table(heads, tuple(map(row, machine.planes)), (34, 22, 22, 22), frozenset({1, 2, 3}))


def conventions(machine: Machine, reader: Reader) -> Lines:
    """What every number is meant in."""
    _ = reader.gettext
    side = machine.seen_from or _("the end where the rotation is meant")
    turns = _("clockwise") if machine.rotation == "cw" else _("counter-clockwise")
    with_it = machine.angle_sense == "with_rotation"
    return Lines(
        (
            _("The drum turns %(way)s, seen from: %(side)s.") % {"way": turns, "side": side},
            _("Mass angles count in degrees from the key-phasor mark with the rotation.")
            if with_it
            else _("Mass angles count in degrees from the key-phasor mark against the rotation."),
            _("Phase (lag): degrees the drum turns from the mark passing the pick-up to the next positive peak.")
            if machine.phase_sense == "lag"
            else _(
                "Phase (lead): minus the degrees the drum turns from the mark passing the pick-up to the next peak."
            ),
            _("Amplitudes are the part at once per turn. Masses of a run are all masses beside those found."),
            _("Intervals hold the true value in 95 of 100 cases."),
        )
    )


def grade(mm_s: float | None, reader: Reader) -> str | None:
    """A balance quality grade, such as G 16."""
    return None if mm_s is None else f"G {reader.number(mm_s)}"


def _limit(machine: Machine, reader: Reader) -> str | None:
    if machine.vibration_limit_mm_s is None:
        return None
    return reader.show.amplitude(Sensor(name="any"), machine.vibration_limit_mm_s)


def _measured(sensor: Sensor, reader: Reader) -> str:
    _ = reader.gettext
    names = {"velocity": _("velocity"), "acceleration": _("acceleration"), "displacement": _("displacement")}
    return f"{names[sensor.quantity]}, {_(reader.amplitude_unit(sensor).sign)}"


def _sensor_limit(machine: Machine, sensor: Sensor, reader: Reader) -> str:
    limit = mapping.limit_of(machine, mapping.Channel(sensor, machine.service_speed_rpm))
    return reader.show.amplitude(sensor, limit)
