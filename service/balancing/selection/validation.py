"""Validate a selection problem before a solver starts."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import FloatArray
from service.balancing.selection.problem import BoolArray, Norm, Objective, SelectionPlane, SelectionProblem, Stock
from service.errors import NumericsError
from service.messages import Message, Quantity, Word

COINCIDENT_RAD = 1e-6
"""Two positions nearer than this are one hole stated twice."""


def validate(problem: SelectionProblem) -> None:
    """Check shapes, finiteness and the rules of the field; raise NumericsError naming value, rule and what to do."""
    if not problem.planes:
        raise NumericsError(Message("numerics.no_plane"), field="planes")
    _objective(problem.objective, len(problem.planes))
    for number, plane in enumerate(problem.planes, start=1):
        _plane(plane, f"plane {number}")
        if plane.allowed is not None:
            _shape(plane.allowed, (*plane.angles.shape, *problem.stock.masses_g.shape), f"plane {number}.allowed")
    _stock(problem.stock, _goes_anywhere(problem))


def _objective(objective: Objective, planes: int) -> None:
    matrix, offset, weights = objective.matrix, objective.offset, objective.weights
    if matrix.ndim != 2 or matrix.shape[0] == 0 or matrix.shape[1] != planes:
        raise NumericsError(
            Message("numerics.matrix_shape", shape=matrix.shape, planes=planes),
            field="objective.matrix",
            value=matrix.shape,
        )
    _shape(offset, (matrix.shape[0],), "objective.offset")
    _shape(weights, (matrix.shape[0],), "objective.weights")
    for name, array in (("matrix", matrix), ("offset", offset), ("weights", weights)):
        if not np.isfinite(array).all():
            raise NumericsError(Message("numerics.objective_not_finite", name=name), field=f"objective.{name}")
    if not (weights > 0.0).all():
        raise NumericsError(
            Message("numerics.weight_not_positive", weight=weights.min()),
            field="objective.weights",
            value=float(weights.min()),
        )
    if objective.norm not in get_args(Norm):
        raise NumericsError(
            Message("numerics.norm_unknown", norm=objective.norm, known=get_args(Norm)),
            field="objective.norm",
            value=objective.norm,
        )


def _plane(plane: SelectionPlane, name: str) -> None:
    angles = plane.angles
    if angles.ndim != 1 or angles.size == 0:
        raise NumericsError(Message("numerics.no_position", name=name), field=f"{name}.angles")
    if not np.isfinite(angles).all():
        raise NumericsError(Message("numerics.position_not_finite", name=name), field=f"{name}.angles")
    _apart(angles, name)
    _shape(plane.capacity, angles.shape, f"{name}.capacity")
    _shape(plane.capacity_g, angles.shape, f"{name}.capacity_g")
    _not_negative(plane.capacity, f"{name}.capacity", "zero_blocks_position")
    _not_negative(plane.capacity_g, f"{name}.capacity_g", "zero_blocks_position")
    _not_negative(np.array([plane.max_pieces]), f"{name}.max_pieces", "zero_empties_plane")
    _not_negative(np.array([plane.max_mass_g]), f"{name}.max_mass_g", "zero_empties_plane")
    if not (math.isfinite(plane.fixed.real) and math.isfinite(plane.fixed.imag)):
        raise NumericsError(
            Message("numerics.fixed_not_finite", name=name, fixed=plane.fixed),
            field=f"{name}.fixed",
            value=str(plane.fixed),
        )


def _apart(angles: FloatArray, name: str) -> None:
    turned = np.sort(np.mod(angles, 2.0 * math.pi))
    gaps = np.diff(turned, append=turned[0] + 2.0 * math.pi)
    if turned.size > 1 and gaps.min() < COINCIDENT_RAD:
        angle = math.degrees(float(turned[int(gaps.argmin())]))
        raise NumericsError(
            Message("numerics.position_twice", name=name, angle=Quantity(angle, "deg")),
            field=f"{name}.angles",
            value=angle,
        )


def _goes_anywhere(problem: SelectionProblem) -> BoolArray:
    """Items that no plane restricts to some positions; only among these is a mass stated twice a mistake."""
    free = np.ones(problem.stock.masses_g.shape, dtype=bool)
    for plane in problem.planes:
        if plane.allowed is not None:
            free &= plane.allowed.all(axis=0)
    return free


def _stock(stock: Stock, free: BoolArray) -> None:
    masses, fasteners, counts = stock.masses_g, stock.fasteners_g, stock.counts
    if masses.ndim != 1 or masses.size == 0:
        raise NumericsError(Message("numerics.stock_empty"), field="stock.masses_g")
    _shape(fasteners, masses.shape, "stock.fasteners_g")
    _shape(counts, masses.shape, "stock.counts")
    bad = ~(np.isfinite(masses) & (masses > 0.0))
    if bad.any():
        raise NumericsError(
            Message("numerics.stock_mass_not_positive", mass=Quantity(masses[bad][0], "g")),
            field="stock.masses_g",
            value=float(masses[bad][0]),
        )
    _not_negative(fasteners, "stock.fasteners_g", "zero_fastener")
    if not np.isfinite(fasteners).all():
        raise NumericsError(Message("numerics.fastener_not_finite"), field="stock.fasteners_g")
    _not_negative(counts, "stock.counts", "zero_used_up")
    order = np.lexsort((fasteners[free], masses[free]))
    pairs = np.stack([masses[free], fasteners[free]])[:, order]
    again = (pairs[:, 1:] == pairs[:, :-1]).all(axis=0)
    if again.any():
        mass = float(pairs[0, 1:][again][0])
        raise NumericsError(
            Message("numerics.stock_mass_twice", mass=Quantity(mass, "g")), field="stock.masses_g", value=mass
        )


def _shape(array: NDArray[np.generic], shape: tuple[int, ...], name: str) -> None:
    if array.shape != shape:
        raise NumericsError(
            Message("numerics.selection_array_shape", name=name, shape=array.shape, wanted=shape),
            field=name,
            value=array.shape,
        )


def _not_negative(array: NDArray[np.generic], name: str, hint: str) -> None:
    values = np.asarray(array, dtype=np.float64)
    bad = ~(values >= 0.0)
    if bad.any():
        raise NumericsError(
            Message("numerics.entry_negative", name=name, value=values[bad][0], hint=Word(hint)),
            field=name,
            value=float(values[bad][0]),
        )
