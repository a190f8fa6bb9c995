"""Sessions with their runs, corrections and plans."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from service.api.dependencies import Key, Limit, Offset, SeenDep, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.correction import Correction, CorrectionRequest
from service.model.influence import TrialMassSuggestion
from service.model.plan import FittedRequest, FrontPoint, Plan, PlanRequest, WhatIf, WhatIfRequest
from service.model.report import Report
from service.model.run import Run, RunPatch, RunRequest
from service.model.session import Session, SessionLog, SessionPatch, SessionRequest, SessionState, SessionSummary
from service.model.stock import ReserveRequest
from service.usecases.machines import influence
from service.usecases.plans import corrections, plans, reservations
from service.usecases.sessions import log_import, reports, runs, sessions

router = APIRouter(route_class=StrictRoute)


@router.post("/sessions", status_code=201, tags=["sessions"], responses=errors(404))
def open_session(work: WorkDep, session: SessionRequest) -> Session:
    """Open a session on a machine, whose conventions are copied into it.

    Run-out amplitudes in each sensor's own unit, phases in degrees in the machine's `phase_sense`.
    """
    return sessions.open_on(work, session)


@router.get("/sessions", tags=["sessions"], responses=errors())
def list_sessions(
    work: WorkDep,
    limit: Limit = 50,
    offset: Offset = 0,
    machine_id: Annotated[str | None, Query(max_length=32, description="Only of this machine.")] = None,
    state: Annotated[SessionState | None, Query(description="Only in this state.")] = None,
) -> tuple[SessionSummary, ...]:
    """Sessions, newest first. Times in UTC (RFC 3339); a summary has no quantity with a unit."""
    return sessions.find(work, limit, offset, machine_id=machine_id, state=state)


@router.get("/sessions/{session_id}", tags=["sessions"], responses=errors(404))
def get_session(work: WorkDep, session_id: Key) -> Session:
    """A session with its runs, corrections and plans, and the next step.

    Masses in g, unbalance in g.mm, angles and phases in degrees in the machine's senses, amplitudes in each sensor's
    unit and detection.
    """
    return sessions.get(work, session_id)


@router.patch("/sessions/{session_id}", tags=["sessions"], responses=errors(404, 409, 412))
def change_session(work: SeenDep, session_id: Key, patch: SessionPatch) -> Session:
    """Close a session, or change its box, technician or note. Units as in `get_session`."""
    return sessions.change(work, session_id, patch)


@router.get("/sessions/{session_id}/log", tags=["sessions"], responses=errors(404))
def get_log(work: WorkDep, session_id: Key) -> SessionLog:
    """The session as one document that `drumtrue solve` takes as it is. Units as in `get_session`."""
    return sessions.log(work, session_id)


@router.post("/sessions/import", status_code=201, tags=["sessions"], responses=errors(409))
def import_session(work: WorkDep, log: SessionLog) -> Session:
    """Store a session of another service from its log, with its identifiers, state and version; stock is not touched.

    Machine and boxes are found by identifier or name, or created, boxes empty. The same log again changes nothing;
    another session under the same identifier is refused. Units as in `get_session`: g, degrees, sensors' units.
    """
    return log_import.import_one(work, log)


@router.get("/sessions/{session_id}/report.json", tags=["sessions"], responses=errors(404))
def get_report(work: WorkDep, session_id: Key) -> Report:
    """Before and after, masses and holes, and what is proved.

    Amplitudes in each sensor's unit and detection, masses in g, angles in degrees, forces in N.
    """
    return reports.report(work, session_id)


@router.post("/sessions/{session_id}/runs", status_code=201, tags=["runs"], responses=errors(404, 409, 412))
def add_run(work: SeenDep, session_id: Key, run: RunRequest) -> Run:
    """Store a run: ALL masses on the rotor during it, relative to the as-found rotor, and what the sensors said.

    Masses in g, angles and phases in degrees in the machine's senses, amplitude and scatter in the sensor's unit and
    detection, speed in r/min.
    """
    return runs.add(work, session_id, run)


@router.patch("/sessions/{session_id}/runs/{run_id}", tags=["runs"], responses=errors(404, 409, 412))
def change_run(work: SeenDep, session_id: Key, run_id: Key, patch: RunPatch) -> Run:
    """Exclude a mistyped run, or take it in again; nothing is erased. Units as in `add_run`."""
    return runs.change(work, session_id, run_id, patch)


@router.get("/sessions/{session_id}/trial-masses", tags=["runs"], responses=errors(404))
def suggest_trial_masses(work: WorkDep, session_id: Key) -> tuple[TrialMassSuggestion, ...]:
    """Suggest a trial mass for each plane, and its angle from earlier coefficients and the initial run.

    Masses in g, angles in degrees in the machine's `angle_sense`, force in N at service speed.
    """
    return influence.suggest_trials(work, session_id)


@router.post(
    "/sessions/{session_id}/corrections", status_code=201, tags=["corrections"], responses=errors(404, 409, 412)
)
def add_correction(work: SeenDep, session_id: Key, correction: CorrectionRequest) -> Correction:
    """Compute the continuous correction masses: the TOTAL to have on the as-found rotor, trial masses off.

    Masses in g, unbalance in g.mm, angles and phases in degrees, influence in the sensor's unit per g.
    """
    return corrections.add(work, session_id, correction)


@router.post("/sessions/{session_id}/plans", status_code=201, tags=["plans"], responses=errors(404, 409, 412, 503))
def add_plan(work: SeenDep, session_id: Key, plan: PlanRequest) -> Plan:
    """Choose which stock masses go into which holes; an infeasible problem is answered with its reason.

    Masses in g, positions in degrees and as hole labels, objective in `objective_unit`, amplitudes in each sensor's
    unit, bearing forces in N, times in s.
    """
    return plans.propose(work, session_id, plan)


@router.get("/plans/{plan_id}", tags=["plans"], responses=errors(404))
def get_plan(work: WorkDep, plan_id: Key) -> Plan:
    """One plan. Units as in `add_plan`: g, degrees, the objective's unit, N, s."""
    return plans.get(work, plan_id)


