"""Ellipsoids of many problems at once: where each one's selections better than a level must lie.

As `exact.level_ellipsoid`, but bounded by the objective alone, not by what the planes reach: all that is needed where
the rows of every plane are listed. Arrays lead with the problems (D,).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.problem import BoolArray, Norm

REWEIGHTINGS = 40
SMOOTHING_STEP, SMALLEST_SMOOTHING = 0.7, 1e-4
REFINEMENTS, VOLUME_STEPS = 2, 25
SLACK = 1e-9
THIN = 1e-7
TINY = 1e-300
LARGEST_CONDITION = 1e9


@dataclass(frozen=True)
class Objectives:
    """Norms of r = offset + matrix @ u, as `problem.Objective`: matrix (D, S, P), offset (D, S), weights (S,)."""

    matrix: ComplexArray
    offset: ComplexArray
    weights: FloatArray
    norm: Norm

    def __len__(self) -> int:
        return len(self.offset)

    def taken(self, which: NDArray[np.intp] | BoolArray) -> Objectives:
        """Some of them."""
        return Objectives(self.matrix[which], self.offset[which], self.weights, self.norm)

    def values(self, which: NDArray[np.intp], u: ComplexArray) -> FloatArray:
        """Objective (n,) of vector sums u (n, P) for the problems `which` (n,)."""
        r = self.offset[which].copy()
        for p in range(u.shape[1]):
            r += self.matrix[which, :, p] * u[:, p, None]
        if self.norm == "components":
            return np.asarray((self.weights * (np.abs(r.real) + np.abs(r.imag))).sum(axis=1), dtype=np.float64)
        size = self.weights * np.abs(r)
        if self.norm == "sum":
            return np.asarray(size.sum(axis=1), dtype=np.float64)
        if self.norm == "max":
            return np.asarray(size.max(axis=1), dtype=np.float64)
        return np.asarray(np.sqrt((size**2).mean(axis=1)), dtype=np.float64)


@dataclass(frozen=True)
class Systems:
    """Rows (D, G, k, n) and offsets (D, G, k) of the weighted residuals, their continuous optimum and a bound.

    solvable: (D,) where the rows tell all directions apart. optimum: (D, n). dual: (D, G, k) with floor (D,), or None
    where the residuals can be made zero and the floor is 0.
    """

    rows: FloatArray
    offsets: FloatArray
    norm: str
    solvable: BoolArray
    optimum: FloatArray
    dual: FloatArray | None
    floor: FloatArray

    def taken(self, which: NDArray[np.intp] | BoolArray) -> Systems:
        """Some of them."""
        dual = None if self.dual is None else self.dual[which]
        parts = (self.rows[which], self.offsets[which], self.norm, self.solvable[which], self.optimum[which])
        return Systems(*parts, dual, self.floor[which])


@dataclass(frozen=True)
class Ellipsoids:
    """(x - centre)^T form (x - centre) <= 1; centre (D, n), form (D, n, n). some: (D,) false where there is nothing."""

    centre: FloatArray
    form: FloatArray
    some: BoolArray


def systems_of(objectives: Objectives) -> Systems:
    """Weighted real rows and the continuous optimum of each problem."""
    rows, offsets = _rows(objectives)
    count, groups, k, n = rows.shape
    flat, shift = rows.reshape(count, groups * k, n), offsets.reshape(count, groups * k)
    normal = np.einsum("dri,drj->dij", flat, flat)
    solvable = np.linalg.cond(normal) < LARGEST_CONDITION
    normal[~solvable] = np.eye(n)
    if groups * k == n:
        optimum = -np.linalg.solve(normal, np.einsum("dri,dr->di", flat, shift)[..., None])[..., 0]
        return Systems(rows, offsets, objectives.norm, solvable, optimum, None, np.zeros(count))
    optimum, dual, floor = _continuous(objectives.norm, rows, offsets, solvable)
    return Systems(rows, offsets, objectives.norm, solvable, optimum, dual, floor)


def ellipsoids(systems: Systems, level: FloatArray) -> Ellipsoids:
    """Ellipsoids of all x whose objective is at most `level` (D,)."""
    rows = systems.rows
    count, groups, k, n = rows.shape
    if systems.dual is None:
        flat = rows.reshape(count, groups * k, n)
        scale = float(groups) if systems.norm == "max" else 1.0
        form = np.einsum("dri,drj->dij", flat, flat) / (scale * level**2 * (1.0 + SLACK))[:, None, None]
        form[~systems.solvable] = np.eye(n)
        return Ellipsoids(systems.optimum, form, np.ones(count, dtype=bool))
    longest = np.repeat(level[:, None], groups, axis=1)
    left = level - systems.floor + THIN * level
    some = left > 0.0
    left = np.maximum(left, TINY)
    found = Ellipsoids(systems.optimum, np.zeros((count, n, n)), some)
    for _ in range(REFINEMENTS):
        found = _smallest(*_quadratics(systems, systems.dual, level, left, longest), some)
        if systems.norm == "rms":
            break
        longest = np.maximum(np.minimum(longest, _longest(found, systems)), 1e-14 * level[:, None])
    return found


def _rows(objectives: Objectives) -> tuple[FloatArray, FloatArray]:
    a, o, w = objectives.matrix, objectives.offset, objectives.weights
    count, sensors, planes = a.shape
    rows = np.empty((count, sensors, 2, 2 * planes))
    rows[:, :, 0, 0::2], rows[:, :, 0, 1::2] = a.real, -a.imag
    rows[:, :, 1, 0::2], rows[:, :, 1, 1::2] = a.imag, a.real
    rows *= w[None, :, None, None]
    offsets = np.stack([w * o.real, w * o.imag], axis=2)
    if objectives.norm == "components":
        return rows.reshape(count, 2 * sensors, 1, -1), offsets.reshape(count, 2 * sensors, 1)
    if objectives.norm == "rms":
        return rows.reshape(count, 1, 2 * sensors, -1) / np.sqrt(sensors), offsets.reshape(count, 1, -1) / np.sqrt(
            sensors
        )
    return rows, offsets


def _continuous(
    norm: str, rows: FloatArray, offsets: FloatArray, solvable: BoolArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Minimiser (D, n), dual vectors (D, G, k) that no movement can exploit, and the bounds (D,) they give."""
    count, groups, k, n = rows.shape
    flat = rows.reshape(count, groups * k, n)
    weight = np.full((count, groups), 1.0 / groups)
    smoothing = 1.0
    best_value, best_x = np.full(count, np.inf), np.zeros((count, n))
    dual, floor = np.zeros_like(offsets), np.zeros(count)
    across = np.zeros((count, n, n))
    across[:] = np.linalg.pinv(np.einsum("dri,drj->dij", flat, flat))
    for step in range(1 if norm == "rms" else REWEIGHTINGS):
        x = _least_squares(weight, rows, offsets, solvable)
        r = np.einsum("dgkn,dn->dgk", rows, x) + offsets
        length = np.sqrt((r**2).sum(axis=2))
        largest = np.maximum(length.max(axis=1), TINY)
        if norm == "max":
            value = largest
            y = weight[:, :, None] * r / np.maximum(np.sqrt((weight * length**2).sum(axis=1)), TINY)[:, None, None]
            weight = weight * np.maximum(length / largest[:, None], TINY)
            weight /= weight.sum(axis=1, keepdims=True)
        elif norm == "rms":
            value, y = largest, r / largest[:, None, None]
        else:
            value = length.sum(axis=1)
            smoothing = max(SMOOTHING_STEP * smoothing, SMALLEST_SMOOTHING)
            weight = 1.0 / np.sqrt(length**2 + (smoothing * largest[:, None]) ** 2)
            y = weight[:, :, None] * r
        better = value < best_value
        best_value, best_x = np.where(better, value, best_value), np.where(better[:, None], x, best_x)
        if step % 5 == 4 or norm == "rms":
            fixed = _stationary(y, flat, across, norm)
            bound = (fixed * offsets).sum(axis=(1, 2))
            higher = bound > floor
            floor, dual = np.where(higher, bound, floor), np.where(higher[:, None, None], fixed, dual)
    return best_x, dual, floor


