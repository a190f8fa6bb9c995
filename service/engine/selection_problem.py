"""The discrete problem of a plan in arrays, and selections of it as placements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, to_radians
from service.balancing.rotor.units import angular_speed
from service.balancing.selection import objectives
from service.balancing.selection.mounted_pieces import MountedPiece, MountedProblem, with_fitted
from service.balancing.selection.placements import Selection
from service.balancing.selection.problem import UNLIMITED, Norm, Objective, SelectionPlane, SelectionProblem, Stock
from service.engine import mapping
from service.engine.correction_solver import correction_vectors
from service.engine.influence_fits import FittedModel, fit_again
from service.engine.objective_uncertainty import objective_scatter
from service.engine.rotor_state import as_found_placement, in_order
from service.engine.validation import POSITION_TOLERANCE_DEG, hole_label, plane_index, position_index
from service.errors import Conflict, InvalidInput
from service.messages import Message
from service.model.correction import Correction
from service.model.machine import CatalogueItem, Machine, Plane
from service.model.plan import BlockedPosition, ObjectiveName, Placement, PlanInputs, PlanRequest, Robust
from service.model.run import Run, RunOut
from service.model.session import AsFoundPiece


@dataclass(frozen=True)
class PlanContext:
    """All that a plan is made on; `runs` are all of the session's, the correction says which of them it used."""

    machine: Machine
    items: tuple[CatalogueItem, ...]
    runs: tuple[Run, ...]
    run_out: tuple[RunOut, ...]
    as_found: tuple[AsFoundPiece, ...]
    correction: Correction
    inputs: PlanInputs


@dataclass(frozen=True)
class PlanProblem:
    """A plan in arrays, with the pieces on the rotor in it; `objective` is of masses on the as-found rotor."""

    ground: PlanContext
    request: PlanRequest
    target: ComplexArray
    fitted: FittedModel | None
    objective: Objective
    pieces: MountedProblem
    uncertainty: float

    @property
    def problem(self) -> SelectionProblem:
        """The problem that solvers take."""
        return self.pieces.problem

    def placements(self, selection: Selection) -> tuple[tuple[Placement, ...], tuple[Placement, ...]]:
        """The final state of the rotor, and what of the as-found rotor is taken off."""
        machine = self.ground.machine
        fates, new = self.pieces.fates(selection)
        chosen = [
            _placement(plane, piece.position, self.ground.items[piece.item])
            for plane, pieces in zip(machine.planes, new, strict=True)
            for piece in pieces
        ]
        off = list(self._stay_off())
        for fate in fates:
            if fate.does == "stays" or fate.to is None:
                continue
            plane = machine.planes[fate.to[0]]
            chosen.append(moved_to(plane, fate.to[1], fate.piece.mass_g))
        off += [
            as_found_placement(machine, piece)
            for piece, fate in zip(self.ground_pieces(), fates, strict=True)
            if fate.does != "stays"
        ]
        kept = self.ground.inputs.present if self.request.base == "present" else ()
        return in_order(machine, (*kept, *chosen)), in_order(machine, off)

    def ground_pieces(self) -> tuple[AsFoundPiece, ...]:
        """As-found pieces that are on the rotor while it is planned for."""
        return on_now(self.ground) if self.request.base == "present" else self.ground.as_found

    def _stay_off(self) -> tuple[Placement, ...]:
        return self.ground.inputs.present_off if self.request.base == "present" else ()


def base_objective(request: PlanRequest) -> ObjectiveName:
    """The objective of one case; that of a robust plan is a figure over many of them."""
    if request.objective != "robust":
        return request.objective
    return (request.robust or Robust()).base


def pose(ground: PlanContext, request: PlanRequest) -> PlanProblem:
    """Pose a plan's problem. Raises InvalidInput, Conflict for a request that cannot be meant."""
    machine = ground.machine
    target = correction_vectors(machine, ground.correction)
    fitted = fit_of(ground)
    objective = _objective(machine, request, target, fitted)
    present = request.base == "present"
    kept = ground.inputs.present if present else ()
    off = ground.inputs.present_off if present else ()
    blocked = _blocked(machine, request.blocked)
    planes = tuple(
        selection_plane(machine, plane, request, blocked[p], [k for k in kept if k.plane == plane.name])
        for p, plane in enumerate(machine.planes)
    )
    gone = mapping.placement_vectors(machine, off)
    planes = tuple(replace(plane, fixed=plane.fixed - complex(gone[p])) for p, plane in enumerate(planes))
    stock = Stock(
        masses_g=np.array([item.mass_g for item in ground.items]),
        counts=np.array([UNLIMITED if c is None else c for c in ground.inputs.counts], dtype=np.int64),
        fasteners_g=np.array([item.fastener_g for item in ground.items]),
    )
    on_rotor = [_fitted_piece(machine, piece) for piece in (on_now(ground) if present else ground.as_found)]
    pieces = with_fitted(
        SelectionProblem(objective, planes, stock),
        on_rotor,
        in_offset=True,
        tolerance=math.radians(POSITION_TOLERANCE_DEG),
    )
    scatter = objective_scatter(objective, base_objective(request), fitted, target)
    return PlanProblem(ground, request, target, fitted, objective, pieces, scatter)


