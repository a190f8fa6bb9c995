"""Correct and plan a session in memory: documents in, documents out, no storage."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

from service.engine.correction_solver import solve_correction
from service.engine.influence_fits import used
from service.engine.plan_solver import solve_plan
from service.engine.selection_problem import PlanContext
from service.errors import InvalidInput
from service.messages import Message
from service.model.correction import Correction, CorrectionRequest
from service.model.plan import Plan, PlanInputs, PlanRequest
from service.model.session import SessionLog
from service.version import __version__

EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def correct(session: SessionLog, **request: Any) -> Correction:
    """Return the continuous correction of a session.

    session: machine and runs, as `read_log` gives them; answers that it holds are not looked at. request: fields of
    `CorrectionRequest`, by default source fit. Masses in g, angles in degrees in the machine's conventions. Raises
    InvalidInput or NumericsError where request or runs do not allow an answer.
    """
    asked = CorrectionRequest(**{"source": "fit", **request})
    return solve_correction(session.machine, used(session.runs), session.run_out, asked, number=1, key="correction-1")


def plan(
    session: SessionLog,
    correction: Correction,
    *,
    monotonic: Callable[[], float] = time.monotonic,
    **request: Any,
) -> Plan:
    """Return which pieces of the session's box go into which positions to realise a correction.

    correction: from `correct` of the same session. request: fields of `PlanRequest` but `correction_id`, by default
    objective residual_vibration. monotonic: clock of the time limit, s. An infeasible problem is an answer with its
    reason. Raises InvalidInput where the session has no box or the request cannot be meant.
    """
    if session.catalogue is None:
        raise InvalidInput(Message("catalogue_missing.offline"), field="catalogue", value=None)
    asked = PlanRequest(**{"objective": "residual_vibration", **request, "correction_id": correction.id})
    inputs = PlanInputs(counts=tuple(item.count for item in session.catalogue.items), present=(), version=__version__)
    ground = PlanContext(
        machine=session.machine,
        items=session.catalogue.items,
        runs=session.runs,
        run_out=session.run_out,
        as_found=session.on_rotor,
        correction=correction,
        inputs=inputs,
    )
    return solve_plan(ground, asked, number=1, key="plan-1", session_id="", at=EPOCH, monotonic=monotonic)
