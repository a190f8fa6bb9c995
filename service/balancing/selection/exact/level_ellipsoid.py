"""Level ellipsoid: the region that holds every selection better than a given value.

In the coordinates and rows of `bounds`, the following hold for Z(x) <= z, each a quadratic q <= 1:

* every group's length is bounded by z (`sum`, `max`, `components`), their squares together by z^2 (`sum`, `rms`, ..);
* what is left of z over the lower bound, z - D, bounds how far residuals turn away from the dual vector y, and how far
  the planes retreat from their edge;
* no plane leaves the disc that it can reach.

Any convex combination of them is an ellipsoid that holds all better selections; the weights that make its volume small
follow from the multiplicative rule for minimum-volume ellipsoids (Silvey, Titterington & Torsney 1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import FloatArray
from service.balancing.selection.exact.bounds import SLACK, Bounds, complex_of, real_of

THINNEST = 1e-14
"""Smallest level, as a part of the greatest value: a thinner one is lost in the rounding of the sums."""
VOLUME_STEPS = 80
VOLUME_SETTLED = 1e-3
THIN = 1e-7
"""Least thickness of the layer between the bound and z, as a part of z: thinner ones are lost in rounding."""


@dataclass(frozen=True)
class Ellipsoid:
    """All x with (x - centre)^T form (x - centre) <= 1; centre (2 P,), form (2 P, 2 P), g and g^-2."""

    centre: FloatArray
    form: FloatArray


@dataclass(frozen=True)
class _Quadratics:
    """q_i(x) = x^T G_i x + 2 h_i x + e_i <= 1: G (m, n, n), h (m, n), e (m,)."""

    G: FloatArray
    h: FloatArray
    e: FloatArray


def ellipsoid(bounds: Bounds, z: float) -> Ellipsoid | None:
    """Ellipsoid of all x with Z(x) <= z; None where there is none."""
    if z < bounds.floor or z <= 0.0:
        return None
    if z >= bounds.unit:
        return _discs(bounds)
    z = max(z / bounds.unit, THINNEST)
    if bounds.dual is None:
        flat = bounds.rows.reshape(-1, bounds.rows.shape[2])
        scale = len(bounds.rows) if bounds.norm == "max" else 1.0
        form = flat.T @ flat / (scale * z**2 * (1.0 + SLACK))
        return Ellipsoid(real_of(bounds.continuous), form)
    try:
        return _tightened(bounds, bounds.dual, z)
    except np.linalg.LinAlgError:  # rounding has made the quadratics singular
        return _discs(bounds)


def _tightened(bounds: Bounds, dual: FloatArray, z: float) -> Ellipsoid | None:
    """Small ellipsoid, its own extent taken to bound the residuals and with them a smaller one."""
    longest = np.full(len(bounds.rows), z)
    found: Ellipsoid | None = None
    for _ in range(3):
        found = _smallest(_quadratics(bounds, dual, z, longest))
        if found is None or bounds.norm == "rms":
            return found
        longest = np.maximum(np.minimum(longest, _longest(found, bounds)), THINNEST * z)
    return found


def _discs(bounds: Bounds) -> Ellipsoid:
    """Ellipsoid of everything that the planes can reach."""
    radius = np.maximum(bounds.reach.radius, 1e-9)
    return Ellipsoid(real_of(bounds.reach.centre), np.diag(np.repeat(1.0 / (len(radius) * radius**2), 2)))


def _quadratics(bounds: Bounds, dual: FloatArray, z: float, longest: FloatArray) -> _Quadratics:
    """Every quadratic that holds for Z(x) <= z; `longest` (groups,) bounds the group lengths."""
    rows, offsets = bounds.rows, bounds.offsets
    systems: list[tuple[FloatArray, FloatArray]] = []
    for c, d, m in zip(rows, offsets, longest, strict=True):
        systems.append((c / m, d / m))
    if bounds.norm in ("sum", "components"):
        flat = np.sqrt(1.0 / (longest * z))[:, None, None] * rows
        systems.append((flat.reshape(-1, rows.shape[2]), (np.sqrt(1.0 / (longest * z))[:, None] * offsets).ravel()))
    left = z - bounds.floor / bounds.unit + THIN * z
    systems.append(_turned_away(bounds, dual, left, longest))
    g = complex_of(np.einsum("gk,gkn->n", dual, rows))
    least = bounds.reach.least(g)
    together = bounds.reach.least_together(g)
    if bounds.reach.shared is not None and np.abs(g) @ bounds.reach.radius > left:
        systems.append(
            (2.0 / left * np.einsum("gk,gkn->n", dual, rows)[None, :], np.array([-2.0 * together / left - 1.0]))
        )
    apart = left + together - float(least.sum())
    for p in range(len(g)):
        if abs(g[p]) * bounds.reach.radius[p] > apart:
            c = np.zeros((1, rows.shape[2]))
            c[0, 2 * p], c[0, 2 * p + 1] = 2.0 * g[p].real / apart, 2.0 * g[p].imag / apart
            systems.append((c, np.array([-2.0 * least[p] / apart - 1.0])))
        c = np.zeros((2, rows.shape[2]))
        c[0, 2 * p] = c[1, 2 * p + 1] = 1.0 / max(bounds.reach.radius[p], 1e-9)
        systems.append((c, -c[0, 2 * p] * real_of(bounds.reach.centre[p : p + 1])))
    return _Quadratics(
        G=np.stack([c.T @ c for c, _ in systems]),
        h=np.stack([c.T @ d for c, d in systems]),
        e=np.array([d @ d for _, d in systems]),
    )


def _turned_away(bounds: Bounds, dual: FloatArray, left: float, longest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Turn |r_g| - y_g.r_g <= left into rows and offsets of one quadratic, given |r_g| <= longest_g.

    |r| - y.r = (1 - |y|) |r| + |y| (|r| - e.r), e = y / |y|, and |r| - e.r >= |r - (e.r) e|^2 / (2 |r|).
    """
    size = np.minimum(np.sqrt((dual**2).sum(axis=1)), 1.0)
    direction = dual / np.maximum(np.sqrt((dual**2).sum(axis=1)), 1e-300)[:, None]
    across = np.eye(dual.shape[1])[None] - direction[:, :, None] * direction[:, None, :]
    turn = np.sqrt(size / (2.0 * longest * left))[:, None, None] * across
    parts = [turn @ bounds.rows], [np.einsum("gij,gj->gi", turn, bounds.offsets)]
    if bounds.norm != "max":
        whole = np.sqrt((1.0 - size) / (longest * left))
        parts[0].append(whole[:, None, None] * bounds.rows)
        parts[1].append(whole[:, None] * bounds.offsets)
    return (
        np.concatenate([c.reshape(-1, bounds.rows.shape[2]) for c in parts[0]]),
        np.concatenate([d.ravel() for d in parts[1]]),
    )


