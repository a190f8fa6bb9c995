"""Stock masses together with parts: the box and the machine's holes, and the answer with both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.arrangement import (
    ArrangementResult,
    JointResult,
    MassChoice,
    moves,
    residuals,
    solve_with_masses,
)
from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.balancing.selection.placements import Selection
from service.balancing.selection.problem import UNLIMITED, Stock
from service.engine.arrangement import answers
from service.engine.arrangement.parts import Posed
from service.engine.rotor_state import in_order
from service.engine.selection_problem import selection_plane
from service.engine.validation import hole_label
from service.errors import InvalidInput
from service.messages import Message
from service.model.arrangement import ArrangementOffer
from service.model.machine import CatalogueItem, Machine
from service.model.plan import Placement, PlanRequest

Stop = Callable[[], bool]
MAX_PER_PLANE = 2
"""Stock masses a plane where the request does not say: what a rearrangement leaves is little."""


@dataclass(frozen=True)
class Box:
    """The box of stock masses and what is left in it; present: pieces that are bolted on and stay."""

    items: tuple[CatalogueItem, ...]
    counts: tuple[int | None, ...]
    present: tuple[Placement, ...] = ()


def with_box(
    posed: Posed,
    box: Box | None,
    deviation: Callable[[IntArray], float],
    stop: Stop,
    offer: Callable[[Posed, ArrangementResult], ArrangementOffer],
) -> tuple[ArrangementOffer, int]:
    """Answer of a request that uses the box, and what was looked at. Raises InvalidInput where there is none."""
    machine = posed.frame.machine
    if box is None or machine is None:
        raise InvalidInput(
            Message("catalogue_missing.for_parts", use=posed.request.use), field="catalogue_id", value=None
        )
    choice = _choice(posed, machine, box)
    limit = posed.request.limit if posed.request.mode == "fewest_moves" else None
    found = solve_with_masses(posed.problem, choice, posed.request.seed, limit=limit, stop=stop)
    answered = offer(posed, _result(posed, found, deviation))
    if found.arrangement is None or found.pieces is None:
        return answered, found.evaluations
    added = found.vectors - np.array([plane.fixed for plane in choice.planes])
    radius = np.array([plane.radius_mm for plane in machine.planes])
    unbalance = (added * radius) @ posed.frame.to_frame
    return (
        replace(
            answered,
            residual=answers.residual(posed, found.arrangement, unbalance),
            predicted=(),
            placements=_placements(machine, box, found.pieces),
        ),
        found.evaluations,
    )


def _choice(posed: Posed, machine: Machine, box: Box) -> MassChoice:
    request = PlanRequest(
        correction_id="-",
        objective="components",
        max_masses_per_plane=posed.request.max_masses_per_plane or MAX_PER_PLANE,
    )
    planes = tuple(
        replace(
            selection_plane(machine, plane, request, set(), [p for p in box.present if p.plane == plane.name]),
            fixed=0j,
        )
        for plane in machine.planes
    )
    stock = Stock(
        masses_g=np.array([item.mass_g for item in box.items]),
        counts=np.array([UNLIMITED if c is None else c for c in box.counts], dtype=np.int64),
        fasteners_g=np.array([item.fastener_g for item in box.items]),
    )
    radius = np.array([plane.radius_mm for plane in machine.planes])
    per_gram: ComplexArray = (radius[:, None] * posed.frame.to_frame).T.astype(np.complex128)
    return MassChoice(planes, stock, np.asarray(posed.objective.matrix @ per_gram))


def _result(posed: Posed, found: JointResult, deviation: Callable[[IntArray], float]) -> ArrangementResult:
    if found.arrangement is None:
        limit = posed.request.limit if posed.request.mode == "fewest_moves" else None
        code = "none_found" if not found.proved else "limits_exclude_each_other" if limit is None else "no_mass_meets"
        return ArrangementResult(
            "infeasible" if found.proved else "limit_reached",
            None,
            found.value,
            found.lower_bound,
            posed.problem.objective.offset,
            0,
            found.evaluations,
            code=code,
            details={} if limit is None else {"limit": limit},
        )
    scatter = deviation(found.arrangement)
    within = found.value - found.lower_bound <= scatter
    row = found.arrangement[None, :]
    return ArrangementResult(
        "optimal" if found.proved else "within_uncertainty" if within else "limit_reached",
        found.arrangement,
        found.value,
        found.lower_bound,
        residuals(posed.problem, row)[0],
        int(moves(posed.problem, row)[0]),
        found.evaluations,
        scatter=scatter,
        moves_bound=found.moves_bound,
    )


def _placements(machine: Machine, box: Box, pieces: Selection) -> tuple[Placement, ...]:
    chosen = [
        Placement(
            plane=plane.name,
            position_deg=plane.positions_deg[piece.position],
            hole=hole_label(plane, piece.position),
            mass_g=box.items[piece.item].mass_g,
            fastener_g=box.items[piece.item].fastener_g,
        )
        for plane, some in zip(machine.planes, pieces, strict=True)
        for piece in some
    ]
    return in_order(machine, chosen)
