"""The report of a session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Literal

import numpy as np

from db.documents.correction import Tolerance
from db.documents.diagnostic import Diagnostic
from db.documents.influence import Coefficient
from db.documents.machine import Machine
from db.documents.plan import Placement
from db.documents.report import BeforeAfter, PlaneLoad, Report, Zone
from db.documents.run import MassOnRotor, Run, RunOut
from db.documents.session import Session, SessionSummary
from service.balancing.corrections import least_squares
from service.balancing.phasors import phasor, polar
from service.balancing.tolerance import vibration_zone
from service.balancing.trim import combined, saved_mass
from service.balancing.units import Scale, convert_amplitude
from service.errors import InvalidInput
from service.usecases import mapping, quality, sessions
from service.usecases.fitting import fit_runs
from service.usecases.mapping import Channel, amplitudes_of, limit_of
from service.usecases.solving import examined
from service.usecases.work import Work
from service.version import __version__


def report(work: Work, session_id: str) -> Report:
    """What the session came to. Raises NotFound."""
    session = sessions.get(work, session_id)
    plan = next((p for p in session.plans if p.id == session.fitted_plan_id), None)
    fitted = () if plan is None else plan.fitted or ()
    return Report(
        session=SessionSummary(**{name: getattr(session, name) for name in SessionSummary.__dataclass_fields__}),
        version=__version__,
        written_at=work.now(),
        machine=session.machine,
        conventions=conventions(session.machine),
        runs=len(session.runs),
        excluded_runs=tuple(run.number for run in session.runs if run.excluded),
        before_after=before_after(session),
        fitted=fitted,
        planes=plane_loads(session.machine, fitted) if fitted else (),
        plan_status=None if plan is None else plan.status,
        plan_gap=None if plan is None else plan.gap,
        plan_unit=None if plan is None else plan.objective_unit,
        tolerance_missing=quality.tolerance_missing(session.machine),
        bearing_forces_n=None if plan is None else plan.bearing_forces_n,
        **vars(_of_all_runs(session)),
    )


Outcome = Literal["unchecked", "above_limit", "grade_not_reached", "nothing_asked", "reached"]


def outcome(report: Report) -> Outcome:
    """What the session came to, beside what was asked for: every limit, and the balance quality where one is stated."""
    checked = [line for line in report.before_after if line.after is not None]
    if not checked:
        return "unchecked"
    if any(line.within_limit is False for line in checked):
        return "above_limit"
    if report.tolerance is not None and not report.tolerance.within:
        return "grade_not_reached"
    if report.tolerance is None and all(line.within_limit is None for line in checked):
        return "nothing_asked"
    return "reached"


@dataclass(frozen=True)
class _OfAllRuns:
    """What a fit of all runs says."""

    tolerance: Tolerance | None = None
    influence: tuple[tuple[Coefficient, ...], ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


def _of_all_runs(session: Session) -> _OfAllRuns:
    machine = session.machine
    runs = [run for run in session.runs if not run.excluded]
    try:
        fitted = fit_runs(machine, runs, session.run_out)
        answer = least_squares(fitted.fit)
    except InvalidInput:
        # Too few runs, or runs without phase: the report says nothing of coefficients.
        return _OfAllRuns()
    still = answer.masses - mapping.mass_vectors(machine, runs[-1].masses)
    return _OfAllRuns(
        tolerance=quality.tolerance_of(machine, still, answer.covariance, int(fitted.fit.scatter_dof.min())),
        influence=mapping.coefficients(machine, fitted.rows, fitted.fit),
        diagnostics=examined(machine, runs, fitted),
    )


def plane_loads(machine: Machine, fitted: Sequence[Placement]) -> tuple[PlaneLoad, ...]:
    """What is bolted into each plane, and the one mass it comes to."""
    out = []
    for plane in machine.planes:
        pieces = tuple(piece for piece in fitted if piece.plane == plane.name)
        masses = mapping.as_masses(pieces)
        vectors = np.array([phasor(m.mass_g, m.angle_deg, machine.angle_sense) for m in masses], dtype=complex)
        planes = np.zeros(len(masses), dtype=np.int64)
        mass, angle = polar(complex(combined(vectors, planes, 1)[0]), machine.angle_sense)
        out.append(
            PlaneLoad(
                plane=plane.name,
                pieces=pieces,
                carried_g=sum(m.mass_g for m in masses),
                as_one=MassOnRotor(plane=plane.name, mass_g=mass, angle_deg=angle),
                saved=saved_mass(vectors, planes, 1),
            )
        )
    return tuple(out)


def before_after(session: Session) -> tuple[BeforeAfter, ...]:
    """Each sensor in the first initial run and in the latest check run at the same nominal speed."""
    return _before_after(session.machine, session.runs, session.run_out)


def trend(work: Work, machine_id: str, most: int) -> tuple[tuple[datetime, tuple[BeforeAfter, ...]], ...]:
    """When each of a machine's sessions was opened, and its sensors before and after: the newest first."""
    with work.read() as store:
        rows = store.sessions(most, 0, machine_id=machine_id)
        return tuple(
            (row.created_at, _before_after(row.machine, tuple(r.run for r in store.runs(row.id)), row.run_out))
            for row in rows
        )


