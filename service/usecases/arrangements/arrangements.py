"""Arrangements: proposed, questioned, stated mounted."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime

from db.rows import ArrangementRow, CatalogueRow, CorrectionRow, MachineRow, PlanRow, SessionRow
from db.store import Store
from service.engine import arrangement as engine
from service.engine.rotor_state import on_rotor
from service.engine.selection_problem import PlanContext as MeasuredGround
from service.errors import Conflict, InvalidInput, OutOfOrder
from service.messages import Message
from service.model.arrangement import (
    Arrangement,
    ArrangementAnswer,
    ArrangementPoint,
    ArrangementRequest,
    ArrangementWhatIf,
    MountedRequest,
)
from service.model.machine import Machine
from service.model.parts import Place
from service.model.plan import Placement, PlanInputs
from service.model.run import MassOnRotor
from service.runtime.context import AppContext, require
from service.usecases.arrangements import parts, place_sets
from service.usecases.session_view import stored_drum
from service.usecases.stock import ledger
from service.version import __version__


def propose(work: AppContext, request: ArrangementRequest) -> Arrangement:
    """Arrange parts; infeasible is an answer and is stored.

    Solved between two units of work, so that nothing waits for it. Raises InvalidInput for what cannot be meant,
    NotFound, Conflict for a correction that is out of date, or Unavailable where too many are being solved.
    """
    with work.read() as store:
        ground, machine_id, session_id = _ground(store, request, work.now())
    with work.turns.turn():
        made = engine.answer(
            ground,
            request,
            key=work.new_id(),
            machine_id=machine_id,
            session_id=session_id,
            at=work.now(),
            monotonic=work.monotonic,
        )
    with work.write() as store:
        store.add(
            ArrangementRow(
                id=made.id,
                machine_id=machine_id,
                session_id=session_id,
                created_at=made.created_at,
                arrangement=made,
            )
        )
        if machine_id is not None:
            parts.weighed(store, machine_id, made)
    return made


def get(work: AppContext, arrangement_id: str) -> Arrangement:
    """One arrangement. Raises NotFound."""
    with work.read() as store:
        return require(store, ArrangementRow, arrangement_id).arrangement


def find(
    work: AppContext, limit: int, offset: int, *, machine_id: str | None = None, session_id: str | None = None
) -> tuple[Arrangement, ...]:
    """Arrangements, newest first."""
    with work.read() as store:
        rows = store.arrangements(limit, offset, machine_id=machine_id, session_id=session_id)
        return tuple(row.arrangement for row in rows)


def front(work: AppContext, arrangement_id: str) -> tuple[ArrangementPoint, ...]:
    """The best arrangement for each number of moves. Raises NotFound, or InvalidInput without a present arrangement."""
    with work.read() as store:
        made = require(store, ArrangementRow, arrangement_id).arrangement
        ground, _, _ = _ground(store, made.request, work.now(), made.places)
    with work.turns.turn():
        return engine.front(ground, made.request, work.monotonic)


def what_if(work: AppContext, arrangement_id: str, asked: ArrangementWhatIf) -> ArrangementAnswer:
    """The arrangement under other circumstances; nothing is stored. Raises NotFound or InvalidInput."""
    with work.read() as store:
        made = require(store, ArrangementRow, arrangement_id).arrangement
        ground, _, _ = _ground(store, made.request, work.now(), made.places)
    with work.turns.turn():
        return engine.what_if(ground, made, asked, work.monotonic)


def lock(work: AppContext, arrangement_id: str) -> Arrangement:
    """Report that the drum is locked, so that parts can be moved. Raises NotFound, or Conflict once it is mounted."""
    with work.write() as store:
        row = require(store, ArrangementRow, arrangement_id, lock=True)
        if row.arrangement.state == "mounted":
            raise _mounted_before(arrangement_id)
        row.arrangement = replace(row.arrangement, locked_at=work.now())
        return row.arrangement


def release(work: AppContext, arrangement_id: str) -> Arrangement:
    """Report that the drum may turn again. Raises NotFound, or Conflict where nothing was mounted."""
    with work.write() as store:
        row = require(store, ArrangementRow, arrangement_id, lock=True)
        if row.arrangement.state != "mounted":
            raise OutOfOrder(Message("arrangement_not_mounted"), field="arrangement_id", value=arrangement_id)
        row.arrangement = replace(row.arrangement, released_at=work.now())
        return row.arrangement


def mounted(work: AppContext, arrangement_id: str, request: MountedRequest) -> Arrangement:
    """State what is mounted where: parts become part of the machine's history.

    Raises NotFound, InvalidInput for a part or place that is not known, Conflict where it is stated already.
    """
    with work.write() as store:
        row = require(store, ArrangementRow, arrangement_id, lock=True)
        made = row.arrangement
        if made.state == "mounted":
            raise _mounted_before(arrangement_id)
        ground, _, _ = _ground(store, made.request, work.now(), made.places)
        really, left = engine.mounted(ground, made, request.actual)
        now = work.now()
        row.arrangement = replace(made, state="mounted", mounted=really, mounted_at=now, mounted_residual=left)
        store.flush()
        if row.machine_id is not None:
            parts.mounted(store, row.machine_id, row.arrangement, request.note, now)
        return row.arrangement


def _mounted_before(arrangement_id: str) -> Conflict:
    return Conflict(Message("arrangement_mounted"), field="arrangement_id", value=arrangement_id)


def _ground(
    store: Store, request: ArrangementRequest, now: datetime, places: tuple[Place, ...] | None = None
) -> tuple[engine.ArrangementContext, str | None, str | None]:
    """What a request is answered on, with the machine and the session that it belongs to."""
    correction = None if request.correction_id is None else require(store, CorrectionRow, request.correction_id)
    session_id = request.session_id or (None if correction is None else correction.session_id)
    session = None if session_id is None else require(store, SessionRow, session_id)
    if correction is not None and session is not None and correction.session_id != session.id:
        raise Conflict(Message("correction_of_other_session.for_parts"), field="correction_id", value=correction.id)
    machine, machine_id = _machine(store, request, session)
    measured = None
    if correction is not None and session is not None:
        measured = _measured(store, session, correction)
    if places is None:
        places = _places(store, request, machine_id)
    box = _box(store, request, session, now)
    return engine.ArrangementContext(places, machine, measured, box), machine_id, session_id


def _machine(
    store: Store, request: ArrangementRequest, session: SessionRow | None
) -> tuple[Machine | None, str | None]:
    if session is not None:
        if request.machine_id not in (None, session.machine_id):
            raise Conflict(Message("session_of_other_machine.arranging"), field="machine_id", value=request.machine_id)
        return session.machine, session.machine_id
    if request.machine_id is None:
        return None, None
    return require(store, MachineRow, request.machine_id).spec, request.machine_id


def _places(store: Store, request: ArrangementRequest, machine_id: str | None) -> tuple[Place, ...]:
    if (request.places is None) == (request.set is None):
        raise InvalidInput(
            Message("places_missing" if request.places is None else "places_and_set"), field="places", value=request.set
        )
    if request.places is not None:
        return request.places
    if machine_id is None:
        raise InvalidInput(Message("machine_missing.for_set"), field="machine_id", value=None)
    return place_sets.named(store, machine_id, request.set or "").places


def _measured(store: Store, session: SessionRow, row: CorrectionRow) -> MeasuredGround:
    if row.correction.stale:
        raise Conflict(Message("correction_stale"), field="correction_id", value=row.id)
    return MeasuredGround(
        machine=session.machine,
        items=(),
        runs=tuple(one.run for one in store.runs(session.id)),
        run_out=session.run_out,
        correction=row.correction,
        as_found=session.on_rotor,
        inputs=PlanInputs(counts=(), present=(), version=__version__, on_rotor=_stays_on(store, session)),
    )


def _stays_on(store: Store, session: SessionRow) -> tuple[MassOnRotor, ...]:
    """Masses on the rotor now but for trial masses, which come off before parts are mounted."""
    drum = stored_drum(store, session)
    if drum.fitted is None and drum.good and drum.good[-1].kind in ("initial", "trial"):
        return ()
    return on_rotor(drum)


def _box(store: Store, request: ArrangementRequest, session: SessionRow | None, now: datetime) -> engine.Box | None:
    key = request.catalogue_id or (None if session is None else session.catalogue_id)
    if request.use == "parts" or key is None:
        return None
    row = require(store, CatalogueRow, key)
    present: tuple[Placement, ...] = ()
    if session is not None and session.fitted_plan_id is not None:
        present = require(store, PlanRow, session.fitted_plan_id).plan.fitted or ()
    counts = ledger.available(store, row, now, "" if session is None else session.id)
    return engine.Box(row.items, counts, present)
