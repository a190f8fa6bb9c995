"""Reserve the pieces of a plan in stock until they are mounted."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime, timedelta

from db.rows import CatalogueRow, PlanRow, SessionRow
from db.store import Store
from service.engine import session_state
from service.errors import Conflict, OutOfOrder
from service.messages import Message
from service.model.plan import Plan
from service.model.stock import ReserveRequest
from service.runtime.context import AppContext, require
from service.usecases.optimistic_lock import require_seen
from service.usecases.stock import ledger


def reserve(work: AppContext, plan_id: str, request: ReserveRequest) -> Plan:
    """Hold the pieces that a plan takes from the box, all or none, in place of what its session held before.

    Pieces on the drum now count for the plan. Raises NotFound, OutOfOrder for a plan that is fitted or has no
    placements, Conflict where it is stale, from another box, or others have the pieces.
    """
    with work.write() as store:
        row, session, box = locked(store, plan_id)
        require_seen(work, store, row)
        session_state.after(session, "plan")
        require_its_box(row.plan, session)
        _require_reservable(row.plan)
        on_drum = require(store, PlanRow, session.fitted_plan_id).plan.fitted if session.fitted_plan_id else None
        net = ledger.net_of(box.items, back=on_drum or (), out=row.plan.placements)
        now = work.now()
        until = now + timedelta(minutes=request.minutes)
        let_go(store, session.id, now)
        wanted = {item: -pieces for item, pieces in net.items() if pieces < 0}
        ledger.reserve(store, box, wanted, at=now, until=until, session_id=session.id, plan_id=row.id)
        row.plan = replace(row.plan, reserved_until=until)
        store.flush()
        return row.plan


def release(work: AppContext, plan_id: str) -> Plan:
    """Hold nothing for a plan any more; no error where nothing is held. Raises NotFound, OutOfOrder once closed."""
    with work.write() as store:
        row, session, _box = locked(store, plan_id)
        require_seen(work, store, row)
        session_state.after(session, "plan")
        if row.plan.reserved_until is not None:
            let_go(store, session.id, work.now())
        store.flush()
        return row.plan


def let_go(store: Store, session_id: str, now: datetime) -> None:
    """Hold nothing for a session any more; the session is locked by the caller."""
    ledger.release(store, session_id, now)
    for row in store.plans(session_id):
        if row.plan.reserved_until is not None:
            row.plan = replace(row.plan, reserved_until=None)


def locked(store: Store, plan_id: str) -> tuple[PlanRow, SessionRow, CatalogueRow]:
    """Plan, session and box, locked in the one order that all writers keep. Raises NotFound."""
    found = require(store, PlanRow, plan_id)
    session = require(store, SessionRow, found.session_id, lock=True)
    box = require(store, CatalogueRow, session.catalogue_id or "", lock=True)
    return require(store, PlanRow, plan_id, lock=True), session, box


def require_its_box(plan: Plan, session: SessionRow) -> None:
    """Its masses mean pieces of the box that it was made from. Raises Conflict where the session has another one."""
    if plan.inputs.catalogue_id not in (None, session.catalogue_id):
        raise other_box(plan, session)


def other_box(plan: Plan, session: SessionRow) -> Conflict:
    """The session has another box than the plan was made from."""
    return Conflict(Message("box_changed", number=plan.number), field="catalogue_id", value=session.catalogue_id)


def require_placements(plan: Plan) -> None:
    """An infeasible plan has nothing to hold or fit. Raises OutOfOrder."""
    if plan.status == "infeasible":
        raise OutOfOrder(
            Message("plan_infeasible", number=plan.number, reason=plan.reason), field="plan_id", value=plan.id
        )


def _require_reservable(plan: Plan) -> None:
    require_placements(plan)
    if plan.state == "fitted":
        raise OutOfOrder(Message("plan_fitted.reserving", number=plan.number), field="plan_id", value=plan.id)
    if plan.stale:
        raise Conflict(Message("plan_stale.reserving", number=plan.number), field="plan_id", value=plan.id)
