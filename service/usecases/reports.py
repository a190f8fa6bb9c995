"""The report of a session."""

from __future__ import annotations

from db.documents.machine import Machine
from db.documents.report import BeforeAfter, Report
from db.documents.run import Run
from db.documents.session import Session, SessionSummary
from service.usecases import sessions
from service.usecases.mapping import Channel, amplitudes_of, limit_of
from service.usecases.work import Work
from service.version import __version__


def report(work: Work, session_id: str) -> Report:
    """What the session came to. Raises NotFound."""
    session = sessions.get(work, session_id)
    plan = next((p for p in session.plans if p.id == session.fitted_plan_id), None)
    return Report(
        session=SessionSummary(**{name: getattr(session, name) for name in SessionSummary.__dataclass_fields__}),
        version=__version__,
        written_at=work.now(),
        machine=session.machine,
        conventions=conventions(session.machine),
        runs=len(session.runs),
        excluded_runs=tuple(run.number for run in session.runs if run.excluded),
        before_after=before_after(session),
        fitted=() if plan is None else plan.fitted or (),
        plan_status=None if plan is None else plan.status,
        plan_gap=None if plan is None else plan.gap,
        plan_unit=None if plan is None else plan.objective_unit,
        bearing_forces_n=None if plan is None else plan.bearing_forces_n,
    )


def before_after(session: Session) -> tuple[BeforeAfter, ...]:
    """Each sensor in the first initial run and in the latest check run at the same nominal speed."""
    good = [run for run in session.runs if not run.excluded]
    out = []
    for first in _first_by_speed(good):
        speed = first.nominal_speed_rpm
        last = next((r for r in reversed(good) if r.kind == "check" and r.nominal_speed_rpm == speed), None)
        before = amplitudes_of(session.machine, first, session.run_out)
        after = {} if last is None else amplitudes_of(session.machine, last, session.run_out)
        for sensor in session.machine.sensors:
            if sensor.name in before:
                row = Channel(sensor, speed)
                out.append(_line(row, before[sensor.name], after.get(sensor.name), limit_of(session.machine, row)))
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
