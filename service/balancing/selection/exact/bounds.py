"""Lower bound of every selection: the continuous optimum of the objective over what the planes can reach.

The vector sums of the planes are written as x = (Re u_1, Im u_1, Re u_2, ...), and the weighted residuals as real rows
C x + d in groups g (a sensor's two components; one component; for `rms` all of them). Every norm is then a sum, a
maximum or a root mean square of group lengths |C_g x + d_g|.

With any dual vector y, |y_g| <= 1 in the norm's dual, Z(x) >= y.(C x + d), whose least value over what the planes can
reach is the lower bound D.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import cast

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.exact.reachable_set import Reach, reach_of
from service.balancing.selection.problem import Objective, SelectionProblem

WELL_CONDITIONED = 1e9
REWEIGHTINGS = 120
BETWEEN_STOPS = 24
"""Reweightings between two moments at which to stop: some ten milliseconds."""
SMOOTHING_STEP = 0.8
SMALLEST_SMOOTHING = 1e-7
SETTLED = 1e-6
TINY = 1e-300
SMALLEST_UNIT = 1e-200
"""Objectives below this are as good as nothing; it divides them all the same."""
NOTHING = 1e-30
"""Part of the greatest value below which a residual is none."""
MAX_CUTS = 60
SLACK = 1e-9
"""Relative: what rounding may add to a bound that holds exactly."""


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
    steps = bounding(problem)
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return cast(Bounds, done.value)


def bounding(problem: SelectionProblem) -> Generator[None, None, Bounds]:
    """Find the same as `bounds_of`; yields now and then, for a stop."""
    reach = reach_of(problem)
    rows, offsets = _weighted_rows(problem.objective)
    unit = max(_greatest(problem.objective.norm, rows, offsets, reach), SMALLEST_UNIT)
    rows, offsets = rows / unit, offsets / unit
    flat, shift = rows.reshape(-1, rows.shape[2]), offsets.ravel()
    square = problem.objective.matrix.shape[0] == problem.objective.matrix.shape[1]
    if square and np.linalg.cond(flat) < WELL_CONDITIONED:
        x = np.asarray(np.linalg.solve(flat, -shift), dtype=np.float64)
        if reach.contains(complex_of(x)):
            return Bounds(unit, 0.0, complex_of(x), reach, problem.objective.norm, rows, offsets, None)
    x, dual, floor = yield from _continuous_optimum(problem.objective.norm, rows, offsets, reach)
    return Bounds(unit, unit * floor, complex_of(x), reach, problem.objective.norm, rows, offsets, dual)


def _greatest(norm: str, rows: FloatArray, offsets: FloatArray, reach: Reach) -> float:
    """Value that no selection exceeds."""
    longest = np.linalg.norm(rows @ real_of(reach.centre) + offsets, axis=1)
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
) -> Generator[None, None, tuple[FloatArray, FloatArray, float]]:
    """Minimiser x, dual vector y (groups, k) and its bound, by reweighted least squares within the polygons."""
    weight = np.full(len(rows), 1.0 / len(rows))
    best = (np.inf, np.zeros(rows.shape[2]))
    dual, floor = np.zeros(offsets.shape), 0.0
    smoothing = 1.0
    cuts: list[FloatArray] = []
    for step in range(REWEIGHTINGS):
        if step and step % BETWEEN_STOPS == 0:
            yield
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
            cuts = [*cuts[-MAX_CUTS:], outside]
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
    least = reach.shared.least(complex_of(g / size))
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
    return y, float((y * offsets).sum() + reach.least_together(complex_of(g)))


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
    if reach.contains(complex_of(x)) and (extra[:, :-1] @ x <= extra[:, -1]).all():
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
    multipliers = _nonnegative(system, goal)
    missed = system @ multipliers - goal
    v = -missed[:-1] / missed[-1] * scale if missed[-1] < -1e-14 else np.zeros(2 * planes)
    nearest = np.linalg.solve(lower.T, v - np.linalg.solve(lower, gradient))
    return np.asarray(nearest, dtype=np.float64)


def _nonnegative(system: FloatArray, goal: FloatArray) -> FloatArray:
    from scipy.optimize import nnls  # takes longer to load than most problems to solve, and few reach a polygon's edge

    return np.asarray(nnls(system, goal)[0], dtype=np.float64)


def complex_of(x: FloatArray) -> ComplexArray:
    """Vector sums (P,) of x (2 P,)."""
    return np.asarray(x[0::2] + 1j * x[1::2], dtype=np.complex128)


def real_of(u: ComplexArray) -> FloatArray:
    """Coordinates (2 P,) of vector sums (P,)."""
    return np.stack([u.real, u.imag], axis=1).ravel()
