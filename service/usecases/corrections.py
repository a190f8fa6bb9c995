"""Corrections of a session: asked for, computed, stored."""

from __future__ import annotations

from dataclasses import replace

from db.documents.correction import Correction, CorrectionRequest
from db.rows import BalancerAnswerRow, CorrectionRow, SessionRow
from db.store import Store
from service.errors import Conflict, InvalidInput
from service.usecases import states
from service.usecases.runs import used
from service.usecases.solving import solve_correction
from service.usecases.work import Work, require


def add(work: Work, session_id: str, request: CorrectionRequest) -> Correction:
    """Compute and store a correction. Raises InvalidInput, NumericsError, NotFound, OutOfOrder."""
    with work.database.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        state = states.after(session, "correction")
        if request.source == "balancer":
            request = _with_masses(store, session, request)
        number = len(store.corrections(session.id)) + 1
        runs = used(store.runs(session.id))
        correction = solve_correction(session.machine, runs, session.run_out, request, number=number, key=work.new_id())
        store.add(CorrectionRow(id=correction.id, session_id=session.id, number=number, correction=correction))
        session.state = state
        return correction


def _with_masses(store: Store, session: SessionRow, request: CorrectionRequest) -> CorrectionRequest:
    """The request with the masses of the stored answer that it names."""
    if request.answer_id is None:
        return request
    if request.masses is not None:
        raise InvalidInput(
            "a balancer's answer is named or stated, not both",
            field="answer_id",
            value=request.answer_id,
            advice="leave out answer_id or masses",
        )
    answer = require(store, BalancerAnswerRow, request.answer_id)
    if answer.machine_id != session.machine_id or answer.session_id not in (None, session.id):
        raise Conflict(
            f"balancer answer {request.answer_id!r} belongs to another session",
            code="answer_of_other_session",
            field="answer_id",
            value=request.answer_id,
            advice="take an answer of this session",
        )
    return replace(request, masses=answer.masses)