@router.get("/plans/{plan_id}/front", tags=["plans"], responses=errors(404, 409, 503))
def get_front(work: WorkDep, plan_id: Key) -> tuple[FrontPoint, ...]:
    """The best selection for each number of masses, as far as one more makes it better.

    From the box that the plan was made from, as it was then; `other_box` names it where the session has another one
    now. Masses in g, positions in degrees, objective in the plan's `objective_unit`.
    """
    return plans.front(work, plan_id)


@router.post("/plans/{plan_id}/what-if", tags=["plans"], responses=errors(404, 409, 503))
def ask_what_if(work: WorkDep, plan_id: Key, what_if: WhatIfRequest) -> WhatIf:
    """The plan with pieces missing or bought, or holes blocked; nothing is stored.

    The box is the one that the plan was made from, as it was then, or `worse_by` would compare two boxes; `other_box`
    names it where the session has another one now. Masses in g, positions in degrees, objective in `objective_unit`.
    """
    return plans.what_if(work, plan_id, what_if)


@router.post("/plans/{plan_id}/reserve", tags=["plans"], responses=errors(404, 409, 412))
def reserve_plan(work: SeenDep, plan_id: Key, reserve: ReserveRequest) -> Plan:
    """Hold the pieces of a plan, all or none, so that no one else can fit them; in place of what was held before.

    They are held until fitted, released or the time is over. Masses in g, stock in pieces, time in minutes.
    """
    return reservations.reserve(work, plan_id, reserve)


@router.post("/plans/{plan_id}/release", tags=["plans"], responses=errors(404, 409, 412))
def release_plan(work: SeenDep, plan_id: Key) -> Plan:
    """Hold the pieces of a plan no longer. Masses in g, stock in pieces."""
    return reservations.release(work, plan_id)


@router.post("/plans/{plan_id}/fitted", tags=["plans"], responses=errors(404, 409, 412))
def fit_plan(work: SeenDep, plan_id: Key, fitted: FittedRequest) -> Plan:
    """Report the masses of a plan bolted on: they leave the stock, all or none.

    Masses in g, positions in degrees; where `actual` differs from the plan, its predictions are made again.
    """
    return plans.fitted(work, plan_id, fitted)


@router.post("/plans/{plan_id}/unfit", tags=["plans"], responses=errors(404, 409, 412))
def unfit_plan(work: SeenDep, plan_id: Key) -> Plan:
    """Report the masses of the fitted plan taken off: they go back to stock. Masses in g, positions in degrees."""
    return plans.unfit(work, plan_id)
