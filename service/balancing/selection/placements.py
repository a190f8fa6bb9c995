"""Placements: what every solver of the selection problem derives from it first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.objectives import evaluate, residual
from service.balancing.selection.problem import (
    BoolArray,
    Piece,
    SelectionPlane,
    SelectionProblem,
    SelectionResult,
    Status,
    Stock,
)
from service.messages import Message, Part, Quantity

Selection = tuple[tuple[Piece, ...], ...]

MASS_SLACK = 1e-9
"""Relative slack on limits in grams, so that 100 + 200 g fit under 300 g whatever the rounding."""


def effective_g(stock: Stock) -> FloatArray:
    """(I,) mass of each item with its fastener, g."""
    return np.asarray(stock.masses_g + stock.fasteners_g, dtype=np.float64)


def within_g(mass: FloatArray, limit: FloatArray | float) -> BoolArray:
    """Whether masses stay within limits in grams, up to rounding."""
    return np.asarray(mass <= np.asarray(limit) * (1.0 + MASS_SLACK))


def slots(plane: SelectionPlane, stock: Stock) -> int:
    """Most pieces that this plane can carry at all: by its own limit, its positions' capacity and the box."""
    lightest = float(effective_g(stock).min())
    by_position: int = 0
    for pieces, grams in zip(plane.capacity.tolist(), plane.capacity_g.tolist(), strict=True):
        by_position += min(pieces, _whole(grams, lightest))
    in_the_box: int = sum(stock.counts.tolist())
    return min(int(plane.max_pieces), by_position, _whole(plane.max_mass_g, lightest), in_the_box)


def vectors_of(problem: SelectionProblem, selection: Sequence[Sequence[Piece]]) -> ComplexArray:
    """(P,) vector sums in g, fixed pieces included."""
    mass = effective_g(problem.stock)
    return np.array(
        [
            plane.fixed + sum(mass[p.item] * np.exp(1j * plane.angles[p.position]) for p in pieces)
            for plane, pieces in zip(problem.planes, selection, strict=True)
        ],
        dtype=np.complex128,
    )


def broken_limit(problem: SelectionProblem, selection: Sequence[Sequence[Piece]]) -> Message | None:
    """Name the first limit that a selection breaks; None where it breaks none."""
    mass = effective_g(problem.stock)
    used = np.zeros(len(mass), dtype=np.int64)
    for number, (plane, pieces) in enumerate(zip(problem.planes, selection, strict=True), start=1):
        at = Part("plane", number)
        items = np.array([p.item for p in pieces], dtype=np.int64)
        positions = np.array([p.position for p in pieces], dtype=np.int64)
        used += np.bincount(items, minlength=len(mass))
        per_position = np.bincount(positions, minlength=len(plane.angles))
        grams = np.asarray(np.bincount(positions, weights=mass[items], minlength=len(plane.angles)), dtype=np.float64)
        if len(pieces) > plane.max_pieces:
            return Message("limit_broken.pieces", plane=at, pieces=len(pieces), most=plane.max_pieces)
        if not within_g(grams.sum(), plane.max_mass_g).all():
            return Message(
                "limit_broken.mass", plane=at, mass=Quantity(grams.sum(), "g"), most=Quantity(plane.max_mass_g, "g")
            )
        if (per_position > plane.capacity).any():
            return Message("limit_broken.position_pieces", plane=at)
        if not within_g(grams, plane.capacity_g).all():
            return Message("limit_broken.position_mass", plane=at)
        if plane.allowed is not None and not plane.allowed[positions, items].all():
            return Message("limit_broken.not_allowed", plane=at)
    if (used > problem.stock.counts).any():
        return Message("limit_broken.stock")
    return None


def result_of(
    problem: SelectionProblem,
    selection: Sequence[Sequence[Piece]],
    status: Status,
    message: Message,
    evaluations: int,
    lower_bound: float = 0.0,
    details: dict[str, float] | None = None,
) -> SelectionResult:
    """Build the result of a solver that chose `selection`, its vectors and value computed afresh."""
    vectors = vectors_of(problem, selection)
    value = float(evaluate(problem.objective, vectors))
    return SelectionResult(
        status=status,
        message=message,
        pieces=tuple(tuple(sorted(pieces)) for pieces in selection),
        value=value,
        lower_bound=min(lower_bound, value),
        vectors=vectors,
        residual=residual(problem.objective, vectors),
        evaluations=evaluations,
        details=details or {},
    )


def _whole(grams: float, lightest: float) -> int:
    """How many of the lightest pieces weigh at most `grams`."""
    many = grams * (1.0 + MASS_SLACK) / lightest
    return int(many) if many < 2**62 else 2**62
