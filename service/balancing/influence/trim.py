"""Trim: what to change on the rotor as it stands, and many pieces combined into few."""

from __future__ import annotations

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.errors import NumericsError
from service.messages import Message


def trim(total: ComplexArray, on_rotor: ComplexArray) -> ComplexArray:
    """Masses (P,) complex g to add to what is `on_rotor` (P,) so that it becomes `total` (P,), negative for removal."""
    if total.shape != on_rotor.shape:
        raise NumericsError(Message("numerics.trim_shape", total=total.shape, on_rotor=on_rotor.shape))
    return total - on_rotor


def combined(pieces: ComplexArray, planes: IntArray, count: int) -> ComplexArray:
    """One mass (P,) complex g per plane that replaces all pieces (N,) in it, those of several trims together.

    planes: (N,) index of each piece; count: P.
    """
    if pieces.shape != planes.shape or (len(planes) and not (planes.min() >= 0 and planes.max() < count)):
        raise NumericsError(Message("numerics.piece_plane", last=count - 1, planes=planes.tolist()), field="planes")
    sums = np.zeros(count, dtype=np.complex128)
    np.add.at(sums, planes, pieces)
    return sums


def saved_mass(pieces: ComplexArray, planes: IntArray, count: int) -> float:
    """Share of the mass in the pieces that combining them saves, 0 to 1."""
    carried = float(np.abs(pieces).sum())
    return 1.0 - float(np.abs(combined(pieces, planes, count)).sum()) / carried if carried > 0.0 else 0.0
