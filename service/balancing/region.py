"""Where every selection better than a given value must lie: a lower bound and an ellipsoid.

The vector sums of the planes are written as x = (Re u_1, Im u_1, Re u_2, ...), and the weighted residuals as real rows
C x + d in groups g (a sensor's two components; one component; for `rms` all of them). Every norm is then a sum, a
maximum or a root mean square of group lengths |C_g x + d_g|. For Z(x) <= z the following hold, each a quadratic q <= 1:

* every group's length is bounded by z (`sum`, `max`, `components`), their squares together by z^2 (`sum`, `rms`, ..);
* with any dual vector y, |y_g| <= 1 in the norm's dual, Z(x) >= y.(C x + d), whose least value over what the planes can
  reach is the lower bound D. What is left, z - D, bounds how far residuals turn away from y, and how far the planes
  retreat from their edge;
* no plane leaves the disc that it can reach.

Any convex combination of them is an ellipsoid that holds all better selections; the weights that make its volume small
follow from the multiplicative rule for minimum-volume ellipsoids (Silvey, Titterington & Torsney 1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from service.balancing.phasors import ComplexArray, FloatArray
from service.balancing.reach import Reach, reach_of
from service.balancing.selection import Objective, SelectionProblem

WELL_CONDITIONED = 1e9
REWEIGHTINGS = 120
SMOOTHING_STEP = 0.8
SMALLEST_SMOOTHING = 1e-7
SETTLED = 1e-6
TINY = 1e-300
SMALLEST_UNIT = 1e-200
"""Objectives below this are as good as nothing; it divides them all the same."""
NOTHING = 1e-30
"""Part of the greatest value below which a residual is none."""
THINNEST = 1e-14
"""Smallest level, as a part of the greatest value: a thinner one is lost in the rounding of the sums."""
MOST_CUTS = 60
VOLUME_STEPS = 80
VOLUME_SETTLED = 1e-3
SLACK = 1e-9
"""Relative: what rounding may add to a quadratic that holds exactly."""
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


@dataclass(frozen=True)
class Bounds:
    """Lower bound of a problem's objective, and what `ellipsoid` needs.

    unit: value that no selection exceeds; rows (G, k, n) and offsets (G, k) are weighted and divided by it, so that no
    square of them is lost however small or large the objective is. floor: of the objective itself.
    """

    unit: float
    floor: float
    continuous: ComplexArray
    reach: Reach
    norm: str
    rows: FloatArray
    offsets: FloatArray
    dual: FloatArray | None


def bounds_of(problem: SelectionProblem) -> Bounds:
    """Lower bound `floor` over everything that the planes can reach, and the `continuous` optimum (P,) in g."""
    reach = reach_of(problem)
    rows, offsets = _weighted_rows(problem.objective)
    unit = max(_greatest(problem.objective.norm, rows, offsets, reach), SMALLEST_UNIT)
    rows, offsets = rows / unit, offsets / unit
    flat, shift = rows.reshape(-1, rows.shape[2]), offsets.ravel()
    square = problem.objective.matrix.shape[0] == problem.objective.matrix.shape[1]
    if square and np.linalg.cond(flat) < WELL_CONDITIONED:
        x = np.asarray(np.linalg.solve(flat, -shift), dtype=np.float64)
        if reach.contains(_complex(x)):
            return Bounds(unit, 0.0, _complex(x), reach, problem.objective.norm, rows, offsets, None)
    x, dual, floor = _continuous_optimum(problem.objective.norm, rows, offsets, reach)
    return Bounds(unit, unit * floor, _complex(x), reach, problem.objective.norm, rows, offsets, dual)


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
        return Ellipsoid(_real(bounds.continuous), form)
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
    return Ellipsoid(_real(bounds.reach.centre), np.diag(np.repeat(1.0 / (len(radius) * radius**2), 2)))


def _greatest(norm: str, rows: FloatArray, offsets: FloatArray, reach: Reach) -> float:
    """Value that no selection exceeds."""
    longest = np.linalg.norm(rows @ _real(reach.centre) + offsets, axis=1)
    for p, radius in enumerate(reach.radius):
        longest = longest + radius * np.linalg.norm(rows[:, :, 2 * p : 2 * p + 2], ord=2, axis=(1, 2))
    return float(longest.max() if norm == "max" else longest.sum()) * (1.0 + SLACK)


def _weighted_rows(objective: Objective) -> tuple[FloatArray, FloatArray]:
    """Real rows (groups, k, 2 P) and offsets (groups, k), weights included."""
    a, o, w = objective.matrix, objective.offset, objective.weights
    sensors, planes = a.shape
    rows = np.empty((sensors, 2, 2 * planes))
    rows[:, 0, 0::2], rows[:, 0, 1::2] = a.real, -a.imag
    rows[:, 1, 0::2], rows[:, 1, 1::2] = a.imag, a.real
    rows = rows * w[:, None, None]
    offsets = np.stack([w * o.real, w * o.imag], axis=1)
    if objective.norm == "components":
        return rows.reshape(2 * sensors, 1, -1), offsets.reshape(2 * sensors, 1)
    if objective.norm == "rms":
        return rows.reshape(1, 2 * sensors, -1) / np.sqrt(sensors), offsets.reshape(1, -1) / np.sqrt(sensors)
    return rows, offsets


def _continuous_optimum(
    norm: str, rows: FloatArray, offsets: FloatArray, reach: Reach
) -> tuple[FloatArray, FloatArray, float]:
    """Minimiser x, dual vector y (groups, k) and its bound, by reweighted least squares within the polygons."""
    weight = np.full(len(rows), 1.0 / len(rows))
    best = (np.inf, np.zeros(rows.shape[2]))
    dual, floor = np.zeros(offsets.shape), 0.0
    smoothing = 1.0
    cuts: list[FloatArray] = []
    for step in range(REWEIGHTINGS):
        x = _least_squares(weight, rows, offsets, reach, cuts)
        r = rows @ x + offsets
        length = np.sqrt((r**2).sum(axis=1))
        longest = max(float(length.max()), NOTHING)
        if norm == "max":
            value, y = longest, weight[:, None] * r / max(float(np.sqrt(weight @ length**2)), TINY)
            weight = weight * np.maximum(length / longest, TINY)
            weight /= weight.sum()
        elif norm == "rms":
            value, y = longest, r / longest
        else:
            value = float(length.sum())
            smoothing = max(SMOOTHING_STEP * smoothing, SMALLEST_SMOOTHING)
            weight = 1.0 / np.sqrt(length**2 + (smoothing * longest) ** 2)
            y = weight[:, None] * r
        outside = _cut(x, y, rows, reach)
        if outside is not None:
            cuts = [*cuts[-MOST_CUTS:], outside]
            continue
        best = min(best, (value, x), key=lambda pair: pair[0])
        if step % 4 == 0 or norm == "rms" or cuts:
            dual, floor = max(
                (dual, floor), *(_rated(c, rows, offsets, reach) for c in (y, _stationary(y, rows))), key=lambda d: d[1]
            )
            if best[0] - floor <= SETTLED * best[0]:
                break
    return best[1], dual, floor


def _cut(x: FloatArray, y: FloatArray, rows: FloatArray, reach: Reach) -> FloatArray | None:
    """Half-space (n + 1,), normal.x <= last entry, of what the box can supply, where x lies outside it along y."""
    g = np.einsum("gk,gkn->n", y, rows)
    size = float(np.linalg.norm(g))
    if reach.shared is None or size <= TINY:
        return None
    least = reach.shared.least(_complex(g / size))
    if float(g @ x) / size >= least - 1e-9 * abs(least) - TINY:
        return None
    return np.append(-g / size, -least)


def _stationary(y: FloatArray, rows: FloatArray) -> FloatArray:
    """Nearest y that no movement of the planes can exploit, shrunk back to lengths of at most 1."""
    flat = rows.reshape(-1, rows.shape[2])
    solved = y.ravel() - flat @ np.linalg.lstsq(flat, y.ravel(), rcond=None)[0]
    nearest = solved.reshape(y.shape)
    was, now = np.sqrt((y**2).sum(axis=1)), np.sqrt((nearest**2).sum(axis=1))
    return np.asarray(nearest / max(1.0, float((now / np.maximum(was, TINY)).max())), dtype=np.float64)


def _rated(y: FloatArray, rows: FloatArray, offsets: FloatArray, reach: Reach) -> tuple[FloatArray, float]:
    """Return y and the least value of y.(C x + d) over the polygons: a lower bound whatever y is."""
    g = np.einsum("gk,gkn->n", y, rows)
    return y, float((y * offsets).sum() + reach.least_together(_complex(g)))


def _least_squares(
    weight: FloatArray, rows: FloatArray, offsets: FloatArray, reach: Reach, cuts: list[FloatArray]
) -> FloatArray:
    """Minimise sum_g weight_g |C_g x + d_g|^2 within the polygons (least distance, Lawson & Hanson 1974)."""
    scaled = (np.sqrt(weight)[:, None, None] * rows).reshape(-1, rows.shape[2])
    shift = (np.sqrt(weight)[:, None] * offsets).ravel()
    hessian = scaled.T @ scaled
    hessian += max(1e-12 * float(np.trace(hessian)), TINY) * np.eye(len(hessian))
    gradient = scaled.T @ shift
    x = np.asarray(np.linalg.solve(hessian, -gradient), dtype=np.float64)
    extra = np.array(cuts).reshape(len(cuts), len(x) + 1)
    if reach.contains(_complex(x)) and (extra[:, :-1] @ x <= extra[:, -1]).all():
        return x
    planes, edges = reach.support.shape
    normal = np.zeros((planes * edges, 2 * planes))
    for p in range(planes):
        normal[p * edges : (p + 1) * edges, 2 * p] = reach.normals.real
        normal[p * edges : (p + 1) * edges, 2 * p + 1] = reach.normals.imag
    normal = np.concatenate([normal, extra[:, :-1]])
    support = np.append(reach.support.ravel(), extra[:, -1])
    lower = np.linalg.cholesky(hessian)
    turned = np.linalg.solve(lower, normal.T).T
    g, h = -turned, -(support + turned @ np.linalg.solve(lower, gradient))
    goal = np.zeros(2 * planes + 1)
    goal[-1] = 1.0
    scale = max(float(np.abs(h).max()), 1e-300)
    system = np.vstack([g.T, h[None, :] / scale])
    multipliers, _ = nnls(system, goal)
    missed = system @ multipliers - goal
    v = -missed[:-1] / missed[-1] * scale if missed[-1] < -1e-14 else np.zeros(2 * planes)
    nearest = np.linalg.solve(lower.T, v - np.linalg.solve(lower, gradient))
    return np.asarray(nearest, dtype=np.float64)


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
    g = _complex(np.einsum("gk,gkn->n", dual, rows))
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
        systems.append((c, -c[0, 2 * p] * _real(bounds.reach.centre[p : p + 1])))
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


def _complex(x: FloatArray) -> ComplexArray:
    return np.asarray(x[0::2] + 1j * x[1::2], dtype=np.complex128)


def _real(u: ComplexArray) -> FloatArray:
    return np.stack([u.real, u.imag], axis=1).ravel()
