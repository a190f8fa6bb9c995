"""Plans: proposed, fitted from stock, taken off again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from db.rows import CatalogueRow, CorrectionRow, PlanRow, SessionRow
from db.store import Store
from service.engine import alternatives, session_state
from service.engine.plan_solver import refitted, solve_plan
from service.engine.rotor_state import in_order, on_rotor
from service.engine.selection_problem import PlanContext
from service.engine.validation import hole_label, item_of, plane_index, position_index
from service.errors import Conflict, InvalidInput, OutOfOrder
from service.messages import Message, Word
from service.model.machine import CatalogueItem, Machine
from service.model.plan import (
    ActualPlacement,
    FittedRequest,
    FrontPoint,
    Placement,
    Plan,
    PlanInputs,
    PlanRequest,
    WhatIf,
    WhatIfRequest,
)
from service.runtime.context import AppContext, require
from service.usecases.optimistic_lock import require_seen
from service.usecases.plans.reservations import let_go, locked, other_box, require_its_box, require_placements
from service.usecases.session_view import stored_drum, updated_plan
from service.usecases.stock import ledger
from service.version import __version__


def propose(work: AppContext, session_id: str, request: PlanRequest) -> Plan:
    """Choose stock masses and positions for a correction; infeasible is an answer.

    The selection is solved between two units of work, so that no one waits for it. Raises InvalidInput, NotFound,
    OutOfOrder, Conflict for a correction that is out of date, or Unavailable where too many are being solved.
    """
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        require_seen(work, store, session)
        session_state.after(session, "plan")
        ground = _ground(store, session, request.correction_id, request.base == "present", work.now())
        if ground.correction.stale:
            raise Conflict(Message("correction_stale"), field="correction_id", value=request.correction_id)
    with work.turns.turn():
        plan = solve_plan(
            ground,
            request,
            number=0,
            key=work.new_id(),
            session_id=session_id,
            at=work.now(),
            monotonic=work.attended,
        )
        work.attended()
    work.meters.solved(request.method, plan.status, plan.seconds)
    with work.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        require_seen(work, store, session)
        state = session_state.after(session, "plan")
        now_stale = require(store, CorrectionRow, request.correction_id).correction.stale
        plan = replace(plan, number=store.next_number(PlanRow, session_id), stale=now_stale)
        store.add(PlanRow(id=plan.id, session_id=session_id, number=plan.number, plan=plan))
        session.state = state
        return plan


def get(work: AppContext, plan_id: str) -> Plan:
    """One plan. Raises NotFound."""
    with work.read() as store:
        return updated_plan(store, require(store, PlanRow, plan_id))


def front(work: AppContext, plan_id: str) -> tuple[FrontPoint, ...]:
    """The best selection for each number of masses, from the box that the plan was made from, as it was then.

    As far as one more mass makes it better. Raises NotFound, or Conflict where that box is not known.
    """
    plan, ground, its_box = _solved(work, plan_id)
    with work.turns.turn():
        return alternatives.front_of(ground, plan.request, its_box, work.attended)


def what_if(work: AppContext, plan_id: str, request: WhatIfRequest) -> WhatIf:
    """The plan under other circumstances, the box as in `front`; nothing is stored.

    Raises NotFound, InvalidInput, or Conflict as `front`.
    """
    plan, ground, its_box = _solved(work, plan_id)
    with work.turns.turn():
        return alternatives.what_if(ground, plan, request, its_box, work.attended)


def expected(work: AppContext, plan_id: str, selections: Sequence[tuple[Placement, ...]]) -> tuple[Plan, ...]:
    """The plan with what is to be expected of each of these selections, such as its alternatives; nothing is stored.

    Raises NotFound, or OutOfOrder and Conflict where its box or its correction is not there any more.
    """
    with work.read() as store:
        plan = require(store, PlanRow, plan_id).plan
        session = require(store, SessionRow, plan.session_id)
        ground = _ground(store, session, plan.correction_id, False, work.now())
    return tuple(refitted(ground, plan, placements) for placements in selections)


def fitted(work: AppContext, plan_id: str, request: FittedRequest) -> Plan:
    """Take the masses from stock, all or none; pieces of the plan fitted before go back or stay.

    Raises Conflict where the box holds too few or is not the plan's, OutOfOrder for a plan that cannot be fitted,
    InvalidInput for a piece at an angle that is no position or a mass that is not in the box.
    """
    with work.write() as store:
        row, session, box = locked(store, plan_id)
        require_seen(work, store, row)
        state = session_state.after(session, "fitted")
        _require_fittable(row.plan, request)
        if request.actual is None:
            require_its_box(row.plan, session)
        ground = _ground(store, session, row.plan.correction_id, False, work.now())
        actual = row.plan.placements
        if request.actual is not None:
            moved = tuple(piece for piece in actual if not piece.from_box)
            actual = in_order(ground.machine, (*moved, *_actual(ground.machine, ground.items, request.actual)))
        before = None if session.fitted_plan_id is None else require(store, PlanRow, session.fitted_plan_id)
        back = () if before is None else before.plan.fitted or ()
        now = work.now()
        let_go(store, session.id, now)
        net = ledger.net_of(box.items, back=back, out=actual)
        ledger.exchange(store, box, net, at=now, session_id=session.id, plan_id=row.id)
        if before is not None:
            before.plan = replace(before.plan, state="replaced")
        row.plan = replace(
            refitted(ground, row.plan, actual), state="fitted", changed_after_run=len(ground.runs), changed_at=now
        )
        session.fitted_plan_id, session.state = row.id, state
        store.flush()
        return row.plan


def unfit(work: AppContext, plan_id: str) -> Plan:
    """Return the masses of the fitted plan to stock: the rotor is as found again.

    Raises OutOfOrder where the plan is not the one that is fitted.
    """
    with work.write() as store:
        row, session, box = locked(store, plan_id)
        require_seen(work, store, row)
        state = session_state.after(session, "unfit")
        if session.fitted_plan_id != row.id:
            raise OutOfOrder(
                Message("out_of_order.plan_not_fitted", number=row.plan.number, state=Word(row.plan.state)),
                field="plan_id",
                value=plan_id,
            )
        net = ledger.net_of(box.items, back=row.plan.fitted or (), out=())
        now = work.now()
        ledger.exchange(store, box, net, at=now, session_id=session.id, plan_id=row.id)
        row.plan = replace(
            row.plan, state="unfitted", fitted=None, changed_after_run=len(store.runs(session.id)), changed_at=now
        )
        session.fitted_plan_id, session.state = None, state
        store.flush()
        return row.plan


def _ground(store: Store, session: SessionRow, correction_id: str, keep: bool, now: datetime) -> PlanContext:
    """What a plan of this session is made on; pieces held for other sessions are not there for it."""
    if session.catalogue_id is None:
        raise OutOfOrder(Message("catalogue_missing"), field="catalogue_id", value=None)
    correction = require(store, CorrectionRow, correction_id)
    if correction.session_id != session.id:
        raise Conflict(
            Message("correction_of_other_session", correction=correction_id), field="correction_id", value=correction_id
        )
    box = require(store, CatalogueRow, session.catalogue_id)
    present: tuple[Placement, ...] = ()
    off: tuple[Placement, ...] = ()
    if session.fitted_plan_id is not None:
        fitted_plan = require(store, PlanRow, session.fitted_plan_id).plan
        present, off = fitted_plan.fitted or (), fitted_plan.taken_off
    counts = ledger.available(store, box, now, session.id)
    if not keep:
        # Pieces of the fitted plan may all come off, so they count as on hand.
        fitted_now = ledger.pieces_of(box.items, present)
        counts = tuple(None if n is None else n + fitted_now[i] for i, n in enumerate(counts))
    mounted = on_rotor(stored_drum(store, session))
    inputs = PlanInputs(
        counts=counts, present=present, present_off=off, version=__version__, catalogue_id=box.id, on_rotor=mounted
    )
    return _made_on(store, session, correction, box.items, inputs)


def _made_on(
    store: Store,
    session: SessionRow,
    correction: CorrectionRow,
    items: tuple[CatalogueItem, ...],
    inputs: PlanInputs,
) -> PlanContext:
    return PlanContext(
        machine=session.machine,
        items=items,
        runs=tuple(row.run for row in store.runs(session.id)),
        run_out=session.run_out,
        correction=correction.correction,
        as_found=session.on_rotor,
        inputs=inputs,
    )


def _solved(work: AppContext, plan_id: str) -> tuple[Plan, PlanContext, str | None]:
    """A plan, what it was made on, its box as it was then, and that box's name where the session has another one now.

    Questions about a plan are of its own box: what it came to can be compared with nothing else. Raises NotFound, or
    Conflict for a plan of before boxes were stored with it, if the session's has not as many kinds of mass.
    """
    with work.read() as store:
        plan = require(store, PlanRow, plan_id).plan
        session = require(store, SessionRow, plan.session_id)
        inputs = plan.inputs
        box = require(store, CatalogueRow, inputs.catalogue_id or session.catalogue_id or "")
        if len(box.items) < len(inputs.counts):
            raise other_box(plan, session)
        items = box.items[: len(inputs.counts)]
        ground = _made_on(store, session, require(store, CorrectionRow, plan.correction_id), items, inputs)
        return plan, ground, box.name if box.id != session.catalogue_id else None


def _require_fittable(plan: Plan, request: FittedRequest) -> None:
    if request.actual is None:
        require_placements(plan)
    if plan.state not in ("proposed", "unfitted", "replaced"):
        raise OutOfOrder(
            Message("plan_fitted.state", number=plan.number, state=Word(plan.state)), field="plan_id", value=plan.id
        )
    if plan.stale and not request.accept_stale:
        raise Conflict(Message("plan_stale.fitting", number=plan.number), field="plan_id", value=plan.id)


def _actual(
    machine: Machine, items: tuple[CatalogueItem, ...], actual: tuple[ActualPlacement, ...]
) -> tuple[Placement, ...]:
    out: list[Placement] = []
    room: Counter[tuple[int, int]] = Counter()
    for index, piece in enumerate(actual):
        where = f"actual[{index}]"
        p = plane_index(machine, piece.plane, f"{where}.plane")
        plane = machine.planes[p]
        position = position_index(plane, piece.position_deg, f"{where}.position_deg")
        item = items[item_of(items, piece.mass_g, f"{where}.mass_g")]
        room[p, position] += 1
        if room[p, position] > plane.masses_per_position:
            raise InvalidInput(
                Message(
                    "hole_full", hole=hole_label(plane, position), plane=plane.name, most=plane.masses_per_position
                ),
                field=f"{where}.position_deg",
                value=piece.position_deg,
            )
        out.append(
            Placement(
                plane=plane.name,
                position_deg=plane.positions_deg[position],
                hole=hole_label(plane, position),
                mass_g=item.mass_g,
                fastener_g=item.fastener_g,
                weighed_g=piece.weighed_g,
            )
        )
    return tuple(out)
