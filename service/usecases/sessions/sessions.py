"""Sessions: opened on a machine, read whole, changed a little, closed for good."""

from __future__ import annotations

from collections.abc import Sequence

from db.rows import CatalogueRow, MachineRow, SessionRow
from db.store import Store
from service.engine import session_state
from service.engine.validation import check_as_found, sensor_index
from service.errors import Conflict
from service.messages import Message
from service.model.machine import Catalogue
from service.model.plan import Plan
from service.model.session import (
    EarlierBox,
    Session,
    SessionLog,
    SessionPatch,
    SessionRecord,
    SessionRequest,
    SessionSummary,
)
from service.runtime.context import AppContext, require
from service.usecases.optimistic_lock import require_seen
from service.usecases.plans.reservations import let_go
from service.usecases.session_view import session_summary, session_view, set_apart
from service.version import __version__


def open_on(work: AppContext, request: SessionRequest) -> Session:
    """Open a session; the machine is copied into it as it is now. Raises NotFound or InvalidInput."""
    with work.write() as store:
        machine = require(store, MachineRow, request.machine_id)
        if request.catalogue_id is not None:
            require(store, CatalogueRow, request.catalogue_id)
        for index, entry in enumerate(request.run_out):
            sensor_index(machine.spec, entry.sensor, f"run_out[{index}].sensor")
        check_as_found(machine.spec, request.on_rotor)
        row = SessionRow(
            id=work.new_id(),
            machine_id=machine.id,
            machine_name=machine.name,
            machine=machine.spec,
            catalogue_id=request.catalogue_id,
            state="open",
            technician=request.technician,
            note=request.note,
            run_out=request.run_out,
            on_rotor=request.on_rotor,
            fitted_plan_id=None,
            created_at=work.now(),
            closed_at=None,
        )
        store.add(row)
        return session_view(store, row)


def get(work: AppContext, session_id: str) -> Session:
    """A session with all its runs, corrections and plans. Raises NotFound."""
    with work.read() as store:
        return session_view(store, require(store, SessionRow, session_id))


def find(
    work: AppContext,
    limit: int,
    offset: int,
    *,
    machine_id: str | None = None,
    state: str | None = None,
    words: str | None = None,
) -> tuple[SessionSummary, ...]:
    """Sessions, newest first, of a machine, in a state, or with words in machine, technician or note."""
    with work.read() as store:
        return tuple(
            session_summary(row)
            for row in store.sessions(limit, offset, machine_id=machine_id, state=state, words=words)
        )


def change(work: AppContext, session_id: str, patch: SessionPatch) -> Session:
    """Close a session, or change box, technician or note. Raises OutOfOrder once it is closed, Stale."""
    with work.write() as store:
        row = require(store, SessionRow, session_id, lock=True)
        require_seen(work, store, row)
        closed = session_state.after(row, "close")
        if patch.catalogue_id is not None and patch.catalogue_id != row.catalogue_id:
            if row.fitted_plan_id is not None:
                raise Conflict(Message("plan_fitted.box"), field="catalogue_id", value=patch.catalogue_id)
            row.catalogue_id = require(store, CatalogueRow, patch.catalogue_id).id
            let_go(store, row.id, work.now())
        row.technician = row.technician if patch.technician is None else patch.technician
        row.note = row.note if patch.note is None else patch.note
        if patch.state is not None:
            row.state, row.closed_at = closed, work.now()
            let_go(store, row.id, row.closed_at)
        store.flush()
        return session_view(store, row)


def log(work: AppContext, session_id: str) -> SessionLog:
    """The session as one document that gives its answers again, and can be imported. Raises NotFound."""
    with work.read() as store:
        return log_of(store, require(store, SessionRow, session_id))


def log_of(store: Store, row: SessionRow) -> SessionLog:
    """The document of a stored session."""
    view = session_view(store, row)
    stops = tuple(stop.stop for stop in store.stops(row.id))
    stored = tuple(plan.plan for plan in store.plans(row.id))
    box = None if row.catalogue_id is None else require(store, CatalogueRow, row.catalogue_id)
    return SessionLog(
        version=__version__,
        session_id=row.id,
        machine=row.machine,
        catalogue=None if box is None else Catalogue(name=box.name, items=box.items),
        earlier_boxes=_earlier_boxes(store, row, stored),
        run_out=row.run_out,
        on_rotor=row.on_rotor,
        runs=view.runs,
        corrections=view.corrections,
        plans=stored,
        unreadable=set_apart(store, row.id),
        record=SessionRecord(
            stops=stops,
            **{name: getattr(row, name) for name in SessionRecord.__dataclass_fields__ if name != "stops"},
        ),
    )


def _earlier_boxes(store: Store, row: SessionRow, plans: Sequence[Plan]) -> tuple[EarlierBox, ...]:
    """The boxes of plans that were made before the session was given the one it has, in their order."""
    named = dict.fromkeys(plan.inputs.catalogue_id for plan in plans)
    boxes = [require(store, CatalogueRow, key) for key in named if key is not None and key != row.catalogue_id]
    return tuple(EarlierBox(catalogue_id=b.id, catalogue=Catalogue(name=b.name, items=b.items)) for b in boxes)