def _least_squares(weight: FloatArray, rows: FloatArray, offsets: FloatArray, solvable: BoolArray) -> FloatArray:
    weighted = rows * weight[:, :, None, None]
    normal = np.einsum("dgki,dgkj->dij", weighted, rows, optimize=True)
    normal[~solvable] = np.eye(rows.shape[3])
    gradient = np.einsum("dgki,dgk->di", weighted, offsets, optimize=True)
    return np.asarray(-np.linalg.solve(normal, gradient[..., None])[..., 0], dtype=np.float64)


def _stationary(y: FloatArray, flat: FloatArray, across: FloatArray, norm: str) -> FloatArray:
    """Nearest y with C^T y = 0, shrunk to where the norm's dual allows it: it bounds the objective everywhere."""
    whole = y.reshape(len(y), -1)
    moved = np.einsum("dij,dj->di", across, np.einsum("drn,dr->dn", flat, whole))
    nearest = (whole - np.einsum("drn,dn->dr", flat, moved)).reshape(y.shape)
    size = np.sqrt((nearest**2).sum(axis=2))
    allowed = size.sum(axis=1) if norm == "max" else size.max(axis=1)
    return np.asarray(nearest / np.maximum(allowed, 1.0)[:, None, None] * (1.0 - SLACK), dtype=np.float64)


