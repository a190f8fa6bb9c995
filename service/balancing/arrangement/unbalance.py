"""What a part in a place does: its unbalance, carried to the correction planes by the lever rule.

A part of mass m at radius R and angle a gives m R exp(j a), in g.mm, at its axial position z; of a part weighed at both
ends each end gives its own. In planes at z1 and z2 that acts as the shares (z2 - z) / (z2 - z1) and
(z - z1) / (z2 - z1).
"""

from __future__ import annotations

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from service.messages import Message


def plane_shares(axial_mm: FloatArray, planes_mm: FloatArray) -> FloatArray:
    """Shares (..., 2) that planes at `planes_mm` (2,) take of unbalance at `axial_mm` (...); they add up to 1."""
    first, second = (float(plane) for plane in planes_mm)
    if first == second:
        raise NumericsError(Message("planes_at_one_position", at=first), field="planes_axial_mm", value=first)
    to_second = (np.asarray(axial_mm, dtype=np.float64) - first) / (second - first)
    return np.stack([1.0 - to_second, to_second], axis=-1)


def end_gains(radius_mm: FloatArray, angles: FloatArray, axial_mm: FloatArray, to_planes: FloatArray) -> ComplexArray:
    """Unbalance (P, 2, S) in each of S planes per gram at each end of a place.

    radius_mm, angles: (P,), radians in the internal sense. axial_mm: (P, 2), both ends, the same twice for a place with
    one position; then the mass goes to the first end. to_planes: (P, 2, S) shares of the ends, from `plane_shares`.
    """
    turn = np.asarray(radius_mm) * np.exp(1j * np.asarray(angles))
    if axial_mm.shape != (len(turn), 2):
        raise NumericsError(Message("numerics.axial_positions_shape", shape=axial_mm.shape, ends=len(turn)))
    return np.asarray(turn[:, None, None] * to_planes)


def part_effects(end_masses_g: FloatArray, gains: ComplexArray) -> ComplexArray:
    """Effect (K, P, S) of each part in each place.

    end_masses_g: (K, P, 2), the mass that part k has at the ends of place p; gains: (P, 2, S) from `end_gains`.
    """
    return np.asarray(np.einsum("kpe,pes->kps", end_masses_g, gains))