def fit_of(ground: PlanContext) -> FittedModel | None:
    """The fit that the correction rests on; None for a balancer's answer."""
    return fit_again(ground.machine, ground.runs, ground.run_out, ground.correction)


def on_now(ground: PlanContext) -> tuple[AsFoundPiece, ...]:
    """As-found pieces that the plan fitted now has left where they were."""
    gone = [(p.plane, p.position_deg, p.mass_g) for p in ground.inputs.present_off]
    left = []
    for piece in ground.as_found:
        key = (piece.plane, as_found_placement(ground.machine, piece).position_deg, piece.mass_g)
        if key in gone:
            gone.remove(key)
        else:
            left.append(piece)
    return tuple(left)


def moved_to(plane: Plane, position: int, mass_g: float) -> Placement:
    """A piece of the as-found rotor in a position."""
    return Placement(
        plane=plane.name,
        position_deg=plane.positions_deg[position],
        hole=hole_label(plane, position),
        mass_g=mass_g,
        from_box=False,
    )


def _fitted_piece(machine: Machine, piece: AsFoundPiece) -> MountedPiece:
    plane = plane_index(machine, piece.plane, "on_rotor.plane")
    return MountedPiece(plane, to_radians(piece.position_deg, machine.angle_sense), piece.mass_g, piece.may)


def _placement(plane: Plane, position: int, item: CatalogueItem) -> Placement:
    return Placement(
        plane=plane.name,
        position_deg=plane.positions_deg[position],
        hole=hole_label(plane, position),
        mass_g=item.mass_g,
        fastener_g=item.fastener_g,
    )


def _objective(machine: Machine, request: PlanRequest, target: ComplexArray, fitted: FittedModel | None) -> Objective:
    objective = base_objective(request)
    if request.objective != "robust" and request.robust is not None:
        raise InvalidInput(
            Message("invalid_input.option_of_other_objective", name="robust", objective=request.objective),
            field="robust",
            value="robust",
        )
    if objective != "residual_vibration":
        for name in ("norm", "weights"):
            if getattr(request, name) is not None:
                raise InvalidInput(
                    Message("invalid_input.option_of_other_objective", name=name, objective=objective),
                    field=name,
                    value=name,
                )
    radius = np.array([plane.radius_mm for plane in machine.planes])
    if objective == "components":
        return objectives.components(target, radius)
    if objective == "bearing_force":
        _, bearings, places = mapping.require_geometry(machine)
        return objectives.bearing_force(target, radius, places, bearings, angular_speed(machine.service_speed_rpm))
    return _residual(machine, request, fitted)


def _residual(machine: Machine, request: PlanRequest, fitted: FittedModel | None) -> Objective:
    if fitted is None:
        raise Conflict(Message("no_influence.balancer_answer"), field="objective", value="residual_vibration")
    used = np.isfinite(fitted.fit.initial)
    rows = [row for row, use in zip(fitted.rows, used, strict=True) if use]
    limits = mapping.limits(machine, rows)
    if request.weights is not None:
        if len(request.weights) != len(rows):
            raise InvalidInput(
                Message("invalid_input.weights_count", count=len(request.weights), needed=len(rows)),
                field="weights",
                value=list(request.weights),
            )
        limits = limits / np.array(request.weights)
    # The fewest masses that bring every sensor within its limit are asked of the worst sensor.
    norm: Norm = request.norm or ("max" if request.mode == "fewest" else "sum")
    return objectives.residual_vibration(fitted.fit.influence[used], fitted.fit.initial[used], limits, norm)


def _blocked(machine: Machine, blocked: Sequence[BlockedPosition]) -> list[set[int]]:
    out: list[set[int]] = [set() for _ in machine.planes]
    for index, stop in enumerate(blocked):
        plane = plane_index(machine, stop.plane, f"blocked[{index}].plane")
        out[plane].add(position_index(machine.planes[plane], stop.position_deg, f"blocked[{index}].position_deg"))
    return out


def selection_plane(
    machine: Machine, plane: Plane, request: PlanRequest, blocked: set[int], kept: Sequence[Placement]
) -> SelectionPlane:
    """A plane as the selection sees it: blocked positions take nothing, kept pieces stay and take their room."""
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
