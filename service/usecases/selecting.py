"""The discrete choice: from a correction and a box of stock masses to placements, without storage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from db.documents.correction import Correction
from db.documents.machine import CatalogueItem, Machine, Plane
from db.documents.plan import (
    BearingForces,
    BlockedPosition,
    Change,
    MethodResult,
    Placement,
    Plan,
    PlanInputs,
    PlanRequest,
)
from db.documents.run import Run, RunOut
from service.balancing import objectives
from service.balancing.phasors import ComplexArray, to_radians
from service.balancing.rotor import bearing_reactions
from service.balancing.selection import (
    UNLIMITED,
    Objective,
    SelectionPlane,
    SelectionProblem,
    SelectionResult,
    Stock,
)
from service.balancing.units import angular_speed
from service.errors import Conflict, InvalidInput
from service.usecases import mapping
from service.usecases.rules import hole_label, plane_index, position_index
from service.usecases.scatter import objective_scatter
from service.usecases.solvers import Solved, run_method
from service.usecases.solving import Fitted, correction_vectors, fit_runs, predicted_with

UNIT = {"components": "g.mm", "residual_vibration": "1", "bearing_force": "1"}


@dataclass(frozen=True)
class Ground:
    """All that a plan is made on; `runs` are all of the session's, the correction says which of them it used."""

    machine: Machine
    items: tuple[CatalogueItem, ...]
    runs: tuple[Run, ...]
    run_out: tuple[RunOut, ...]
    correction: Correction
    inputs: PlanInputs


def solve_plan(
    ground: Ground,
    request: PlanRequest,
    *,
    number: int,
    key: str,
    session_id: str,
    at: datetime,
    monotonic: Callable[[], float],
) -> Plan:
    """Choose stock masses and positions. An infeasible problem is an answer; a request that cannot be meant raises.

    Deterministic but for `seconds`, as long as the time limit is not reached.
    """
    machine = ground.machine
    target = correction_vectors(machine, ground.correction)
    fitted = _fit_of(ground)
    objective = _objective(machine, request, target, fitted)
    problem = selection_problem(ground, request, objective)
    uncertainty = objective_scatter(objective, request, fitted, target)
    solved = run_method(problem, request.method, request.seed, request.time_limit_s, monotonic, uncertainty)
    result = solved.result
    placements = _placements(ground, result)
    vectors = result.vectors if result.pieces is not None else None
    return Plan(
        id=key,
        number=number,
        session_id=session_id,
        correction_id=ground.correction.id,
        request=request,
        inputs=ground.inputs,
        status=result.status,
        message=result.message,
        reason=result.reason,
        placements=placements,
        changes=changes(machine, ground.inputs.on_rotor, placements) if vectors is not None else (),
        objective_value=mapping.known(result.value) if vectors is not None else None,
        objective_unit=UNIT[request.objective],
        lower_bound=_proved(result, result.lower_bound),
        gap=_proved(result, result.gap),
        objective_scatter=uncertainty or None,
        predicted=() if vectors is None else predicted_with(machine, fitted, vectors),
        bearing_forces_n=None if vectors is None else forces(machine, target, vectors),
        per_method=_per_method(solved),
        alternatives=(),
        evaluations=sum(part.result.evaluations for part in solved.parts),
        seconds=solved.seconds,
        seed=request.seed,
        created_at=at,
    )


def refitted(ground: Ground, plan: Plan, actual: tuple[Placement, ...]) -> Plan:
    """The plan with predictions for what was really fitted."""
    machine = ground.machine
    vectors = mapping.placement_vectors(machine, actual)
    target = correction_vectors(machine, ground.correction)
    return replace(
        plan,
        fitted=actual,
        predicted=predicted_with(machine, _fit_of(ground), vectors),
        bearing_forces_n=forces(machine, target, vectors),
    )


