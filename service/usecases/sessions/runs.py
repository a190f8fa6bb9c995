"""Runs: typed in or taken from stored readings; excluded or superseded, never erased."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from db.rows import CorrectionRow, PlanRow, RunRow, SessionRow
from db.store import Store
from service.engine import mapping, session_state
from service.engine.balance_quality import speed_warnings, trial_warnings
from service.engine.evidence.follow_up import follow_up
from service.engine.validation import check_masses, sensor_index
from service.errors import InvalidInput, NotFound
from service.messages import Message, Word
from service.model.base import to_plain
from service.model.diagnostic import Diagnostic
from service.model.machine import Machine
from service.model.run import MassOnRotor, Run, RunPatch, RunReading, RunRequest
from service.runtime.context import AppContext, require
from service.usecases.optimistic_lock import require_seen
from service.usecases.readings.run_averaging import taken_readings


def add(work: AppContext, session_id: str, request: RunRequest) -> Run:
    """Store a run. Raises InvalidInput, NotFound, or OutOfOrder for a check of nothing or a closed session."""
    with work.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        require_seen(work, store, session)
        state = session_state.after(session, "check" if request.kind == "check" else "run")
        machine = session.machine
        masses = _masses(store, session, request)
        readings = _readings(store, session, request)
        nominal = request.nominal_speed_rpm or machine.service_speed_rpm
        heavy = trial_warnings(machine, masses) if request.kind == "trial" else ()
        run = Run(
            id=work.new_id(),
            number=store.next_number(RunRow, session.id),
            kind=request.kind,
            masses=masses,
            readings=readings,
            nominal_speed_rpm=nominal,
            taken_at=work.now(),
            warnings=(*speed_warnings(machine, nominal, readings), *heavy),
        )
        if request.kind == "check":
            run = replace(run, warnings=(*run.warnings, *_follow_up(store, session, run)))
        if request.supersedes is not None:
            mistyped = _run_of(store, session, request.supersedes)
            mistyped.run = replace(mistyped.run, excluded=True, reason=f"superseded by run {run.number}")
        store.add(RunRow(id=run.id, session_id=session.id, number=run.number, run=run))
        outdate(store, session.id)
        session.state = state
        return run


def change(work: AppContext, session_id: str, run_id: str, patch: RunPatch) -> Run:
    """Exclude a run, or take it in again. Raises NotFound, or OutOfOrder once the session is closed."""
    with work.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        require_seen(work, store, session)
        state = session_state.after(session, "run")
        row = _run_of(store, session, run_id)
        row.run = replace(row.run, excluded=patch.excluded, reason=patch.reason)
        outdate(store, session.id)
        session.state = state
        return row.run


def outdate(store: Store, session_id: str) -> None:
    """Mark what rests on the runs so far as stale; nothing is erased."""
    for correction in store.corrections(session_id):
        document = correction.correction
        if document.request.source == "fit" and not document.stale:
            correction.correction = replace(document, stale=True)
    for plan in store.plans(session_id):
        if plan.plan.state != "fitted" and not plan.plan.stale:
            plan.plan = replace(plan.plan, stale=True)


def _follow_up(store: Store, session: SessionRow, check: Run) -> tuple[Diagnostic, ...]:
    """What a check run says of the plan that it follows; of other masses than the plan's it says nothing."""
    plan = require(store, PlanRow, session.fitted_plan_id or "").plan
    if check.masses != mapping.masses_on_rotor(plan):
        return ()
    correction = require(store, CorrectionRow, plan.correction_id).correction
    earlier = [row.run for row in store.runs(session.id) if not row.run.excluded]
    return follow_up(session.machine, earlier, session.run_out, check, plan, correction.request.source)


def _run_of(store: Store, session: SessionRow, run_id: str) -> RunRow:
    row = store.get(RunRow, run_id)
    if row is None or row.session_id != session.id:
        raise NotFound(Message("not_found.run", session=session.id, run=run_id), field="run_id", value=run_id)
    return row


def _masses(store: Store, session: SessionRow, request: RunRequest) -> tuple[MassOnRotor, ...]:
    masses = request.masses
    if masses is None and request.kind == "check":
        plan = require(store, PlanRow, session.fitted_plan_id or "").plan
        return mapping.masses_on_rotor(plan)
    masses = masses or ()
    check_masses(session.machine, masses)
    if request.kind == "initial" and masses:
        raise InvalidInput(Message("invalid_input.initial_with_masses"), field="masses", value=len(masses))
    if request.kind in ("trial", "correction") and not masses:
        raise InvalidInput(Message("mass_missing", kind=Word(request.kind)), field="masses", value=0)
    return masses


def _readings(store: Store, session: SessionRow, request: RunRequest) -> tuple[RunReading, ...]:
    if (request.readings is None) == (request.take is None):
        both = request.take is not None
        raise InvalidInput(
            Message("invalid_input.readings_and_take" if both else "invalid_input.no_readings"),
            field="readings",
            value=to_plain(request.readings) if both else None,
        )
    if request.take is not None:
        return taken_readings(store, session, request.take, _released_at(store, session, request))
    readings = request.readings or ()
    _check_readings(session.machine, readings)
    return readings


def _released_at(store: Store, session: SessionRow, request: RunRequest) -> datetime | None:
    """When the machine was last released with other masses, unless the run is of the drum as it was found."""
    released = [row.stop.released_at for row in store.stops(session.id) if row.stop.released_at is not None]
    return released[-1] if released and request.kind != "initial" else None


def _check_readings(machine: Machine, readings: Sequence[RunReading]) -> None:
    seen: set[str] = set()
    for index, reading in enumerate(readings):
        sensor_index(machine, reading.sensor, f"readings[{index}].sensor")
        if reading.sensor in seen:
            raise InvalidInput(
                Message("sensor_twice", sensor=reading.sensor), field=f"readings[{index}].sensor", value=reading.sensor
            )
        seen.add(reading.sensor)