def _quadratics(
    systems: Systems, dual: FloatArray, level: FloatArray, left: FloatArray, longest: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quadratics x^T G x + 2 h x + e <= 1 (D, m, ..) that hold for every x up to the level."""
    rows, offsets = systems.rows, systems.offsets
    G = np.einsum("dgki,dgkj->dgij", rows, rows, optimize=True)
    h = np.einsum("dgki,dgk->dgi", rows, offsets, optimize=True)
    e = (offsets**2).sum(axis=2)
    single = 1.0 / longest**2
    parts = [(G * single[:, :, None, None], h * single[:, :, None], e * single)]
    if systems.norm in ("sum", "components"):
        flat = 1.0 / (longest * level[:, None])
        parts.append(_summed(G, h, e, flat))
    size = np.minimum(np.sqrt((dual**2).sum(axis=2)), 1.0)
    direction = dual / np.maximum(np.sqrt((dual**2).sum(axis=2)), TINY)[:, :, None]
    along_rows = np.einsum("dgk,dgkn->dgn", direction, rows, optimize=True)
    along_offset = (direction * offsets).sum(axis=2)
    turned = size / (2.0 * longest * left[:, None])
    away = _summed(
        G - along_rows[..., :, None] * along_rows[..., None, :],
        h - along_rows * along_offset[..., None],
        e - along_offset**2,
        turned,
    )
    if systems.norm != "max":
        rest = _summed(G, h, e, (1.0 - size) / (longest * left[:, None]))
        away = (away[0] + rest[0], away[1] + rest[1], away[2] + rest[2])
    parts.append(away)
    return tuple(np.concatenate([part[i] for part in parts], axis=1) for i in range(3))  # type: ignore[return-value]


def _summed(
    G: FloatArray, h: FloatArray, e: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    return (
        np.einsum("dg,dgij->dij", weight, G)[:, None],
        np.einsum("dg,dgi->di", weight, h)[:, None],
        (weight * e).sum(axis=1)[:, None],
    )


def _smallest(G: FloatArray, h: FloatArray, e: FloatArray, some: BoolArray) -> Ellipsoids:
    """Convex combination of small volume for each problem (Silvey, Titterington & Torsney 1978)."""
    count, many, n, _ = G.shape
    share = np.full((count, many), 1.0 / many)
    for _ in range(VOLUME_STEPS):
        form, inverse, centre = _combined(G, h, share)
        at = np.einsum("di,dmij,dj->dm", centre, G, centre, optimize=True)
        at += 2.0 * np.einsum("dmi,di->dm", h, centre) + e
        room = 1.0 + SLACK - (share * at).sum(axis=1)
        some = some & (room > 0.0)
        growth = at + np.maximum(room, 0.0)[:, None] / n * np.einsum("dmij,dji->dm", G, inverse)
        grown = share * np.maximum(growth, 0.0)
        total = grown.sum(axis=1, keepdims=True)
        share = np.where(total > TINY, grown / np.maximum(total, TINY), share)
    form, _, centre = _combined(G, h, share)
    at = np.einsum("di,dmij,dj->dm", centre, G, centre, optimize=True)
    at += 2.0 * np.einsum("dmi,di->dm", h, centre) + e
    room = 1.0 + SLACK - (share * at).sum(axis=1)
    some = some & (room > 0.0)
    return Ellipsoids(centre, form / np.maximum(room, TINY)[:, None, None], some)


def _combined(G: FloatArray, h: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    form = np.einsum("dm,dmij->dij", share, G)
    inverse = np.linalg.inv(form)
    centre = -np.einsum("dij,dm,dmj->di", inverse, share, h, optimize=True)
    return form, inverse, centre


def _longest(found: Ellipsoids, systems: Systems) -> FloatArray:
    """Greatest group lengths (D, G) within the ellipsoids."""
    middle = np.sqrt(((np.einsum("dgkn,dn->dgk", systems.rows, found.centre) + systems.offsets) ** 2).sum(axis=2))
    inverse = np.linalg.inv(found.form)
    spread = np.einsum("dgin,dnm,dgjm->dgij", systems.rows, inverse, systems.rows, optimize=True)
    return np.asarray(middle + np.sqrt(np.maximum(np.linalg.eigvalsh(spread)[..., -1], 0.0)), dtype=np.float64)
