"""Planes, offset and objective of a request in arrays.

The residual unbalance U is held in one or two planes, complex g.mm. Every objective is a norm of base + matrix @ U:
unbalance, U itself; residual_vibration, the vibration now changed by what U is more than now, through the influence
coefficients; bearing_force, the reactions over those now (Eq 5.14).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.balancing.arrangement import plane_shares
from service.balancing.influence.corrections import least_squares
from service.balancing.rotor.phasors import AngleSense, ComplexArray, FloatArray, phasor
from service.balancing.rotor.reactions import reaction_matrix
from service.balancing.rotor.units import angular_speed
from service.balancing.selection.objectives import relative_reactions
from service.balancing.selection.problem import Objective
from service.engine import mapping
from service.engine.correction_solver import correction_vectors
from service.engine.influence_fits import FittedModel
from service.engine.selection_problem import PlanContext as MeasuredGround
from service.engine.selection_problem import fit_of
from service.errors import Conflict, InvalidInput
from service.messages import Message
from service.model.arrangement import ArrangementRequest
from service.model.machine import Machine


@dataclass(frozen=True)
class Measured:
    """What a correction says of the drum as it is now.

    unbalance: (Q,) complex g.mm in the machine's planes; covariance: (2Q, 2Q), nan where it is not known; dof: of it.
    on_rotor: (Q,) complex g of stock masses now.
    """

    ground: MeasuredGround
    fitted: FittedModel | None
    unbalance: ComplexArray
    covariance: FloatArray
    dof: float
    on_rotor: ComplexArray


@dataclass(frozen=True)
class Frame:
    """Where the residual is held and how it is rated.

    planes: names. axial_mm: (2,) or None for one plane. to_frame: (Q, L) share of the machine's planes. measured: None
    without a correction.
    """

    machine: Machine | None
    planes: tuple[str, ...]
    axial_mm: FloatArray | None
    to_frame: FloatArray
    sense: AngleSense
    measured: Measured | None

    def shares(self, axial_mm: FloatArray) -> FloatArray:
        """Shares (..., L) of the planes in unbalance at axial positions (...)."""
        if self.axial_mm is None:
            return np.ones((*np.shape(axial_mm), 1))
        return plane_shares(axial_mm, self.axial_mm)


def frame_of(request: ArrangementRequest, machine: Machine | None, ground: MeasuredGround | None) -> Frame:
    """The planes of a request. Raises InvalidInput where they are not determined."""
    measured = None if ground is None else measured_by(ground)
    if machine is None:
        axial = None if request.planes_axial_mm is None else np.array(request.planes_axial_mm)
        if axial is not None:
            plane_shares(axial, axial)
        names = ("1",) if axial is None else ("1", "2")
        return Frame(None, names, axial, np.eye(len(names)), request.angle_sense or "against_rotation", None)
    if len(machine.planes) == 1:
        return Frame(machine, (machine.planes[0].name,), None, np.ones((1, 1)), machine.angle_sense, measured)
    places = mapping.plane_places(machine)
    if places is None:
        raise InvalidInput(Message("plane_axial_missing"), field="machine_id", value=machine.name)
    first, last = int(np.argmin(places)), int(np.argmax(places))
    outer = sorted((first, last))
    at = places[outer]
    outermost = tuple(machine.planes[p].name for p in outer)
    return Frame(machine, outermost, at, plane_shares(places, at), machine.angle_sense, measured)


def measured_by(ground: MeasuredGround) -> Measured:
    """What a correction says is left on the drum with the stock masses that are fitted now."""
    machine = ground.machine
    radius = np.array([plane.radius_mm for plane in machine.planes])
    on_rotor = mapping.mass_vectors(machine, ground.inputs.on_rotor or ())
    target = correction_vectors(machine, ground.correction)
    fitted = fit_of(ground)
    covariance = np.full((2 * len(radius), 2 * len(radius)), np.nan)
    dof = 0.0
    if fitted is not None:
        covariance, dof = least_squares(fitted.fit).covariance, float(fitted.fit.scatter_dof.min())
    wide = np.repeat(radius, 2)
    return Measured(ground, fitted, -(target - on_rotor) * radius, covariance * np.outer(wide, wide), dof, on_rotor)


def offset_of(request: ArrangementRequest, frame: Frame) -> ComplexArray:
    """Unbalance (L,) of all but the parts, or what was left with the old parts on."""
    if request.offset is None or request.offset == "in_balance_with_old":
        return np.zeros(len(frame.planes), dtype=np.complex128)
    if request.offset == "measured":
        if frame.measured is None:
            raise InvalidInput(Message("correction_missing"), field="correction_id", value=None)
        return np.asarray(frame.measured.unbalance @ frame.to_frame, dtype=np.complex128)
    names = frame.planes if frame.machine is None else tuple(plane.name for plane in frame.machine.planes)
    total = np.zeros(len(names), dtype=np.complex128)
    for index, entry in enumerate(request.offset):
        if str(entry.plane) not in names:
            raise InvalidInput(
                Message("unknown_plane", plane=str(entry.plane), planes=names),
                field=f"offset[{index}].plane",
                value=entry.plane,
            )
        total[names.index(str(entry.plane))] += phasor(entry.unbalance_g_mm, entry.angle_deg, frame.sense)
    return np.asarray(total @ frame.to_frame, dtype=np.complex128)


def offset_covariance(request: ArrangementRequest, frame: Frame) -> tuple[FloatArray, float]:
    """Covariance (2L, 2L) of the offset and its degrees of freedom; 0 and 0 for one that is stated."""
    size = 2 * len(frame.planes)
    if request.offset != "measured" or frame.measured is None:
        return np.zeros((size, size)), 0.0
    carry = np.kron(frame.to_frame, np.eye(2))
    return np.asarray(carry.T @ frame.measured.covariance @ carry), frame.measured.dof


def objective_of(request: ArrangementRequest, frame: Frame, left: ComplexArray, now: ComplexArray | None) -> Objective:
    """The norm of base + matrix @ U, the base as its offset.

    left: (L,) what was left when the vibration was measured; now: (L,) unbalance with the present arrangement, or None.
    Raises InvalidInput or Conflict where the machine or the correction does not allow the objective.
    """
    norm = request.norm or "sum"
    size = len(frame.planes)
    if request.objective == "unbalance":
        return Objective(np.eye(size, dtype=np.complex128), np.zeros(size, dtype=np.complex128), np.ones(size), norm)
    machine = frame.machine
    if machine is None:
        raise InvalidInput(
            Message("machine_missing.for_objective", objective=request.objective), field="machine_id", value=None
        )
    if request.objective == "bearing_force":
        return _reactions(machine, frame, now)
    return _vibration(machine, frame, norm, left)


def _reactions(machine: Machine, frame: Frame, now: ComplexArray | None) -> Objective:
    _, bearings, places = mapping.require_geometry(machine)
    axial = places if frame.axial_mm is None else frame.axial_mm
    matrix = reaction_matrix(axial, bearings, angular_speed(machine.service_speed_rpm)).astype(np.complex128)
    if now is None or not np.abs(now).max() > 0.0:
        raise Conflict(Message("no_reference"), field="objective", value="bearing_force")
    rated = relative_reactions(matrix, matrix @ now)
    return Objective(matrix, np.zeros(2, dtype=np.complex128), rated.weights, rated.norm)


def _vibration(machine: Machine, frame: Frame, norm: str, left: ComplexArray) -> Objective:
    measured = frame.measured
    if measured is None or measured.fitted is None:
        raise Conflict(Message("no_influence.for_parts"), field="objective", value="residual_vibration")
    fit = measured.fitted.fit
    used = np.isfinite(fit.initial)
    names = [plane.name for plane in machine.planes]
    outer = [names.index(name) for name in frame.planes]
    radius = np.array([machine.planes[p].radius_mm for p in outer])
    matrix = fit.influence[used][:, outer] / radius
    now = fit.initial[used] + fit.influence[used] @ measured.on_rotor
    rows = [row for row, use in zip(measured.fitted.rows, used, strict=True) if use]
    weights = 1.0 / mapping.limits(machine, rows)
    return Objective(matrix, now - matrix @ left, weights, norm)  # type: ignore[arg-type]
