"""Continuous correction masses from a fit, with their first-order covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.balancing.influence.fit import InfluenceFit, Prediction, predict
from service.balancing.influence.minimax import solve_grouped
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.errors import NumericsError
from service.messages import Message

# A direction of the correction seen by less than this share of the strongest is not seen at all.
_RANK_TOLERANCE = 1e-10


@dataclass(frozen=True)
class Correction:
    """Masses to have on the rotor as found, trial masses off.

    masses: (P,) complex g, internal sense, TOTAL. predicted: vibration with them. covariance: (2P, 2P) of
    (re 0, im 0, re 1, im 1, ...) in g^2; nan where the fit's is, and where a limit of mass or the greatest residual
    decides, since the answer then bends. objective: root of the sum of squares, or greatest, of the weighted
    residuals, vibration that parts mounted later will cause included. lower_bound: no admissible masses do better;
    equal to the objective where the solution is closed.
    """

    masses: ComplexArray
    predicted: Prediction
    covariance: FloatArray
    objective: float = float("nan")
    lower_bound: float = float("nan")


@dataclass(frozen=True)
class CorrectionOptions:
    """What a correction must respect; nothing by default.

    weights: (S,) >= 0, for example 1 / limit; equal where None, which asks for sensors of one unit. max_mass: (P,) g,
    inf where there is no limit. planes: indices that may be changed. held: (P,) complex g that the other planes carry.
    mounted_later: (P,) complex g, unbalance over radius of parts that come on after the check run: the rotor is to run
    well with them, so `predicted`, without them, shows the target unbalance. damping: share d of the greatest singular
    value of the weighted coefficients, for min sum |w r|^2 + (d sigma_1)^2 |u|^2.
    """

    weights: FloatArray | None = None
    max_mass: FloatArray | None = None
    planes: tuple[int, ...] | None = None
    held: ComplexArray | None = None
    mounted_later: ComplexArray | None = None
    damping: float = 0.0


def least_squares(
    fit: InfluenceFit, weights: FloatArray | None = None, wishes: CorrectionOptions | None = None
) -> Correction:
    """Masses u that minimise sum_s (weights_s |v0_s + A_s u|)^2, damped and limited as wished.

    A sensor whose row is nan counts for nothing. Raises NumericsError where the rows left do not tell the planes apart,
    and for wishes of the wrong shape or range.
    """
    problem = _problem(fit, weights, wishes or CorrectionOptions())
    A, b = problem.A, problem.b
    free, ridge = _unlimited(problem, fit)
    if (np.abs(free) <= problem.limits).all():
        residual = b + A @ free
        size = float(np.sqrt(np.vdot(residual, residual).real))
        return _correction(fit, problem, free, size, size, covariance(fit, problem, free, ridge))
    if ridge:
        A = np.concatenate([A, ridge * np.eye(len(free))])
        b = np.concatenate([b, np.zeros(len(free))])
    solution = solve_grouped(A, b, np.zeros(len(b), dtype=np.int64), problem.limits)
    return _correction(fit, problem, solution.masses, solution.value, solution.lower_bound)


def minimax(
    fit: InfluenceFit, weights: FloatArray | None = None, wishes: CorrectionOptions | None = None
) -> Correction:
    """Masses u that minimise max_s weights_s |v0_s + A_s u|, limited as wished; `lower_bound` certifies it.

    Raises NumericsError as `least_squares`, and where damping is wished: it belongs to least squares.
    """
    problem = _problem(fit, weights, wishes or CorrectionOptions())
    if problem.damping:
        raise NumericsError(
            Message("numerics.damping_with_minimax", damping=problem.damping), field="damping", value=problem.damping
        )
    _unlimited(problem, fit)
    groups = np.arange(len(problem.b))
    solution = solve_grouped(problem.A, problem.b, groups, problem.limits)
    return _correction(fit, problem, solution.masses, solution.value, solution.lower_bound)


@dataclass(frozen=True)
class _Problem:
    """Weighted rows of the sensors that count (N, Q), for the Q planes that may change.

    offset: (P,) what stands in the other planes, and the parts mounted later, as the changed planes see it.
    """

    A: ComplexArray
    b: ComplexArray
    used: NDArray[np.bool_]
    weights: FloatArray
    planes: IntArray
    held: ComplexArray
    later: ComplexArray
    limits: FloatArray
    damping: float


def _problem(fit: InfluenceFit, weights: FloatArray | None, wishes: CorrectionOptions) -> _Problem:
    used, w = usable(fit, wishes.weights if weights is None else weights)
    count = fit.influence.shape[1]
    later = _per_plane("mounted_later", wishes.mounted_later, count)
    held = _per_plane("held", wishes.held, count)
    planes = np.arange(count)
    if wishes.planes is not None:
        planes = np.array(sorted(set(wishes.planes)), dtype=np.int64)
    if len(planes) == 0 or planes[0] < 0 or planes[-1] >= count:
        raise NumericsError(
            Message("numerics.planes_unknown", planes=list(wishes.planes or ()), last=count - 1),
            field="planes",
            value=list(wishes.planes or ()),
        )
    held[planes] = 0.0
    limits = np.full(count, np.inf) if wishes.max_mass is None else np.asarray(wishes.max_mass, dtype=np.float64)
    if limits.shape != (count,) or not (limits > 0.0).all():
        raise NumericsError(
            Message("numerics.max_mass_not_positive", count=count, limits=limits.tolist()),
            field="max_mass",
            value=limits.tolist(),
        )
    if not 0.0 <= wishes.damping < np.inf:
        raise NumericsError(
            Message("numerics.damping_negative", damping=wishes.damping), field="damping", value=str(wishes.damping)
        )
    rows = fit.influence[used] * w[:, None]
    b = fit.initial[used] * w + rows @ (held + later)
    return _Problem(rows[:, planes], b, used, w, planes, held, later, limits[planes], wishes.damping)


def _per_plane(name: str, masses: ComplexArray | None, count: int) -> ComplexArray:
    if masses is None:
        return np.zeros(count, dtype=np.complex128)
    if masses.shape != (count,) or not np.isfinite(masses).all():
        raise NumericsError(
            Message("numerics.mass_vectors", name=name, count=count, masses=masses.tolist()), field=name
        )
    return masses.astype(np.complex128)


def _correction(
    fit: InfluenceFit,
    problem: _Problem,
    masses: ComplexArray,
    objective: float,
    lower_bound: float,
    spread: FloatArray | None = None,
) -> Correction:
    total = problem.held.copy()
    total[problem.planes] = masses
    if spread is None:
        spread = np.full((2 * len(total), 2 * len(total)), np.nan)
    return Correction(total, predict(fit, total), spread, objective, lower_bound)


def usable(fit: InfluenceFit, weights: FloatArray | None) -> tuple[NDArray[np.bool_], FloatArray]:
    """Mask (S,) of the sensors that take part, and their weights."""
    sensors = len(fit.initial)
    if weights is None:
        seen = np.isfinite(fit.initial)
        return seen, np.ones(int(seen.sum()))
    w = np.asarray(weights, dtype=np.float64)
    if w.shape != (sensors,) or not np.isfinite(w).all() or (w < 0.0).any() or not (w > 0.0).any():
        raise NumericsError(
            Message("numerics.weights_negative", count=sensors, weights=w.tolist()), field="weights", value=w.tolist()
        )
    used = np.isfinite(fit.initial) & (w > 0.0)
    return used, w[used]


def covariance(fit: InfluenceFit, problem: _Problem, masses: ComplexArray, ridge: float) -> FloatArray:
    """First-order covariance (2P, 2P) of the (damped) least-squares correction, in g^2; zero for planes held.

    Differentiating A^H W (v0 + A u) + ridge^2 u = 0 gives du = -M^-1 sum_s w_s^2 (conj(A_s)^T (dv0_s + dA_s u) +
    conj(dA_s)^T r_s), M = A^H W A + ridge^2 and r the residual: a linear map of each sensor's error and one of its
    conjugate.
    """
    A, w = problem.A, problem.weights
    planes, changed = fit.influence.shape[1], problem.planes
    count = len(changed)
    normal = A.conj().T @ A
    if ridge:
        normal += ridge**2 * np.eye(count)
    inverse = np.linalg.inv(normal)
    residual = problem.b + A @ masses
    state = np.ones(planes + 1, dtype=np.complex128)
    state[1:] = problem.held + problem.later
    state[1 + changed] += masses
    # (N, 2Q, P + 1): each sensor's error carried to the masses, then its conjugate to their conjugates.
    carry = np.zeros((len(A), 2 * count, planes + 1), dtype=np.complex128)
    carry[:, :count] = -(A.conj() @ inverse.T)[:, :, None] * state
    carry[:, count:, 1 + changed] = -residual.conj()[:, None, None] * inverse.conj()
    if ridge:
        # The ridge follows the greatest singular value, whose square changes by 2 sigma Re(l^H dA r).
        left, singular, right = np.linalg.svd(A, full_matrices=False)
        pulled = ridge**2 / singular[0] * (inverse @ masses)
        side = left[:, :1, None].conj() * right[0].conj()
        carry[:, :count, 1 + changed] -= side * pulled[:, None]
        carry[:, count:, 1 + changed] -= side * pulled.conj()[:, None]
    carry *= w[:, None, None]
    spread = (carry @ fit.covariance[problem.used] @ carry.conj().swapaxes(1, 2)).sum(axis=0)
    if len(fit.shared):
        # Errors of all sensors together add up before they are squared.
        each = (carry @ fit.shared[:, problem.used, :, None])[..., 0]
        whole = each.sum(axis=1)
        spread += whole.T @ whole.conj() - np.einsum("jsa,jsb->ab", each, each.conj())
    proper = spread[:count, :count] + spread[count:, count:].conj()
    pseudo = spread[:count, count:] + spread[:count, count:].T
    block = np.empty((count, 2, count, 2))
    block[:, 0, :, 0] = (proper + pseudo).real
    block[:, 1, :, 1] = (proper - pseudo).real
    block[:, 0, :, 1] = (pseudo - proper).imag
    block[:, 1, :, 0] = (pseudo + proper).imag
    if count == planes:
        return block.reshape(2 * count, 2 * count)
    result = np.zeros((planes, 2, planes, 2))
    parts = np.arange(2)
    result[np.ix_(changed, parts, changed, parts)] = block
    return result.reshape(2 * planes, 2 * planes)


def _unlimited(problem: _Problem, fit: InfluenceFit) -> tuple[ComplexArray, float]:
    """Damped least squares without limits, and the ridge; raises naming planes that the sensors do not tell apart."""
    A, planes, name = problem.A, problem.planes, fit.labels.plane
    length = np.sqrt((A.real**2 + A.imag**2).sum(axis=0))
    unseen = length <= _RANK_TOLERANCE * length.max(initial=0.0)
    if unseen.any():
        dead = [int(plane) for plane in planes[unseen]]
        raise NumericsError(
            Message("planes_dependent.without_effect", planes=map(name, dead)), field="planes", value=dead
        )
    left, singular, right = np.linalg.svd(A / length, full_matrices=len(A) < A.shape[1])
    rank = int((singular > _RANK_TOLERANCE * singular[0]).sum())
    if rank < A.shape[1]:
        alike = [int(plane) for plane in planes[np.abs(right[rank:]).max(axis=0) > 1e-6]]
        raise NumericsError(
            Message("planes_dependent.alike", planes=map(name, alike), sensors=len(A), plane=name(alike[-1])),
            field="planes",
            value=alike,
        )
    if not problem.damping:
        return -(right.conj().T @ (left.conj().T @ problem.b / singular)) / length, 0.0
    left, singular, right = np.linalg.svd(A, full_matrices=False)
    ridge = problem.damping * float(singular[0])
    filtered = singular / (singular**2 + ridge**2) * (left.conj().T @ problem.b)
    return -(right.conj().T @ filtered), ridge