def _before_after(machine: Machine, runs: tuple[Run, ...], run_out: tuple[RunOut, ...]) -> tuple[BeforeAfter, ...]:
    good = [run for run in runs if not run.excluded]
    out = []
    for first in _first_by_speed(good):
        speed = first.nominal_speed_rpm
        last = next((r for r in reversed(good) if r.kind == "check" and r.nominal_speed_rpm == speed), None)
        before = amplitudes_of(machine, first, run_out)
        after = {} if last is None else amplitudes_of(machine, last, run_out)
        for sensor in machine.sensors:
            if sensor.name in before:
                row = Channel(sensor, speed)
                line = _line(row, before[sensor.name], after.get(sensor.name), limit_of(machine, row))
                out.append(_with_zones(machine, line, row, first, last))
    return tuple(out)


def conventions(machine: Machine) -> tuple[str, ...]:
    """The conventions every number of the session is meant in."""
    angle = "against" if machine.angle_sense == "against_rotation" else "with"
    phase = (
        "degrees the rotor turns from the key-phasor mark passing the pick-up to the sensor's next positive peak"
        if machine.phase_sense == "lag"
        else "the negative of the degrees the rotor turns from the mark passing the pick-up to the next positive peak"
    )
    side = f", seen from {machine.seen_from}" if machine.seen_from else ""
    return (
        f"The rotor turns {machine.rotation}{side}.",
        f"Mass angles count in degrees from the key-phasor mark {angle} the rotation.",
        f"Phase ({machine.phase_sense}): {phase}.",
        "Amplitudes are the 1x component in each sensor's quantity, unit and detection.",
        "Corrections are the total to have on the as-found rotor, trial masses off.",
    )


def _first_by_speed(runs: list[Run]) -> list[Run]:
    first: dict[float, Run] = {}
    for run in runs:
        if run.kind == "initial":
            first.setdefault(run.nominal_speed_rpm, run)
    return list(first.values())


def _with_zones(machine: Machine, line: BeforeAfter, row: Channel, first: Run, last: Run | None) -> BeforeAfter:
    """Zones of ISO 20816-3 by the broadband velocity, where the machine states its group."""
    group = machine.iso_20816
    if group is None:
        return line

    def zone(run: Run | None) -> Zone | None:
        reading = None if run is None else next((r for r in run.readings if r.sensor == row.sensor.name), None)
        if reading is None or reading.overall_rms is None or row.sensor.quantity != "velocity":
            return None
        velocity = convert_amplitude(reading.overall_rms, Scale("velocity", row.sensor.unit, "rms"), Scale())
        return vibration_zone(velocity, group.group, group.support)

    return replace(line, zone_before=zone(first), zone_after=zone(last))


def _line(row: Channel, before: float, after: float | None, limit: float | None) -> BeforeAfter:
    return BeforeAfter(
        sensor=row.sensor.name,
        unit=f"{row.sensor.unit} {row.sensor.detection.replace('_', '-')}",
        speed_rpm=row.speed_rpm,
        before=before,
        after=after,
        reduction=None if after is None or before == 0.0 else 1.0 - after / before,
        limit=limit,
        within_limit=None if after is None or limit is None else after <= limit,
    )
