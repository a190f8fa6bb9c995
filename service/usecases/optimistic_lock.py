"""Versions: nobody changes what somebody else has changed since he looked."""

from __future__ import annotations

from db.rows import PlanRow, SessionRow
from db.store import Store
from service.engine import session_state
from service.engine.verdict import Drum, unchecked
from service.errors import Stale
from service.model.session import Session, SessionSummary, SetApart
from service.runtime.context import Work, require


def require_seen(work: Work, store: Store, row: SessionRow | PlanRow) -> None:
    """The row, locked by the caller, is at the version that the request was made on, if it says so. Raises Stale."""
    noun, version = ("plan", row.plan.version) if isinstance(row, PlanRow) else ("session", row.version)
    if work.seen in (None, version):
        return
    raise Stale(
        f"the {noun} is at version {version}, the request was made on version {work.seen}",
        field="If-Match",
        value=work.seen,
        advice=f"look at the {noun} as it is now (`current`), then decide again",
        current=row.plan if isinstance(row, PlanRow) else session_view(store, row),
    )


def hold(work: Work, session_id: str) -> None:
    """Keep a session as it is until the unit of work under way ends. Raises NotFound, Stale."""
    with work.write() as store:
        require_seen(work, store, require(store, SessionRow, session_id, lock=True))


def session_view(store: Store, row: SessionRow) -> Session:
    """A session with all its runs, corrections and plans."""
    drum = stored_drum(store, row)
    runs = drum.runs
    corrections = tuple(c.correction for c in store.corrections(row.id))
    return Session(
        **vars(session_summary(row)),
        next_step=session_state.next_step(row.state, row.machine, runs, corrections),
        machine=row.machine,
        run_out=row.run_out,
        on_rotor=row.on_rotor,
        runs=runs,
        corrections=corrections,
        plans=drum.plans,
        fitted_plan_id=row.fitted_plan_id,
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
    )


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
