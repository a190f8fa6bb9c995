"""Reactions of a rigid rotor on two bearings.

Axial positions are measured from the mass centre along the rotor's axis. An unbalance U_i (g.mm, complex) at axial l_i
turning at w rad/s loads the bearings P and Q at l_P and l_Q with the rotating forces that hold

    F_P + F_Q         = w^2 sum_i U_i
    l_P F_P + l_Q F_Q = w^2 sum_i U_i l_i

A rotor of mass M with eccentricity e = e_x + j e_y and products of inertia I = I_xz + j I_yz adds M e to the first line
and -I to the second (thesis on the thresher's dynamic performance, chapter 5, Eq 5.4 with its signs corrected).
"""

from __future__ import annotations

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from service.messages import Message, Quantity

KG_M_PER_G_MM = 1e-6


def reaction_matrix(axial_mm: FloatArray, bearings_mm: FloatArray, speed_rad_s: float) -> FloatArray:
    """Reactions at the two bearings per unit of unbalance.

    axial_mm: (P,) of the unbalances; bearings_mm: (2,), two different positions; speed_rad_s: > 0.
    Returns (2, P), N per g.mm; row 0 is bearing P, row 1 bearing Q.
    Raises NumericsError for a wrong shape, a value that is not finite, bearings in one place, or a speed not above 0.
    """
    axial = np.asarray(axial_mm, dtype=np.float64)
    bearings = np.asarray(bearings_mm, dtype=np.float64)
    _require(axial, bearings, speed_rad_s)
    p, q = bearings
    lever = np.stack([(axial - q) / (p - q), (axial - p) / (q - p)])
    return np.asarray(speed_rad_s**2 * KG_M_PER_G_MM * lever, dtype=np.float64)


def bearing_reactions(
    unbalance: ComplexArray, axial_mm: FloatArray, bearings_mm: FloatArray, speed_rad_s: float
) -> ComplexArray:
    """Rotating reactions (2,) in N of the unbalances (P,) in g.mm at axial_mm (P,); see `reaction_matrix`."""
    vectors = np.asarray(unbalance, dtype=np.complex128)
    matrix = reaction_matrix(axial_mm, bearings_mm, speed_rad_s)
    if vectors.shape != (matrix.shape[1],):
        raise NumericsError(
            Message("numerics.unbalance_shape", shape=vectors.shape, count=matrix.shape[1]),
            field="unbalance",
            value=vectors.shape,
        )
    return np.asarray(matrix @ vectors, dtype=np.complex128)


def inherent_reactions(
    mass_kg: float,
    eccentricity_mm: complex,
    products_of_inertia_kg_m2: complex,
    bearings_mm: FloatArray,
    speed_rad_s: float,
) -> ComplexArray:
    """Rotating reactions (2,) in N of the bare rotor: mass, e_x + j e_y in mm, I_xz + j I_yz in kg m2."""
    force = bearing_reactions(
        np.array([1e3 * mass_kg * eccentricity_mm]), np.zeros(1), np.asarray(bearings_mm), speed_rad_s
    )
    span_m = 1e-3 * (float(bearings_mm[0]) - float(bearings_mm[1]))
    couple = -(speed_rad_s**2) * products_of_inertia_kg_m2 / span_m
    return np.asarray(force + np.array([couple, -couple]), dtype=np.complex128)


def _require(axial: FloatArray, bearings: FloatArray, speed_rad_s: float) -> None:
    if axial.ndim != 1:
        raise NumericsError(Message("numerics.axial_shape", shape=axial.shape), field="axial_mm", value=axial.shape)
    if bearings.shape != (2,):
        raise NumericsError(
            Message("numerics.bearings_shape", shape=bearings.shape), field="bearings_mm", value=bearings.shape
        )
    if not (np.isfinite(axial).all() and np.isfinite(bearings).all()):
        raise NumericsError(Message("numerics.axial_not_finite"), field="axial_mm")
    if bearings[0] == bearings[1]:
        raise NumericsError(
            Message("numerics.bearings_together", at=Quantity(bearings[0], "mm")),
            field="bearings_mm",
            value=float(bearings[0]),
        )
    if not (np.isfinite(speed_rad_s) and speed_rad_s > 0.0):
        raise NumericsError(
            Message("numerics.speed_not_positive", speed=speed_rad_s), field="speed_rad_s", value=speed_rad_s
        )