def _smallest(quadratics: _Quadratics) -> Ellipsoid | None:
    """Convex combination of the quadratics with a small volume; None where they exclude each other."""
    G, h, e = quadratics.G, quadratics.h, quadratics.e
    n = G.shape[1]
    share = np.full(len(G), 1.0 / len(G))
    for _ in range(VOLUME_STEPS):
        form = np.tensordot(share, G, 1)
        inverse = np.linalg.inv(form)
        centre = np.asarray(-inverse @ (share @ h), dtype=np.float64)
        at = np.einsum("i,mij,j->m", centre, G, centre) + 2.0 * h @ centre + e
        room = 1.0 + SLACK - float(share @ at)
        if room <= 0.0:
            return None
        growth = at + room / n * np.einsum("mij,ji->m", G, inverse)
        share = share * np.maximum(growth, 0.0)
        share /= share.sum()
        if np.abs(share * (growth - 1.0)).max() < VOLUME_SETTLED:
            break
    form = np.tensordot(share, G, 1)
    centre = np.asarray(-np.linalg.solve(form, share @ h), dtype=np.float64)
    room = 1.0 + SLACK - float(share @ (np.einsum("i,mij,j->m", centre, G, centre) + 2.0 * h @ centre + e))
    if not (np.isfinite(form).all() and np.isfinite(room)):
        raise np.linalg.LinAlgError
    return Ellipsoid(centre, form / room) if room > 0.0 else None


def _longest(found: Ellipsoid, bounds: Bounds) -> FloatArray:
    """Greatest group lengths (groups,) within the ellipsoid."""
    middle = np.sqrt(((bounds.rows @ found.centre + bounds.offsets) ** 2).sum(axis=1))
    spread = np.einsum("gin,nm,gjm->gij", bounds.rows, np.linalg.inv(found.form), bounds.rows)
    return np.asarray(middle + np.sqrt(np.linalg.eigvalsh(spread)[:, -1]), dtype=np.float64)