def selection_problem(ground: Ground, request: PlanRequest, objective: Objective) -> SelectionProblem:
    """The discrete problem in arrays. Raises InvalidInput for a blocked angle that is no position."""
    machine, items = ground.machine, ground.items
    blocked = _blocked(machine, request.blocked)
    planes = tuple(
        _selection_plane(machine, plane, request, blocked[p], [k for k in ground.inputs.kept if k.plane == plane.name])
        for p, plane in enumerate(machine.planes)
    )
    stock = Stock(
        masses_g=np.array([item.mass_g for item in items]),
        counts=np.array([UNLIMITED if c is None else c for c in ground.inputs.counts], dtype=np.int64),
        fasteners_g=np.array([item.fastener_g for item in items]),
    )
    return SelectionProblem(objective, planes, stock)


def changes(machine: Machine, present: Sequence[Placement], wanted: Sequence[Placement]) -> tuple[Change, ...]:
    """What to remove, keep and add to get from the pieces present to those wanted; pieces of one kind are alike."""
    left = list(present)
    kept, added = [], []
    for piece in wanted:
        match = next((p for p in left if _same_piece(machine, p, piece)), None)
        if match is None:
            added.append(Change(action="add", placement=piece))
        else:
            left.remove(match)
            kept.append(Change(action="keep", placement=match))
    removed = [Change(action="remove", placement=piece) for piece in left]
    return tuple(removed + kept + added)


def forces(machine: Machine, target: ComplexArray, vectors: ComplexArray) -> BearingForces | None:
    """Reactions at service speed before and after, the as-found unbalance taken as -t; None without the geometry."""
    bearings, places = mapping.bearing_places(machine), mapping.plane_places(machine)
    if bearings is None or places is None:
        return None
    names, at = bearings
    radius = np.array([plane.radius_mm for plane in machine.planes])
    omega = angular_speed(machine.service_speed_rpm)
    before = np.abs(bearing_reactions(-target * radius, places, at, omega))
    after = np.abs(bearing_reactions((vectors - target) * radius, places, at, omega))
    return BearingForces(bearings=names, before=tuple(before.tolist()), after=tuple(after.tolist()))


def _fit_of(ground: Ground) -> Fitted | None:
    if ground.correction.request.source != "fit":
        return None
    used = [run for run in ground.runs if run.number in ground.correction.runs]
    return fit_runs(ground.machine, used, ground.run_out)


def _objective(machine: Machine, request: PlanRequest, target: ComplexArray, fitted: Fitted | None) -> Objective:
    if request.objective != "residual_vibration":
        for name in ("norm", "weights"):
            if getattr(request, name) is not None:
                raise InvalidInput(
                    f"{name} belongs to residual_vibration, the objective is {request.objective}",
                    field=name,
                    value=name,
                    advice=f"leave {name} out",
                )
    radius = np.array([plane.radius_mm for plane in machine.planes])
    if request.objective == "components":
        return objectives.components(target, radius)
    if request.objective == "bearing_force":
        _, bearings, places = mapping.require_geometry(machine)
        return objectives.bearing_force(target, radius, places, bearings, angular_speed(machine.service_speed_rpm))
    return _residual(machine, request, fitted)


def _residual(machine: Machine, request: PlanRequest, fitted: Fitted | None) -> Objective:
    if fitted is None:
        raise Conflict(
            "a balancer's answer brings no influence coefficients to predict the vibration with",
            code="no_influence",
            field="objective",
            value="residual_vibration",
            advice="take objective components or bearing_force, or a correction of source fit",
        )
    used = np.isfinite(fitted.fit.initial)
    rows = [row for row, use in zip(fitted.rows, used, strict=True) if use]
    limits = mapping.limits(machine, rows)
    if request.weights is not None:
        if len(request.weights) != len(rows):
            raise InvalidInput(
                f"{len(request.weights)} weights for {len(rows)} predicted vectors",
                field="weights",
                value=list(request.weights),
                advice="give one weight for each entry of the correction's `predicted`, in that order",
            )
        limits = limits / np.array(request.weights)
    return objectives.residual_vibration(
        fitted.fit.influence[used], fitted.fit.initial[used], limits, request.norm or "sum"
    )


