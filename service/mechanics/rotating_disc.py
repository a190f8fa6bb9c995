"""A rotating disc whose thickness is a spline over its radius: mass, energy and stresses (plane stress, free edges).

Both radius and thickness are clamped cubic curves over a parameter u in [0, segments]. With F = t r sigma_r per
radius, equilibrium and compatibility give a linear two-point problem,
r^2 F'' + r F' - F + (3 + nu) rho w^2 r^3 t - (r t'/t)(r F' - nu F) = 0, F given at both edges, which is solved by
Chebyshev collocation in every segment with F and dF/du continuous between them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from service.mechanics.bodies import FloatArray
from service.mechanics.refusals import Refusal
from service.mechanics.spline import basis, segments
from service.messages import Message

Criterion = Literal["von_mises", "largest_principal"]

COLLOCATION = 22
"""Degree of the polynomials of a segment: the largest stress is right to 1e-8."""
GAUSS = 8
"""Points a segment for mass and energy; the integrands are polynomials, so that this is exact."""
FINE = 48
"""Places a segment among which the largest stress is looked for before its place is refined."""


@dataclass(frozen=True)
class Disc:
    """Data of a disc, SI. radii: control radii (n,), rising. inner_load, outer_load: radial stress at the edges, Pa."""

    radii: FloatArray
    speed: float
    density: float
    poisson: float
    inner_load: float = 0.0
    outer_load: float = 0.0

    def __post_init__(self) -> None:
        """Refuse radii that do not rise from above 0, and properties out of range."""
        if self.radii.ndim != 1 or not np.isfinite(self.radii).all() or self.radii[0] <= 0.0:
            raise Refusal(Message("disc_radius", field="radii", value=float(self.radii[0])))
        if (np.diff(self.radii) <= 0.0).any():
            raise Refusal(Message("disc_radii_order", field="radii", value=float(np.diff(self.radii).min())))
        if not 0.0 <= self.poisson < 0.5:
            raise Refusal(Message("disc_poisson", field="poisson", value=self.poisson))
        if not (math.isfinite(self.density) and self.density > 0.0):
            raise Refusal(Message("disc_density", field="density", value=self.density))
        if not math.isfinite(self.speed) or self.speed == 0.0:
            raise Refusal(Message("speed_zero", field="speed", value=self.speed))
        segments(len(self.radii))

    @cached_property
    def mass_weights(self) -> FloatArray:
        """Mass per unit of each control thickness (n,), kg/m."""
        n, r, r_u, weights = self._quadrature
        return np.asarray(2.0 * math.pi * self.density * (weights * r * r_u) @ n)

    @cached_property
    def energy_weights(self) -> FloatArray:
        """Kinetic energy per unit of each control thickness (n,), J/m."""
        n, r, r_u, weights = self._quadrature
        return np.asarray(math.pi * self.density * self.speed**2 * (weights * r**3 * r_u) @ n)

    @property
    def _quadrature(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        points, weights = np.polynomial.legendre.leggauss(GAUSS)
        count = len(self.radii)
        u = (np.arange(segments(count))[:, None] + (points + 1.0) / 2.0).ravel()
        n = basis(count, u)
        return n, n @ self.radii, basis(count, u, 1) @ self.radii, np.tile(weights / 2.0, segments(count))

    @cached_property
    def grid(self) -> Grid:
        """Where the two-point problem is collocated."""
        return Grid.of(len(self.radii), self.radii)


@dataclass(frozen=True)
class Grid:
    """Collocation nodes u (segments, k), with basis and radius there; difference: (k, k) d/du within a segment."""

    u: FloatArray
    n: FloatArray
    n_u: FloatArray
    r: FloatArray
    r_u: FloatArray
    r_uu: FloatArray
    difference: FloatArray
    weights: FloatArray
    fine: FloatArray
    at_fine: FloatArray

    @classmethod
    def of(cls, count: int, radii: FloatArray) -> Grid:
        """Chebyshev points of each segment, both ends included."""
        x, difference, weights = _chebyshev(COLLOCATION)
        u = np.arange(segments(count))[:, None] + (x + 1.0) / 2.0
        fine = (1.0 - np.cos(math.pi * np.arange(FINE + 1) / FINE)) / 2.0
        n, n_u, n_uu = (basis(count, u.ravel(), k).reshape(*u.shape, count) for k in range(3))
        at_fine = np.stack([_interpolation(x, weights, 2.0 * one - 1.0) for one in fine])
        return cls(u, n, n_u, n @ radii, n_u @ radii, n_uu @ radii, 2.0 * difference, weights, fine, at_fine)

    def row(self, part: float) -> FloatArray:
        """Weights (k,) that give a function at a part (0..1) of a segment from its values at the nodes."""
        x = np.cos(math.pi * np.arange(COLLOCATION, -1, -1) / COLLOCATION)
        return _interpolation(x, self.weights, 2.0 * part - 1.0)


@dataclass(frozen=True)
class Stresses:
    """Stresses at places (...), Pa. slopes: of the equivalent stress by each control thickness (..., n), Pa/m."""

    r: FloatArray
    thickness: FloatArray
    radial: FloatArray
    hoop: FloatArray
    equivalent: FloatArray
    slopes: FloatArray


@dataclass(frozen=True)
class Solution:
    """Stress function F (segments, k) at the nodes and its slopes (segments, k, n) by the control thicknesses."""

    disc: Disc
    thickness: FloatArray
    speed: float
    f: FloatArray
    f_t: FloatArray
    criterion: Criterion

    def at_nodes(self) -> Stresses:
        """Stresses at the collocation nodes (segments, k)."""
        grid = self.disc.grid
        f_u, f_tu = self.f @ grid.difference.T, np.einsum("ij,sjn->sin", grid.difference, self.f_t)
        return self._stresses(grid.r, grid.r_u, grid.n, self.f, f_u, self.f_t, f_tu)

    def at(self, segment: int, part: float) -> Stresses:
        """Stresses at one place: a part (0..1) of a segment."""
        grid, count = self.disc.grid, len(self.thickness)
        row = grid.row(part)
        u = np.array([segment + part])
        n, radius_u = basis(count, u)[0], basis(count, u, 1)[0] @ self.disc.radii
        turned = row @ grid.difference
        return self._stresses(
            np.array(n @ self.disc.radii),
            np.array(radius_u),
            n,
            np.array(row @ self.f[segment]),
            np.array(turned @ self.f[segment]),
            row @ self.f_t[segment],
            turned @ self.f_t[segment],
        )

    def peaks(self) -> tuple[list[Stresses], list[tuple[int, float]]]:
        """The largest equivalent stress of every segment, its place refined, and those places."""
        grid, found, places = self.disc.grid, [], []
        at_fine = np.einsum("fk,sk->sf", grid.at_fine, self.at_nodes().equivalent)
        for segment, values in enumerate(at_fine):
            k = int(values.argmax())
            part = float(grid.fine[k])
            if 0 < k < FINE:
                part = self._refined(segment, part, float(grid.fine[k + 1] - grid.fine[k - 1]) / 2.0)
            found.append(self.at(segment, part))
            places.append((segment, part))
        return found, places

    def _refined(self, segment: int, part: float, step: float) -> float:
        """Place of the largest stress near a part of a segment, by parabolas over ever smaller steps."""
        for _ in range(3):
            step = min(step, part, 1.0 - part)
            if step <= 0.0:
                return part
            left, middle, right = (
                float(self.at(segment, place).equivalent) for place in (part - step, part, part + step)
            )
            bend = left - 2.0 * middle + right
            if bend >= 0.0:
                return part
            part = float(np.clip(part + step * (left - right) / (2.0 * bend), part - step, part + step))
            step /= 16.0
        return part

    def _stresses(
        self,
        r: FloatArray,
        r_u: FloatArray,
        n: FloatArray,
        f: FloatArray,
        f_u: FloatArray,
        f_t: FloatArray,
        f_tu: FloatArray,
    ) -> Stresses:
        t = n @ self.thickness
        load = self.disc.density * self.speed**2 * r**2
        radial, hoop = f / (t * r), f_u / (r_u * t) + load
        radial_t = f_t / (t * r)[..., None] - (radial / t)[..., None] * n
        hoop_t = f_tu / (r_u * t)[..., None] - ((hoop - load) / t)[..., None] * n
        if self.criterion == "largest_principal":
            upper = hoop >= radial
            equivalent = np.where(upper, hoop, radial)
            return Stresses(r, t, radial, hoop, equivalent, np.where(upper[..., None], hoop_t, radial_t))
        equivalent = np.sqrt(np.maximum(radial**2 + hoop**2 - radial * hoop, 1e-300))
        by_radial, by_hoop = (2.0 * radial - hoop) / (2.0 * equivalent), (2.0 * hoop - radial) / (2.0 * equivalent)
        slopes = by_radial[..., None] * radial_t + by_hoop[..., None] * hoop_t
        return Stresses(r, t, radial, hoop, equivalent, slopes)


def solve(disc: Disc, thickness: FloatArray, *, overspeed: float = 1.0, criterion: Criterion = "von_mises") -> Solution:
    """Stresses of a disc with control thicknesses (n,), m, full thickness, at `overspeed` times its speed.

    Raises Refusal where the thickness is not above 0 everywhere.
    """
    grid, speed = disc.grid, disc.speed * overspeed
    if thickness.shape != disc.radii.shape or not np.isfinite(thickness).all():
        raise Refusal(Message("disc_thickness_count", field="thickness", value=len(thickness), count=len(disc.radii)))
    t, t_u = grid.n @ thickness, grid.n_u @ thickness
    if (t <= 0.0).any():
        raise Refusal(Message("disc_thickness", field="thickness", value=float(t.min())))
    nu, r, r_u = disc.poisson, grid.r, grid.r_u
    steep = t_u / t
    c2 = r**2 * r_u
    c1 = r * r_u**2 - r**2 * grid.r_uu - r**2 * r_u * steep
    c0 = nu * r * steep * r_u**2 - r_u**3
    push = (3.0 + nu) * disc.density * speed**2 * r**3 * r_u**3
    d1 = grid.difference
    d2 = d1 @ d1
    blocks = c2[:, :, None] * d2 + c1[:, :, None] * d1 + c0[:, :, None] * np.eye(len(d1))
    system = _Segments.of(blocks, d1)
    edges = np.array([[t[0, 0] * r[0, 0] * disc.inner_load], [t[-1, -1] * r[-1, -1] * disc.outer_load]])
    f = system.solved(-(push * t)[..., None], edges)[..., 0]
    f_u = f @ d1.T
    # The same system differentiated by each control thickness: only t'/t and the load depend on it.
    steep_t = grid.n_u / t[..., None] - (t_u / t**2)[..., None] * grid.n
    f_u = f @ d1.T
    moved = (-(r**2) * r_u * f_u + nu * r * r_u**2 * f)[..., None] * steep_t + push[..., None] * grid.n
    edges_t = np.stack([grid.n[0, 0] * r[0, 0] * disc.inner_load, grid.n[-1, -1] * r[-1, -1] * disc.outer_load])
    return Solution(disc, thickness, speed, f, system.solved(-moved, edges_t), criterion)


@dataclass(frozen=True)
class _Segments:
    """The collocated equation of every segment, solved for given end values, and what joins the segments.

    inverse: (segments, k, k); knots: (segments - 1, segments + 1) system that makes dF/du continuous.
    """

    inverse: FloatArray
    difference: FloatArray
    knots: FloatArray

    @classmethod
    def of(cls, blocks: FloatArray, difference: FloatArray) -> _Segments:
        """From the equations (segments, k, k); their first and last rows give way to the end values."""
        count = len(blocks)
        blocks[:, [0, -1]] = 0.0
        blocks[:, 0, 0] = blocks[:, -1, -1] = 1.0
        inverse: FloatArray = np.linalg.inv(blocks).astype(np.float64)
        knots = np.zeros((count - 1, count + 1))
        for s in range(count - 1):
            knots[s, s : s + 2] += difference[-1] @ inverse[s][:, [0, -1]]
            knots[s, s + 1 : s + 3] -= difference[0] @ inverse[s + 1][:, [0, -1]]
        return cls(inverse, difference, knots)

    def solved(self, right: FloatArray, edges: FloatArray) -> FloatArray:
        """F (segments, k, m) for right sides (segments, k, m) and values at both edges (2, m)."""
        right = right.copy()
        right[:, [0, -1]] = 0.0
        alone = self.inverse @ right
        ends = np.zeros((len(right) + 1, right.shape[2]))
        ends[[0, -1]] = edges
        if len(self.knots):
            jump = (
                alone[:-1].transpose(0, 2, 1) @ self.difference[-1] - alone[1:].transpose(0, 2, 1) @ self.difference[0]
            )
            known = jump + self.knots[:, [0, -1]] @ edges
            ends[1:-1] = -np.linalg.solve(self.knots[:, 1:-1], known)
        return alone + self.inverse[:, :, [0]] * ends[:-1, None] + self.inverse[:, :, [-1]] * ends[1:, None]


def _chebyshev(degree: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (k,) from -1 to 1, differentiation matrix (k, k) and barycentric weights (k,)."""
    x = np.cos(math.pi * np.arange(degree, -1, -1) / degree)
    weights = (-1.0) ** np.arange(degree + 1)
    weights[[0, -1]] /= 2.0
    away = x[:, None] - x[None] + np.eye(degree + 1)
    matrix = weights[None] / weights[:, None] / away
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return np.asarray(x, dtype=np.float64), matrix, np.asarray(weights, dtype=np.float64)


def _interpolation(x: FloatArray, weights: FloatArray, at: float) -> FloatArray:
    away = at - x
    exact = np.abs(away) < 1e-14
    if exact.any():
        return exact.astype(np.float64)
    terms = weights / away
    return np.asarray(terms / terms.sum())
