"""A session's report as one table: a row for every number, in the units it is stored in."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from service.model.machine import Machine, Sensor
from service.model.report import Report
from service.model.run import Run
from service.model.session import Session
from service.usecases.sessions.csv_cells import safe_cell

HEADS = ("record", "number", "name", "quantity", "value", "unit")
Row = tuple[str | float | None, ...]


def report_csv(session: Session, report: Report) -> str:
    """The report of a session as CSV, columns `HEADS`.

    record: machine, sensor, plane, run, reading, mass, before_after, fitted, taken_off, influence, tolerance. number:
    of the run. name: of sensor, plane or hole. Angles and phases in degrees in the machine's senses. Numbers are in
    full, with a point; what cannot be known is empty.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow(HEADS)
    writer.writerows([safe_cell(cell) for cell in row] for row in _rows(session, report))
    return out.getvalue()


def _rows(session: Session, report: Report) -> Iterator[Row]:
    machine = session.machine
    sensors = {sensor.name: sensor for sensor in machine.sensors}
    yield from _machine(machine, session)
    for run in session.runs:
        yield from _run(run, sensors)
    for line in report.before_after:
        unit = _unit(sensors[line.sensor])
        yield "before_after", None, line.sensor, "speed", line.speed_rpm, "r/min"
        yield "before_after", None, line.sensor, "before", line.before, unit
        yield "before_after", None, line.sensor, "after", line.after, unit
        yield "before_after", None, line.sensor, "limit", line.limit, unit
    plan = next((p for p in session.plans if p.id == session.fitted_plan_id), None)
    for record, pieces in (("fitted", report.fitted), ("taken_off", () if plan is None else plan.taken_off)):
        for piece in pieces:
            name = f"{piece.plane} / {piece.hole}"
            yield record, None, name, "position", piece.position_deg, "deg"
            yield record, None, name, "mass", piece.mass_g, "g"
            yield record, None, name, "fastener", piece.fastener_g, "g"
            yield record, None, name, "weighed", piece.weighed_g, "g"
    yield from _computed(report, sensors)


def _machine(machine: Machine, session: Session) -> Iterator[Row]:
    for quantity, value, unit in (
        ("session", session.id, None),
        ("technician", session.technician, None),
        ("opened", session.created_at.isoformat(), None),
        ("closed", None if session.closed_at is None else session.closed_at.isoformat(), None),
        ("service_speed", machine.service_speed_rpm, "r/min"),
        ("rotor_mass", machine.rotor_mass_kg, "kg"),
        ("balance_grade", machine.balance_grade_mm_s, "mm/s"),
        ("rotation", machine.rotation, None),
        ("seen_from", machine.seen_from, None),
        ("angle_sense", machine.angle_sense, None),
        ("phase_sense", machine.phase_sense, None),
    ):
        yield "machine", None, machine.name, quantity, value, unit
    for sensor in machine.sensors:
        yield "sensor", None, sensor.name, "serial", sensor.serial, None
        yield "sensor", None, sensor.name, "limit", sensor.limit, _unit(sensor)
    for plane in machine.planes:
        yield "plane", None, plane.name, "radius", plane.radius_mm, "mm"


def _run(run: Run, sensors: dict[str, Sensor]) -> Iterator[Row]:
    yield "run", run.number, run.kind, "speed", run.nominal_speed_rpm, "r/min"
    if run.excluded:
        yield "run", run.number, run.kind, "excluded", run.reason, None
    for mass in run.masses:
        yield "mass", run.number, mass.plane, "mass", mass.mass_g, "g"
        yield "mass", run.number, mass.plane, "angle", mass.angle_deg, "deg"
    for reading in run.readings:
        unit = _unit(sensors[reading.sensor])
        yield "reading", run.number, reading.sensor, "amplitude", reading.amplitude, unit
        yield "reading", run.number, reading.sensor, "phase", reading.phase_deg, "deg"
        yield "reading", run.number, reading.sensor, "scatter", reading.scatter, unit


def _computed(report: Report, sensors: dict[str, Sensor]) -> Iterator[Row]:
    for row in report.influence:
        for c in row:
            name, unit = f"{c.sensor} / {c.plane} / {c.speed_rpm:g} r/min", f"{_unit(sensors[c.sensor])} per g"
            yield "influence", None, name, "amplitude", c.amplitude_per_g, unit
            yield "influence", None, name, "phase", c.phase_deg, "deg"
            yield "influence", None, name, "scatter", c.scatter_per_g, unit
    tolerance = report.tolerance
    if tolerance is not None:
        yield "tolerance", None, "grade", "reached", tolerance.grade_reached_mm_s, "mm/s"
        if tolerance.interval is not None:
            yield "tolerance", None, "grade", "low", tolerance.interval.low, "mm/s"
            yield "tolerance", None, "grade", "high", tolerance.interval.high, "mm/s"
        for bearing in tolerance.bearings:
            yield "tolerance", None, bearing.bearing, "permissible", bearing.permissible_gmm, "g.mm"
            yield "tolerance", None, bearing.bearing, "residual", bearing.residual_gmm, "g.mm"


def _unit(sensor: Sensor) -> str:
    return f"{sensor.unit} {sensor.detection}"
