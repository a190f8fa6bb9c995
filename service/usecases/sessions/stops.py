"""Stops to change masses, safe first: locked before a mass is touched, released before the drum turns again.

Each step is stored when it is stated, so that every tablet at the machine shows what state
it is in. What is on the rotor is known from the moment it is stated, not only from the next run.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from db.rows import PlanRow, SessionRow, StopRow
from db.store import Store
from service.balancing.influence.trial_mass import centrifugal_force
from service.engine import mapping, session_state
from service.engine.session_state import under_way
from service.engine.trial_check import require_bearable
from service.engine.validation import POSITION_TOLERANCE_DEG, check_masses, plane_index
from service.errors import InvalidInput, NotFound, OutOfOrder
from service.messages import Message, Quantity
from service.model.machine import Machine
from service.model.plan import ActualPlacement, FittedRequest, Placement
from service.model.run import MassOnRotor
from service.model.stop import Stop, StopRequest
from service.runtime.context import AppContext, require
from service.usecases.plans import plans


def of(work: AppContext, session_id: str) -> tuple[Stop, ...]:
    """The stops of a session, in order. Raises NotFound."""
    with work.read() as store:
        require(store, SessionRow, session_id)
        return tuple(row.stop for row in store.stops(session_id))


def begin(work: AppContext, session_id: str, request: StopRequest) -> Stop:
    """Begin a stop; one that is under way is given up, unless masses were changed in it already.

    Raises NotFound, InvalidInput, OutOfOrder for a closed session or a stop that has to be finished first.
    """
    with work.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        session_state.after(session, "run")
        rows = store.stops(session_id)
        before = under_way([row.stop for row in rows])
        if before is not None:
            if before.changed_at is not None:
                raise OutOfOrder(
                    Message("stop_unfinished.not_released", number=before.number),
                    field="purpose",
                    value=request.purpose,
                )
            rows[-1].stop = replace(before, cancelled=True)
        stop = Stop(
            id=work.new_id(),
            number=store.next_number(StopRow, session_id),
            purpose=request.purpose,
            plane=request.plane,
            plan_id=request.plan_id,
            placements=_placements(store, session, request),
            runs_before=len(store.runs(session_id)),
            begun_at=work.now(),
        )
        store.add(StopRow(id=stop.id, session_id=session_id, number=stop.number, stop=stop))
        return stop


def lock(work: AppContext, session_id: str, number: int) -> Stop:
    """State that the drum stands still: key out, drum blocked. Raises NotFound, OutOfOrder."""
    return _step(work, session_id, number, lambda stop, _: replace(stop, locked_at=stop.locked_at or work.now()))


def change(work: AppContext, session_id: str, number: int, masses: Sequence[MassOnRotor]) -> Stop:
    """State ALL masses that are on the rotor now.

    Raises NotFound, OutOfOrder before the machine is locked, InvalidInput where a hole would be pulled too hard.
    """

    def stated(stop: Stop, machine: Machine) -> Stop:
        check_masses(machine, masses)
        check_forces(machine, masses)
        if stop.purpose == "trial":
            require_bearable(machine, masses)
        return _changed(work, stop, masses)

    return _step(work, session_id, number, stated)


def fit(work: AppContext, session_id: str, number: int, actual: tuple[ActualPlacement, ...] | None) -> Stop:
    """State the masses of the stop's plan bolted on: they leave the stock, and are on the rotor from now on.

    actual: what was really fitted, where it differs. Raises as `plans.fitted` and `change`; repeated, it does nothing.
    """
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        stop = _row(store, session_id, number).stop
        _require_locked(stop)
        machine, fitted_id = session.machine, session.fitted_plan_id
    if actual is None and not stop.placements:
        raise InvalidInput(Message("invalid_input.stop_without_plan"), field="plan_id")
    wanted = actual if actual is not None else _as_actual(stop.placements)
    fasteners = {piece.mass_g: piece.fastener_g for piece in stop.placements}
    check_forces(machine, [_as_mass(piece, fasteners.get(piece.mass_g, 0.0)) for piece in wanted])
    key = stop.plan_id or ""
    if fitted_id == key and stop.changed_at is None:
        # The masses were stated before, and the answer was lost on its way.
        plan = plans.get(work, key)
    else:
        plan = plans.fitted(work, key, FittedRequest(actual=wanted, accept_stale=True))
    masses = mapping.masses_on_rotor(plan)
    return _step(work, session_id, number, lambda stop, _: _changed(work, stop, masses))


def bare(work: AppContext, session_id: str, number: int) -> Stop:
    """State that everything is off again: the masses of a fitted plan are back in the box, the drum is as found.

    Raises NotFound, OutOfOrder before the machine is locked; repeated, it does nothing.
    """
    with work.read() as store:
        _require_locked(_row(store, session_id, number).stop)
        fitted_id = require(store, SessionRow, session_id).fitted_plan_id
    if fitted_id is not None:
        plans.unfit(work, fitted_id)
    return _step(work, session_id, number, lambda stop, _: _changed(work, stop, ()))


def release(work: AppContext, session_id: str, number: int) -> Stop:
    """State that bolts are torqued, tools out and guards on. Raises NotFound, OutOfOrder before masses are stated."""

    def released(stop: Stop, _machine: Machine) -> Stop:
        if stop.masses is None:
            raise OutOfOrder(Message("masses_not_stated"), field="masses", value=None)
        return replace(stop, released_at=stop.released_at or work.now())

    return _step(work, session_id, number, released)


def reopen(work: AppContext, session_id: str, number: int) -> Stop:
    """Take back what was stated of the masses, as long as the drum has not turned with them in a stored run.

    The masses of a plan go back into the box; a machine that was released is to be locked again. Raises NotFound,
    OutOfOrder for a stop that is not the latest, in which nothing was stated, or after which a run was taken.
    """
    with work.read() as store:
        stop = _row(store, session_id, number).stop
        latest, runs = store.stops(session_id)[-1].number, len(store.runs(session_id))
        fitted_id = require(store, SessionRow, session_id).fitted_plan_id
    if stop.masses is None or number != latest or (stop.changed_after_run or 0) < runs:
        raise OutOfOrder(Message("stop_not_correctable", number=number), field="number", value=number)
    if stop.purpose == "plan" and fitted_id == stop.plan_id and fitted_id is not None:
        plans.unfit(work, fitted_id)

    def taken_back(stop: Stop, _machine: Machine) -> Stop:
        locked = stop.locked_at if stop.released_at is None else None
        return replace(stop, masses=None, changed_at=None, changed_after_run=None, released_at=None, locked_at=locked)

    return _step(work, session_id, number, taken_back)


def cancel(work: AppContext, session_id: str, number: int) -> Stop:
    """Give a stop up before anything was changed. Raises NotFound, OutOfOrder."""

    def given_up(stop: Stop, _machine: Machine) -> Stop:
        if stop.changed_at is not None:
            raise OutOfOrder(Message("stop_unfinished", number=stop.number), field="number", value=stop.number)
        return replace(stop, cancelled=True)

    return _step(work, session_id, number, given_up)


def check_forces(machine: Machine, masses: Iterable[MassOnRotor]) -> None:
    """No hole is pulled harder at service speed than it may be. Raises InvalidInput."""
    holes: defaultdict[tuple[int, int], float] = defaultdict(float)
    steps = round(360.0 / POSITION_TOLERANCE_DEG)
    for mass in masses:
        p = plane_index(machine, mass.plane, "masses.plane")
        holes[p, round(mass.angle_deg % 360.0 / POSITION_TOLERANCE_DEG) % steps] += mass.mass_g
    for (p, _), grams in holes.items():
        plane = machine.planes[p]
        force = centrifugal_force(grams, plane.radius_mm, machine.service_speed_rpm)
        if plane.max_force_n is not None and force > plane.max_force_n * (1.0 + 1e-9):
            most = math.floor(10.0 * grams * plane.max_force_n / force) / 10.0
            raise InvalidInput(
                Message(
                    "force_too_great",
                    mass=Quantity(grams, "g"),
                    plane=plane.name,
                    force=Quantity(force, "N"),
                    limit=Quantity(plane.max_force_n, "N"),
                    most=Quantity(most, "g"),
                ),
                field="masses.mass_g",
                value=grams,
            )


def _step(work: AppContext, session_id: str, number: int, stepped: Callable[[Stop, Machine], Stop]) -> Stop:
    with work.write() as store:
        session = require(store, SessionRow, session_id, lock=True)
        session_state.after(session, "run")
        row = _row(store, session_id, number)
        if row.stop.cancelled:
            raise OutOfOrder(Message("stop_cancelled", number=number), field="number", value=number)
        stop = stepped(row.stop, session.machine)
        if stop.changed_at not in (None, row.stop.changed_at):
            stop = replace(stop, changed_after_run=len(store.runs(session_id)))
        row.stop = stop
        return stop


def _changed(work: AppContext, stop: Stop, masses: Sequence[MassOnRotor]) -> Stop:
    _require_locked(stop)
    return replace(stop, masses=tuple(masses), changed_at=work.now())


def _row(store: Store, session_id: str, number: int) -> StopRow:
    for row in store.stops(session_id):
        if row.number == number:
            return row
    raise NotFound(Message("not_found.stop", session=session_id, number=number), field="number", value=number)


def _require_locked(stop: Stop) -> None:
    if stop.locked_at is None:
        raise OutOfOrder(Message("not_locked"), field="number", value=stop.number)


def _placements(store: Store, session: SessionRow, request: StopRequest) -> tuple[Placement, ...]:
    if request.purpose == "trial":
        plane_index(session.machine, request.plane or "", "plane")
    if request.purpose != "plan":
        return ()
    row = require(store, PlanRow, request.plan_id or "")
    offers = row.plan.alternatives
    if row.session_id != session.id or not (request.alternative is None or 0 <= request.alternative < len(offers)):
        raise InvalidInput(Message("invalid_input.plan_of_stop"), field="plan_id", value=request.plan_id)
    return row.plan.placements if request.alternative is None else offers[request.alternative].placements


def _as_actual(placements: Iterable[Placement]) -> tuple[ActualPlacement, ...]:
    """Pieces from the box, as they are stated fitted; as-found pieces are not stated."""
    return tuple(
        ActualPlacement(plane=p.plane, position_deg=p.position_deg, mass_g=p.mass_g) for p in placements if p.from_box
    )


def _as_mass(piece: ActualPlacement, fastener_g: float) -> MassOnRotor:
    grams = (piece.weighed_g or piece.mass_g) + fastener_g
    return MassOnRotor(plane=piece.plane, mass_g=grams, angle_deg=piece.position_deg)
