"""A session as clients see it: what is stored, what is on the rotor now, and what is next."""

from __future__ import annotations

from dataclasses import replace

from db.rows import PlanRow, SessionRow
from db.store import Store
from service.engine.evidence.verdict import unchecked
from service.engine.rotor_state import Drum, on_rotor, updated
from service.engine.session_state import Progress, next_step
from service.messages import parameters_json, render
from service.model.message import MessageData
from service.model.plan import Plan
from service.model.session import Session, SessionSummary, SetApart
from service.runtime.context import require


def session_view(store: Store, row: SessionRow) -> Session:
    """A session with all its runs, corrections and plans."""
    drum = stored_drum(store, row)
    runs = drum.runs
    corrections = tuple(c.correction for c in store.corrections(row.id))
    plans = drum.plans if row.state == "closed" else tuple(_updated(drum, plan) for plan in drum.plans)
    progress = Progress(
        state=row.state,  # type: ignore[arg-type]
        machine=row.machine,
        runs=runs,
        corrections=corrections,
        plans=plans,
        stops=drum.stops,
    )
    following = next_step(progress)
    return Session(
        **vars(session_summary(row)),
        step=progress.step,
        next_step=render(following),
        next_step_data=MessageData(key=following.key, parameters=parameters_json(following)),
        machine=row.machine,
        run_out=row.run_out,
        on_rotor=row.on_rotor,
        runs=runs,
        corrections=corrections,
        plans=plans,
        fitted_plan_id=row.fitted_plan_id,
        masses_on_rotor=on_rotor(drum),
        unchecked=unchecked(drum),
        version=row.version,
        unreadable=set_apart(store, row.id),
    )


def set_apart(store: Store, session_id: str) -> tuple[SetApart, ...]:
    """Parts of a session that this unit of work met and could not read."""
    return tuple(
        SetApart(
            kind=fault.table,
            id=fault.key,
            number=number,
            field=".".join(part for part in (fault.column, fault.field) if part),
            rule=fault.rule,
        )
        for number, fault in store.set_apart(session_id)
    )


def stored_drum(store: Store, row: SessionRow) -> Drum:
    """What is stored of a session's drum."""
    return Drum(
        machine=row.machine,
        runs=tuple(r.run for r in store.runs(row.id)),
        run_out=row.run_out,
        plans=tuple(p.plan for p in store.plans(row.id)),
        stops=tuple(s.stop for s in store.stops(row.id)),
        as_found=row.on_rotor,
    )


def updated_plan(store: Store, row: PlanRow) -> Plan:
    """A plan with what to change on the rotor as it is now."""
    session = require(store, SessionRow, row.session_id)
    return row.plan if session.state == "closed" else _updated(stored_drum(store, session), row.plan)


def _updated(drum: Drum, plan: Plan) -> Plan:
    changes = updated(drum, plan)
    return plan if changes == plan.changes else replace(plan, changes=changes)


def session_summary(row: SessionRow) -> SessionSummary:
    """A session as lists show it."""
    return SessionSummary(
        id=row.id,
        state=row.state,  # type: ignore[arg-type]
        machine_id=row.machine_id,
        machine_name=row.machine_name,
        catalogue_id=row.catalogue_id,
        technician=row.technician,
        note=row.note,
        created_at=row.created_at,
        closed_at=row.closed_at,
    )
