"""A request for an arrangement to its answer, its front, and what it would be under other circumstances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from service.balancing.arrangement import (
    EMPTY,
    ArrangementResult,
    new_parts,
    objective_deviation,
    search_front,
    solve_best,
    solve_fewest,
    values,
    wanted_mass,
)
from service.balancing.rotor.phasors import IntArray
from service.engine.arrangement import answers, messages
from service.engine.arrangement import request_checks as checks
from service.engine.arrangement.frame import frame_of
from service.engine.arrangement.parts import Posed, pose
from service.engine.arrangement.with_box import Box, with_box
from service.engine.correction_solver import predicted_with
from service.engine.selection_problem import PlanContext
from service.errors import InvalidInput, OutOfOrder
from service.messages import Message, render
from service.model.arrangement import (
    Arrangement,
    ArrangementAnswer,
    ArrangementOffer,
    ArrangementPoint,
    ArrangementRequest,
    ArrangementWhatIf,
    Mounted,
    PartToArrange,
    PlaneResidual,
    Replacement,
)
from service.model.correction import SensorVector
from service.model.machine import Machine
from service.model.message import message_data
from service.model.parts import Place

UNIT = {"unbalance": "g.mm", "residual_vibration": "1", "bearing_force": "1"}
Monotonic = Callable[[], float]


@dataclass(frozen=True)
class ArrangementContext:
    """What a request is answered on: its places, and machine, correction with its runs and box where it has them."""

    places: tuple[Place, ...]
    machine: Machine | None = None
    measured: PlanContext | None = None
    box: Box | None = None


def answer(
    ground: ArrangementContext,
    request: ArrangementRequest,
    *,
    key: str,
    machine_id: str | None,
    session_id: str | None,
    at: datetime,
    monotonic: Monotonic,
) -> Arrangement:
    """Arrange the parts. An infeasible problem is an answer; a request that cannot be meant raises InvalidInput.

    Deterministic but for `seconds`, as long as the time limit is not reached.
    """
    begun = monotonic()
    posed = _posed(ground, request)
    offer, evaluations = _solved(posed, ground, monotonic)
    rule, no_rule = answers.makers_rule(posed)
    return Arrangement(
        id=key,
        machine_id=machine_id,
        session_id=session_id,
        request=request,
        places=ground.places,
        **vars(offer),
        objective_unit=UNIT[request.objective],
        makers_rule=rule,
        makers_rule_reason=None if no_rule is None else render(no_rule),
        makers_rule_reason_data=message_data(no_rule),
        objective_now=_objective_now(posed),
        evaluations=evaluations,
        seconds=monotonic() - begun,
        seed=request.seed,
        created_at=at,
    )


def front(
    ground: ArrangementContext, request: ArrangementRequest, monotonic: Monotonic
) -> tuple[ArrangementPoint, ...]:
    """The best arrangement for each number of moves, as far as one more makes it better. Raises InvalidInput."""
    if all(part.present is None for part in request.parts):
        raise InvalidInput(Message("present_missing.moves"), field="parts", value=None)
    posed = _posed(ground, replace(request, max_moves=None, mode="best", limit=None))
    begun = monotonic()
    found = {}
    for found in search_front(posed.problem, np.random.default_rng(request.seed)):  # noqa: B007
        if monotonic() - begun >= request.time_limit_s:
            break
    points = []
    for moved, state in found.items():
        if state.arrangement is None:
            continue
        status = "optimal" if state.proved else "limit_reached"
        result = ArrangementResult(
            status=status,  # type: ignore[arg-type]
            arrangement=state.arrangement,
            value=state.value,
            lower_bound=state.lower_bound,
            residual=posed.problem.objective.offset,
            moves=moved,
            evaluations=state.evaluations,
            scatter=_deviation(posed)(state.arrangement),
        )
        points.append(ArrangementPoint(moves=moved, offer=_offer(posed, result)))
    return tuple(points)


def what_if(
    ground: ArrangementContext, as_it_is: Arrangement, asked: ArrangementWhatIf, monotonic: Monotonic
) -> ArrangementAnswer:
    """The arrangement under other circumstances. Raises InvalidInput for a part or place that is not known."""
    request = _changed(as_it_is.request, asked)
    posed = _posed(ground, request)
    offer, _ = _solved(posed, ground, monotonic)
    before, after = as_it_is.objective_value, offer.objective_value
    return ArrangementAnswer(
        offer=offer,
        objective_value=before,
        objective_unit=as_it_is.objective_unit,
        worse_by=None if before is None or after is None else after - before,
        replacement=None if asked.replace is None else _replacement(posed, asked.replace),
    )


def mounted(
    ground: ArrangementContext, arrangement: Arrangement, actual: tuple[Mounted, ...] | None
) -> tuple[tuple[Mounted, ...], tuple[PlaneResidual, ...]]:
    """What is really mounted, and what that leaves.

    Raises InvalidInput, or OutOfOrder where there is nothing to mount.
    """
    if not arrangement.arrangement and actual is None:
        raise OutOfOrder(Message("nothing_to_mount"), field="arrangement_id", value=arrangement.id)
    posed = _posed(ground, arrangement.request)
    known = {part.id: k for k, part in enumerate(posed.request.parts)}
    whole = {one.place: one.part for one in arrangement.arrangement} or {p.label: None for p in posed.places}
    for index, one in enumerate(actual or ()):
        if one.place not in whole:
            raise _no_place(one.place, f"actual[{index}].place")
        if one.part is not None and one.part not in known:
            raise _no_part(one.part, f"actual[{index}].part")
        whole[one.place] = one.part
    held = [part for part in whole.values() if part is not None]
    twice = next((part for part in held if held.count(part) > 1), None)
    if twice is not None:
        raise InvalidInput(Message("part_in_two_places.mounted", part=twice), field="actual", value=twice)
    row = np.array([EMPTY if whole[p.label] is None else known[str(whole[p.label])] for p in posed.places])
    return answers.mounted(posed, row), answers.residual(posed, row)


def _posed(ground: ArrangementContext, request: ArrangementRequest) -> Posed:
    checks.check(request, ground.places)
    return pose(request, ground.places, frame_of(request, ground.machine, ground.measured))


def _solved(posed: Posed, ground: ArrangementContext, monotonic: Monotonic) -> tuple[ArrangementOffer, int]:
    begun = monotonic()

    def stop() -> bool:
        return monotonic() - begun >= posed.request.time_limit_s

    if posed.request.use != "parts":
        return with_box(posed, ground.box, _deviation(posed), stop, _offer)
    if posed.request.mode == "fewest_moves":
        limit = posed.request.limit or 0.0
        result = solve_fewest(posed.problem, limit, posed.request.seed, deviation=_deviation(posed), stop=stop)
    else:
        result = solve_best(posed.problem, posed.request.seed, deviation=_deviation(posed), stop=stop)
    return _offer(posed, result), result.evaluations


def _deviation(posed: Posed) -> Callable[[IntArray], float]:
    """Standard deviation of the objective from the scale."""
    if posed.request.scale_resolution_g is None:
        return lambda _arrangement: 0.0
    matrix = posed.objective.matrix
    real = np.empty((2 * matrix.shape[0], 2 * matrix.shape[1]))
    real[0::2, 0::2], real[0::2, 1::2] = matrix.real, -matrix.imag
    real[1::2, 0::2], real[1::2, 1::2] = matrix.imag, matrix.real
    return lambda arrangement: objective_deviation(posed.objective, real @ posed.scale_covariance(arrangement) @ real.T)


def _offer(posed: Posed, result: ArrangementResult) -> ArrangementOffer:
    row = result.arrangement
    said = messages.status_message(result)
    details = dict(result.details or {})
    if "place" in details:
        details["place"] = posed.places[int(float(details["place"]))].label
    if row is None:
        reason = messages.reason_message(result.code, details)
        return ArrangementOffer(
            status=result.status,
            message=render(said),
            message_data=message_data(said),
            code=result.code or None,
            reason=render(reason),
            reason_data=message_data(reason),
            arrangement=(),
            moves=(),
            moves_count=0,
            new_parts_count=0,
            moves_bound=None,
            objective_value=None,
            lower_bound=result.lower_bound if result.status != "infeasible" else None,
            gap=None,
            objective_scatter=None,
            residual=(),
        )
    return ArrangementOffer(
        status=result.status,
        message=render(said),
        message_data=message_data(said),
        code=result.code or None,
        reason=None,
        arrangement=answers.mounted(posed, row),
        moves=answers.moves_in_order(posed, row) if (posed.problem.present != EMPTY).any() else (),
        moves_count=result.moves,
        new_parts_count=int(new_parts(posed.problem, row[None, :])[0]),
        moves_bound=result.moves_bound,
        objective_value=result.value,
        lower_bound=result.lower_bound,
        gap=result.gap,
        objective_scatter=result.scatter or None,
        residual=answers.residual(posed, row),
        predicted=_predicted(posed, row),
    )


def _predicted(posed: Posed, row: IntArray) -> tuple[SensorVector, ...]:
    """Vibration to expect where the drum was measured; empty else."""
    measured, machine = posed.frame.measured, posed.frame.machine
    if machine is None or measured is None or measured.fitted is None or posed.request.offset != "measured":
        return ()
    names = [plane.name for plane in machine.planes]
    masses = measured.on_rotor.astype(np.complex128)
    changed = posed.unbalance(row) - measured.unbalance @ posed.frame.to_frame
    for name, one in zip(posed.frame.planes, changed, strict=True):
        p = names.index(name)
        masses[p] += one / machine.planes[p].radius_mm
    return predicted_with(machine, measured.fitted, masses)


def _objective_now(posed: Posed) -> float | None:
    present = posed.problem.present
    if any(present[p] == EMPTY and not place.may_be_empty for p, place in enumerate(posed.places)):
        return None
    return float(values(posed.problem, present[None, :])[0])


def _changed(request: ArrangementRequest, asked: ArrangementWhatIf) -> ArrangementRequest:
    known = {part.id for part in request.parts}
    for field, names in (("missing", asked.missing), ("stay", asked.stay)):
        for index, name in enumerate(names):
            if name not in known:
                raise _no_part(name, f"{field}[{index}]")
    relative = request.offset in ("measured", "in_balance_with_old")
    parts: list[PartToArrange] = []
    for part in request.parts:
        if part.id in asked.missing:
            if part.present is not None and relative:
                parts.append(replace(part, may="gone"))
        elif part.id in asked.stay and part.present is not None:
            parts.append(replace(part, may="stay"))
        else:
            parts.append(part)
    moves = request.max_moves if asked.max_moves is None else asked.max_moves
    return replace(request, parts=(*parts, *asked.shelf), max_moves=moves)


def _replacement(posed: Posed, label: str) -> Replacement:
    labels = [place.label for place in posed.places]
    if label not in labels:
        raise _no_place(label, "replace")
    place = labels.index(label)
    problem = posed.problem
    row = problem.present.copy()
    row[place] = EMPTY
    alone = replace(problem, groups=(), sets=(), max_moves=None, max_new=None)
    gain = posed.gains[place].mean(axis=0) @ posed.objective.matrix.T
    mass, value = wanted_mass(alone, row, gain)
    mounted_now = set(row.tolist())
    shelf = [k for k in range(problem.parts) if k not in mounted_now and problem.allowed[k, place]]
    rated = []
    for k in shelf:
        row[place] = k
        rated.append((float(values(alone, row[None, :])[0]), k))
    best = min(rated, default=None)
    return Replacement(
        place=label,
        mass_g=mass,
        objective_value=value,
        best_on_shelf=None if best is None else posed.request.parts[best[1]].id,
        shelf_objective_value=None if best is None else best[0],
    )


def _no_part(name: str, field: str) -> InvalidInput:
    return InvalidInput(Message("unknown_part", part=name), field=field, value=name)


def _no_place(label: str, field: str) -> InvalidInput:
    return InvalidInput(Message("unknown_place", place=label), field=field, value=label)
