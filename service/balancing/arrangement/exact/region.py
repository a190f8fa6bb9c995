"""Where the residual of an arrangement better than a level must lie: a box on a few real axes.

In weighted residuals every norm bounds the length of the vector (2-norm): sum and components are at least the length,
max and rms at least the length / sqrt(S). A support direction w with <w, r> >= least for every arrangement cuts off
what no arrangement reaches; orthogonal to it the box is narrower by Pythagoras.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from service.balancing.arrangement.exact.slots import Slots
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.problem import Norm

RANK_TOLERANCE = 1e-10
"""Singular values below this part of the largest are rounding."""
ROUNDING = 1e-9
"""Part of the extent that lengths are rounded by."""
NARROW = 0.3
"""Part of the radius that the support must reach for the axes to be turned to it."""


def as_real(z: ComplexArray) -> FloatArray:
    """Real and imaginary parts (..., 2S) of vectors (..., S)."""
    return np.ascontiguousarray(z, dtype=np.complex128).view(np.float64)


def length_factor(norm: Norm, components: int) -> float:
    """Greatest length of a vector of this norm 1."""
    return 1.0 if norm in ("sum", "components") else math.sqrt(components)


def dual_norm(norm: Norm, direction: FloatArray) -> FloatArray:
    """Greatest <direction, r> (...) of all r of norm 1, for directions (..., 2S)."""
    if norm == "components":
        return np.asarray(np.abs(direction).max(axis=-1))
    size = np.hypot(direction[..., ::2], direction[..., 1::2])
    if norm == "sum":
        return np.asarray(size.max(axis=-1))
    if norm == "max":
        return np.asarray(size.sum(axis=-1))
    return np.asarray(math.sqrt(size.shape[-1]) * np.sqrt((size**2).sum(axis=-1)))


@dataclass(frozen=True)
class Support:
    """A unit direction (2S,) and the least <direction, r> of all arrangements."""

    direction: FloatArray
    least: float


@dataclass(frozen=True)
class Axes:
    """Orthonormal axes (d, 2S) that arrangements move the residual along, the rest of the residual, and the norm.

    rest: squared length of what no arrangement changes. first_least: least coordinate on axis 0, -inf where unknown.
    """

    basis: FloatArray
    rest: float
    first_least: float
    norm: Norm

    def coordinates(self, z: ComplexArray) -> FloatArray:
        """Coordinates (..., d) of vectors (..., S)."""
        return np.asarray(as_real(z) @ self.basis.T)

    def box(self, level: float) -> tuple[FloatArray, FloatArray]:
        """Bounds (d,) of the coordinates of every residual whose norm is at most `level`."""
        size = self.basis.shape[1] // 2
        reach = (length_factor(self.norm, size) * level) ** 2 - self.rest
        half = np.full(len(self.basis), math.sqrt(max(reach, 0.0)))
        if self.first_least > 0.0:
            half[1:] = math.sqrt(max(reach - self.first_least**2, 0.0))
        half = np.minimum(half, level * dual_norm(self.norm, self.basis))
        low = -half
        if len(low):
            low[0] = max(low[0], self.first_least)
        return low, half


def axes_of(slots: Slots, support: Support | None, level: float) -> Axes:
    """Axes of a problem; turned to the support direction where that makes the box of `level` narrower."""
    size = slots.offset.shape[0]
    moved = slots.effects - slots.effects[slots.base, np.arange(slots.size)][None, :, :]
    moved = moved[slots.allowed].reshape(-1, size)
    span = as_real(moved)
    if not len(span):
        return Axes(np.zeros((0, 2 * size)), 0.0, -math.inf, slots.norm)
    _, strength, rows = np.linalg.svd(span, full_matrices=False)
    rank = int((strength > RANK_TOLERANCE * strength[0]).sum()) if strength[0] > 0.0 else 0
    basis = np.eye(2 * size) if rank == 2 * size else rows[:rank]
    start = as_real(slots.offset + slots.effects[slots.base, np.arange(slots.size)].sum(axis=0))
    outside = start - (start @ basis.T) @ basis
    rest = max(0.0, float(np.linalg.norm(outside)) - ROUNDING * (float(np.linalg.norm(start)) + strength[0])) ** 2
    least = -math.inf
    reach = length_factor(slots.norm, size) * level
    if support is not None and support.least > NARROW * reach:
        along = (basis @ support.direction) @ basis
        length = float(np.linalg.norm(along))
        if length > 0.9:
            # <w, r> = <along, r> + <w - along, outside>: the second part is the same for every arrangement.
            least = (support.least - float((support.direction - along) @ outside)) / length
            basis = _turned(basis, along / length)
    return Axes(basis, rest, least, slots.norm)


def _turned(basis: FloatArray, first: FloatArray) -> FloatArray:
    """Orthonormal basis (d, 2S) of the same space that begins with `first`."""
    q, _ = np.linalg.qr(np.column_stack([first, basis.T]))
    turned = q[:, : len(basis)].T
    turned[0] = first
    return np.asarray(turned)