def _blocked(machine: Machine, blocked: Sequence[BlockedPosition]) -> list[set[int]]:
    out: list[set[int]] = [set() for _ in machine.planes]
    for index, stop in enumerate(blocked):
        plane = plane_index(machine, stop.plane, f"blocked[{index}].plane")
        out[plane].add(position_index(machine.planes[plane], stop.position_deg, f"blocked[{index}].position_deg"))
    return out


def _selection_plane(
    machine: Machine, plane: Plane, request: PlanRequest, blocked: set[int], kept: Sequence[Placement]
) -> SelectionPlane:
    positions = len(plane.positions_deg)
    capacity = np.full(positions, plane.masses_per_position, dtype=np.int64)
    grams = np.full(positions, np.inf)
    if plane.max_force_n is not None:
        omega = angular_speed(machine.service_speed_rpm)
        grams[:] = plane.max_force_n / (plane.radius_mm * 1e-3 * omega**2) * 1e3
    vector = mapping.placement_vectors(machine, kept)[machine.planes.index(plane)]
    heavy = 0.0
    for piece, mass in zip(kept, mapping.as_masses(kept), strict=True):
        position = position_index(plane, piece.position_deg, "kept")
        capacity[position] -= 1
        grams[position] -= mass.mass_g
        heavy += mass.mass_g
    capacity[list(blocked)] = 0
    most = min(plane.max_masses, request.max_masses_per_plane or plane.max_masses)
    return SelectionPlane(
        angles=np.array([to_radians(angle, machine.angle_sense) for angle in plane.positions_deg]),
        capacity=np.maximum(capacity, 0),
        capacity_g=np.maximum(grams, 0.0),
        max_pieces=max(most - len(kept), 0),
        max_mass_g=np.inf if plane.max_total_mass_g is None else max(plane.max_total_mass_g - heavy, 0.0),
        fixed=complex(vector),
    )


def _placements(ground: Ground, result: SelectionResult) -> tuple[Placement, ...]:
    if result.pieces is None:
        return ()
    chosen = [
        _placement(plane, piece.position, ground.items[piece.item])
        for plane, pieces in zip(ground.machine.planes, result.pieces, strict=True)
        for piece in pieces
    ]
    return in_order(ground.machine, (*ground.inputs.kept, *chosen))


def in_order(machine: Machine, placements: Sequence[Placement]) -> tuple[Placement, ...]:
    """Placements as the technician walks round the drum: by plane, position, mass."""
    names = [plane.name for plane in machine.planes]
    return tuple(sorted(placements, key=lambda p: (names.index(p.plane), p.position_deg, p.mass_g)))


def _placement(plane: Plane, position: int, item: CatalogueItem) -> Placement:
    return Placement(
        plane=plane.name,
        position_deg=plane.positions_deg[position],
        hole=hole_label(plane, position),
        mass_g=item.mass_g,
        fastener_g=item.fastener_g,
    )


def _same_piece(machine: Machine, one: Placement, other: Placement) -> bool:
    if one.plane != other.plane or one.mass_g != other.mass_g:
        return False
    plane = machine.planes[plane_index(machine, one.plane, "plane")]
    return position_index(plane, one.position_deg, "position_deg") == position_index(
        plane, other.position_deg, "position_deg"
    )


def _per_method(solved: Solved) -> tuple[MethodResult, ...]:
    return tuple(
        MethodResult(
            method=part.method,
            status=part.result.status,
            objective_value=mapping.known(part.result.value) if part.result.pieces is not None else None,
            lower_bound=_proved(part.result, part.result.lower_bound),
            evaluations=part.result.evaluations,
            seconds=part.seconds,
        )
        for part in solved.parts
    )


def _proved(result: SelectionResult, value: float) -> float | None:
    """A bound or gap, where the method proved one."""
    return None if result.pieces is None or result.status == "heuristic" else mapping.known(value)
