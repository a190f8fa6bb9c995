"""Parts and places of a request in arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.balancing.arrangement import (
    EMPTY,
    ArrangementProblem,
    GroupLimit,
    end_gains,
    part_effects,
    residual_covariance,
    scale_deviation,
)
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray, to_radians
from service.balancing.selection.problem import BoolArray, Objective
from service.engine.arrangement import request_checks as checks
from service.engine.arrangement.frame import Frame, objective_of, offset_of
from service.model.arrangement import ArrangementRequest, PartToArrange
from service.model.parts import Place


@dataclass(frozen=True)
class Posed:
    """A request in arrays.

    gains: (P, 2, L) g.mm per g at each end. effects: (K, P, L) g.mm. offset: (L,) of all but the parts, what cancels
    left out. old: (P,) parts when it was measured; relative: whether masses of parts that stay cancel. readings: see
    `residual_covariance`.
    """

    request: ArrangementRequest
    places: tuple[Place, ...]
    frame: Frame
    gains: ComplexArray
    effects: ComplexArray
    offset: ComplexArray
    old: IntArray
    relative: bool
    readings: FloatArray
    objective: Objective
    problem: ArrangementProblem

    def unbalance(self, arrangement: IntArray) -> ComplexArray:
        """Residual unbalance (L,) of an arrangement (P,)."""
        held = np.flatnonzero(arrangement != EMPTY)
        return np.asarray(self.offset + self.effects[arrangement[held], held].sum(axis=0))

    def scale_covariance(self, arrangement: IntArray) -> FloatArray:
        """Covariance (2L, 2L) of the residual unbalance from the scale."""
        return residual_covariance(self.gains, arrangement, self.old if self.relative else None, self.readings)


def pose(request: ArrangementRequest, places: tuple[Place, ...], frame: Frame) -> Posed:
    """Pose the problem of a request that was checked. Raises InvalidInput or Conflict, see `objective_of`."""
    gains = _gains(places, frame)
    ends = np.stack([_end_masses(part, places) for part in request.parts])
    effects = part_effects(ends, gains)
    old = _numbers(checks.old_parts(request.parts, places))
    present = _present(request.parts, places)
    left = offset_of(request, frame)
    relative = request.offset in ("measured", "in_balance_with_old")
    offset = left
    if relative:
        held = np.flatnonzero(old != EMPTY)
        offset = left - effects[old[held], held].sum(axis=0)
    objective = objective_of(request, frame, left, _now(effects, offset, present, places))
    allowed = _allowed(request, places)
    problem = ArrangementProblem(
        objective=Objective(objective.matrix, _rated_offset(objective, offset), objective.weights, objective.norm),
        effects=np.asarray(effects @ objective.matrix.T),
        allowed=allowed,
        may_be_empty=_may_be_empty(request, places, allowed, present),
        present=present,
        new=np.array([part.new for part in request.parts]),
        masses_g=ends.sum(axis=2).max(axis=1),
        sets=_sets(request.parts),
        groups=_groups(request, places),
        max_moves=request.max_moves,
        max_new=request.max_new_parts,
    )
    return Posed(request, places, frame, gains, effects, offset, old, relative, _readings(request), objective, problem)


def _rated_offset(objective: Objective, offset: ComplexArray) -> ComplexArray:
    return np.asarray(objective.offset + objective.matrix @ offset)


def _gains(places: tuple[Place, ...], frame: Frame) -> ComplexArray:
    axial = np.array([[place.axial_mm[0], place.axial_mm[-1]] for place in places])
    angles = np.array([to_radians(place.angle_deg, frame.sense) for place in places])
    return end_gains(np.array([place.radius_mm for place in places]), angles, axial, frame.shares(axial))


def _end_masses(part: PartToArrange, places: tuple[Place, ...]) -> FloatArray:
    """Mass (P, 2) at both ends of each place: of one mass half at each end of a place with two."""
    out = np.zeros((len(places), 2))
    readings = checks.masses_of(part)
    for p, place in enumerate(places):
        whole = readings if part.moment_g_mm is None else (part.moment_g_mm / place.radius_mm,)
        if len(whole) == 2:
            out[p] = whole
        elif whole:
            # A place with one position has both ends there.
            out[p] = whole[0] / 2.0
    return out


def _readings(request: ArrangementRequest) -> FloatArray:
    """What one standard deviation of each reading adds to the ends, (K, 2, 2); 0 for a moment scale or none stated."""
    out = np.zeros((len(request.parts), 2, 2))
    if request.scale_resolution_g is None:
        return out
    deviation = scale_deviation(request.scale_resolution_g)
    for k, part in enumerate(request.parts):
        if part.mass_g is None or part.moment_g_mm is not None:
            continue
        if isinstance(part.mass_g, tuple):
            out[k] = deviation * np.eye(2)
        else:
            out[k, 0] = deviation / 2.0
    return out


def _numbers(parts: list[int | None]) -> IntArray:
    return np.array([EMPTY if part is None else part for part in parts], dtype=np.int64)


def _present(parts: tuple[PartToArrange, ...], places: tuple[Place, ...]) -> IntArray:
    labels = [place.label for place in places]
    out = np.full(len(places), EMPTY, dtype=np.int64)
    for k, part in enumerate(parts):
        if part.present is not None and checks.may_of(part) != "gone":
            out[labels.index(part.present)] = k
    return out


def _now(
    effects: ComplexArray, offset: ComplexArray, present: IntArray, places: tuple[Place, ...]
) -> ComplexArray | None:
    """Unbalance with the present arrangement; None where a place that must be filled is empty."""
    held = np.flatnonzero(present != EMPTY)
    if any(present[p] == EMPTY and not place.may_be_empty for p, place in enumerate(places)):
        return None
    return np.asarray(offset + effects[present[held], held].sum(axis=0))


def _allowed(request: ArrangementRequest, places: tuple[Place, ...]) -> BoolArray:
    parts = request.parts
    allowed = np.array([[checks.fits(part, place) for place in places] for part in parts])
    stays = [k for k in range(len(parts)) if _stays(request, k)]
    for k, part in enumerate(parts):
        if checks.may_of(part) == "gone" or (request.use == "box" and k not in stays):
            allowed[k] = False
    labels = [place.label for place in places]
    for k in stays:
        here = labels.index(str(parts[k].present))
        allowed[k], allowed[:, here] = False, False
        allowed[k, here] = True
    return np.asarray(allowed, dtype=np.bool_)


def _stays(request: ArrangementRequest, part: int) -> bool:
    """Whether a part is to stay: as stated, or as all that are mounted where only the box is used."""
    one = request.parts[part]
    may = checks.may_of(one)
    return may == "stay" or (request.use == "box" and may != "gone" and one.present is not None)


def _may_be_empty(
    request: ArrangementRequest, places: tuple[Place, ...], allowed: BoolArray, present: IntArray
) -> BoolArray:
    may = np.array([place.may_be_empty for place in places])
    for p in range(len(places)):
        part = int(present[p])
        if part != EMPTY and _stays(request, part) and allowed[part, p]:
            may[p] = False
    return np.asarray(may, dtype=np.bool_)


def _sets(parts: tuple[PartToArrange, ...]) -> tuple[tuple[int, ...], ...]:
    names = sorted({part.set for part in parts if part.set is not None and checks.may_of(part) != "gone"})
    sets = [
        tuple(k for k, part in enumerate(parts) if part.set == name and checks.may_of(part) != "gone") for name in names
    ]
    return tuple(members for members in sets if len(members) > 1)


def _groups(request: ArrangementRequest, places: tuple[Place, ...]) -> tuple[GroupLimit, ...]:
    return tuple(
        GroupLimit(tuple(p for p, place in enumerate(places) if place.group == limit.group), limit.max_difference_g)
        for limit in request.group_limits
    )
