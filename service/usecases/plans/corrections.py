"""Corrections of a session: asked for, computed, stored."""

from __future__ import annotations

from dataclasses import replace

from db.rows import BalancerAnswerRow, CorrectionRow, SessionRow
from db.store import Store
from service.engine import session_state
from service.engine.correction_solver import check_fields, solve_correction
from service.engine.influence_fits import used
from service.engine.rotor_state import on_rotor
from service.errors import Conflict, InvalidInput
from service.messages import Message
from service.model.correction import Correction, CorrectionRequest
from service.model.run import Run
from service.runtime.context import AppContext, require
from service.usecases.machines.influence import saved_for
from service.usecases.optimistic_lock import require_seen
from service.usecases.plans.answer_doubts import doubts_of
from service.usecases.session_view import stored_drum


def add(work: AppContext, session_id: str, request: CorrectionRequest) -> Correction:
    """Compute and store a correction. Raises InvalidInput, NumericsError, NotFound, OutOfOrder."""
    check_fields(request)
    with work.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        require_seen(work, store, session)
        state = session_state.after(session, "correction")
        if request.source == "balancer":
            request = _with_masses(store, session, request)
        saved = None
        if request.source == "saved_influence":
            saved = saved_for(store, session, request.influence_of or "machine")
        number = store.next_number(CorrectionRow, session.id)
        correction = solve_correction(
            session.machine,
            used(row.run for row in store.runs(session.id)),
            session.run_out,
            request,
            number=number,
            key=work.new_id(),
            saved=saved,
            earlier=_earlier_runs(store, session, request.earlier_sessions or ()),
            on_rotor=on_rotor(stored_drum(store, session)),
        )
        _require_valid_coefficients(correction)
        if request.source == "balancer":
            doubts = doubts_of(store, session, request)
            correction = replace(correction, diagnostics=(*correction.diagnostics, *doubts))
        store.add(CorrectionRow(id=correction.id, session_id=session.id, number=number, correction=correction))
        session.state = state
        return correction


def _require_valid_coefficients(correction: Correction) -> None:
    """Refuse another round by coefficients that this session's runs contradict: it would make matters worse."""
    wrong = next((one for one in correction.diagnostics if one.code == "coefficients_outdated"), None)
    if wrong is not None:
        raise Conflict(
            wrong.data or Message("coefficients_outdated", sensors=wrong.sensors),
            field="source",
            value=correction.request.source,
        )


def _earlier_runs(store: Store, session: SessionRow, keys: tuple[str, ...]) -> tuple[tuple[Run, ...], ...]:
    """Runs of earlier sessions on the machine, a tuple a session."""
    out = []
    for index, key in enumerate(keys):
        other = require(store, SessionRow, key)
        if other.machine_id != session.machine_id or other.id == session.id or _differ(other, session):
            raise Conflict(
                Message("session_of_other_machine.earlier", session=key), field=f"earlier_sessions[{index}]", value=key
            )
        out.append(used(row.run for row in store.runs(other.id)))
    return tuple(out)


def _differ(other: SessionRow, session: SessionRow) -> bool:
    def matters(row: SessionRow) -> tuple[object, ...]:
        spec = row.machine
        radii = [(plane.name, plane.radius_mm) for plane in spec.planes]
        return (radii, spec.sensors, spec.angle_sense, spec.phase_sense, spec.rotation, row.run_out)

    return matters(other) != matters(session)


def _with_masses(store: Store, session: SessionRow, request: CorrectionRequest) -> CorrectionRequest:
    """The request with the masses of the stored answer that it names."""
    if request.answer_id is None:
        return request
    if request.masses is not None:
        raise InvalidInput(Message("invalid_input.answer_named_and_stated"), field="answer_id", value=request.answer_id)
    answer = require(store, BalancerAnswerRow, request.answer_id)
    if answer.machine_id != session.machine_id or answer.session_id not in (None, session.id):
        raise Conflict(
            Message("answer_of_other_session", answer=request.answer_id), field="answer_id", value=request.answer_id
        )
    return replace(request, masses=answer.masses)
