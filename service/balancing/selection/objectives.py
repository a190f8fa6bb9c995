"""Builders of `Objective` (the table in `selection`), and its value for many selections at once."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.rotor.reactions import reaction_matrix
from service.balancing.selection.problem import Norm, Objective
from service.errors import NumericsError
from service.messages import Message

Number = TypeVar("Number", np.float64, np.complex128)

SMALL_PRODUCT = 30_000
"""Multiplications in one product that no library spreads over threads."""
NEGLIGIBLE_REACTION = 1e-9
"""A reaction below this part of the larger one is divided by the larger: it is rounding, not a reference."""


def components(target_g: ComplexArray, radius_mm: FloatArray) -> Objective:
    """Unbalance missed against a continuous correction, in g.mm, both components, w = 0.5 (Eq 5.16-5.17).

    target_g: (P,) complex, g, the correction of each plane; radius_mm: (P,) positive.
    """
    target = np.asarray(target_g, dtype=np.complex128)
    radius = np.asarray(radius_mm, dtype=np.float64)
    _same_length("radius_mm", radius, "target_g", target)
    _positive("radius_mm", radius)
    return Objective(
        matrix=np.diag(radius).astype(np.complex128),
        offset=-radius * target,
        weights=np.full(len(target), 0.5),
        norm="components",
    )


def residual_vibration(
    influence: ComplexArray, present: ComplexArray, limits: FloatArray, norm: Norm = "sum"
) -> Objective:
    """Predicted residual vibration r = present + influence @ u, each sensor divided by its limit.

    influence: (S, P) complex, amplitude per g; present: (S,) complex amplitude; limits: (S,) positive amplitude.
    Sensors at several speeds are simply more rows.
    """
    matrix = np.asarray(influence, dtype=np.complex128)
    offset = np.asarray(present, dtype=np.complex128)
    scale = np.asarray(limits, dtype=np.float64)
    if matrix.ndim != 2 or matrix.shape[0] != len(offset):
        raise NumericsError(
            Message("numerics.influence_shape", shape=matrix.shape, sensors=len(offset)),
            field="influence",
            value=matrix.shape,
        )
    _same_length("limits", scale, "present", offset)
    _positive("limits", scale)
    return Objective(matrix=matrix, offset=offset, weights=1.0 / scale, norm=norm)


def bearing_force(
    target_g: ComplexArray,
    radius_mm: FloatArray,
    axial_mm: FloatArray,
    bearings_mm: FloatArray,
    speed_rad_s: float,
) -> Objective:
    """Reactions of a rigid rotor against those without correction, Eq 5.14: 0.5 |F_P|/|F_P0| + 0.5 |F_Q|/|F_Q0|.

    The initial unbalance is -t_i in plane i, t_i = radius_i target_i of the continuous correction.
    target_g, radius_mm, axial_mm: (P,), axial from the mass centre; bearings_mm: (2,). r is in N.
    """
    target = np.asarray(target_g, dtype=np.complex128)
    radius = np.asarray(radius_mm, dtype=np.float64)
    axial = np.asarray(axial_mm, dtype=np.float64)
    _same_length("radius_mm", radius, "target_g", target)
    _same_length("axial_mm", axial, "target_g", target)
    _positive("radius_mm", radius)
    per_gram = reaction_matrix(axial, bearings_mm, speed_rad_s) * radius
    return relative_reactions(per_gram.astype(np.complex128), -per_gram @ target)


def relative_reactions(matrix: ComplexArray, initial: ComplexArray) -> Objective:
    """Eq 5.14 for reactions `initial` (2,) in N and `matrix` (2, P) in N per g."""
    size = np.abs(initial)
    largest = float(size.max())
    if not largest > 0.0:
        raise NumericsError(Message("numerics.no_reaction"), field="target_g")
    reference = np.where(size < NEGLIGIBLE_REACTION * largest, largest, size)
    return Objective(matrix=matrix, offset=initial, weights=0.5 / reference, norm="sum")


def residual(objective: Objective, u: ComplexArray) -> ComplexArray:
    """Return r = offset + matrix @ u, shape (..., S), for vector sums u of shape (..., P) in g."""
    return np.asarray(objective.offset + rows_times(np.asarray(u), objective.matrix.T), dtype=np.complex128)


def rows_times(rows: NDArray[Number], matrix: NDArray[Number]) -> NDArray[Number]:
    """Return rows @ matrix for rows (..., k) and a small matrix (k, m), in blocks that one thread multiplies.

    A long thin product is handed to several threads by the linear algebra library, which then take more processor time
    to wait for each other than the product needs.
    """
    block = max(SMALL_PRODUCT // max(matrix.size, 1), 1)
    if not matrix.size or rows.size <= block * len(matrix):
        return rows @ matrix
    flat = rows.reshape(-1, rows.shape[-1])
    out = np.empty((len(flat), matrix.shape[1]), dtype=np.result_type(rows, matrix))
    for cut in range(0, len(flat), block):
        np.matmul(flat[cut : cut + block], matrix, out=out[cut : cut + block])
    return out.reshape(*rows.shape[:-1], matrix.shape[1])


def norm_of(objective: Objective, r: ComplexArray) -> FloatArray:
    """Weighted norm (...) of residuals r of shape (..., S)."""
    if objective.norm == "components":
        return np.asarray((objective.weights * (np.abs(r.real) + np.abs(r.imag))).sum(axis=-1), dtype=np.float64)
    size = objective.weights * np.abs(r)
    if objective.norm == "sum":
        value = size.sum(axis=-1)
    elif objective.norm == "max":
        value = size.max(axis=-1)
    else:
        value = np.sqrt((size**2).mean(axis=-1))
    return np.asarray(value, dtype=np.float64)


def evaluate(objective: Objective, u: ComplexArray) -> FloatArray:
    """Objective value (...) of vector sums u (..., P) in g, fixed pieces included."""
    return norm_of(objective, residual(objective, u))


def _same_length(name: str, array: FloatArray, other: str, reference: ComplexArray) -> None:
    if array.shape != reference.shape or array.ndim != 1:
        raise NumericsError(
            Message("numerics.entries_shape", name=name, shape=array.shape, other=other, wanted=reference.shape),
            field=name,
            value=array.shape,
        )


def _positive(name: str, array: FloatArray) -> None:
    bad = ~(np.isfinite(array) & (array > 0.0))
    if bad.any():
        raise NumericsError(
            Message("numerics.entry_not_positive", name=name, value=array[bad][0]), field=name, value=array[bad][0]
        )
