"""Smallest greatest residual, and least squares, under limits of mass: one convex program, certified by its dual.

    minimise t   subject to   sum over s in group g of |b_s + A_s u|^2 <= t,   |u_p| <= limit_p

Each row a group of its own is minimax; all rows in one group is least squares. For multipliers lam >= 0 (sum 1) and
mu >= 0 the Lagrangian is quadratic in u, so its minimum

    min_u  sum_s lam_g(s) |b_s + A_s u|^2 + sum_p mu_p (|u_p|^2 - limit_p^2)

is one least-squares solution away, and no admissible u does better. Mehrotra's predictor-corrector interior point
method (SIAM J. Optim. 2, 1992) finds u and the multipliers together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray

_MAX_STEPS = 60
_GAP = 1e-10
# How near the boundary a step may end.
_SHY = 0.99


@dataclass(frozen=True)
class MinimaxSolution:
    """masses: (P,) complex. value: root of the greatest group sum. lower_bound: no admissible masses leave less.

    multipliers: (G,) each group's share in the certificate, sum 1; near zero where the group does not bind.
    """

    masses: ComplexArray
    value: float
    lower_bound: float
    multipliers: FloatArray


def solve_grouped(A: ComplexArray, b: ComplexArray, groups: IntArray, limits: FloatArray) -> MinimaxSolution:
    """Solve the program above for A (N, P), b (N,), groups (N,) numbered from 0, limits (P,) > 0, inf for none.

    The columns of A must be independent wherever limits do not bound their masses.
    """
    count = int(groups.max()) + 1
    length = np.sqrt((np.abs(A) ** 2).sum(axis=0))
    length[length == 0.0] = 1.0
    A = A / length
    limits = limits * length
    start = -np.linalg.lstsq(A, b, rcond=None)[0]
    start = start * np.minimum(1.0, 0.9 * limits / np.maximum(np.abs(start), 1e-300))
    residual: ComplexArray = b + A @ start
    size = float(np.sqrt(_sums(residual, groups, count).max()))
    if size <= 1e-13 * float(np.abs(b).max(initial=0.0)):
        return MinimaxSolution(start / length, size, 0.0, np.full(count, 1.0 / count))
    # A mass that its limit keeps small is counted in limits, so that every slope is of order 1.
    unit = size * np.minimum(1.0, limits / size)
    problem = _Problem(A * (unit / size), residual / size, np.asarray(start / unit), groups, count, limits / unit)
    offset, lam, mu = _interior_point(problem)
    value = size * float(np.sqrt(_sums(problem.b + problem.A @ offset, groups, count).max()))
    bound = size * _certificate(problem, lam, mu)
    return MinimaxSolution((start + unit * offset) / length, value, min(value, bound), lam)


@dataclass(frozen=True)
class _Problem:
    """The program in the scaled offset w from `start`: residual b + A w, masses start + w."""

    A: ComplexArray
    b: ComplexArray
    start: ComplexArray
    groups: IntArray
    count: int
    limits: FloatArray


def _sums(residual: ComplexArray, groups: IntArray, count: int) -> FloatArray:
    return np.bincount(groups, residual.real**2 + residual.imag**2, count).astype(np.float64)


def _real(vector: ComplexArray) -> FloatArray:
    """(..., P) complex as (..., 2P): real parts, then imaginary parts."""
    return np.concatenate([vector.real, vector.imag], axis=-1)


def _interior_point(problem: _Problem) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Offset w (P,), multipliers of groups (G,) summing to 1, and of limits (P,) with zeros where there is none."""
    A, count, planes = problem.A, problem.count, len(problem.start)
    limited = np.flatnonzero(np.isfinite(problem.limits))
    limits, rows = problem.limits[limited], count + np.arange(len(limited))
    member = np.zeros((count, len(problem.groups)))
    member[problem.groups, np.arange(len(problem.groups))] = 1.0

    H = np.zeros((2 * planes + 1, 2 * planes + 1))
    J = np.zeros((count + len(limited), 2 * planes + 1))
    J[:count, -1] = -1.0
    w, t = np.zeros(planes, dtype=np.complex128), 1.5
    f = np.empty(count + len(limited))
    slack, multipliers = np.full(len(f), -1.0), np.ones(len(f)) / count
    for step_number in range(_MAX_STEPS):
        residual, filled = problem.b + A @ w, (problem.start + w)[limited] / limits
        f[:count] = member @ (residual.real**2 + residual.imag**2) - t
        f[count:] = filled.real**2 + filled.imag**2 - 1.0
        if step_number == 0:
            slack = -f
        J[:count, :-1] = 2.0 * (member @ _real(A.conj() * residual[:, None]))
        J[rows, limited], J[rows, planes + limited] = 2.0 * filled.real / limits, 2.0 * filled.imag / limits
        dual, primal = multipliers @ J, f + slack
        dual[-1] += 1.0
        gap = float(slack @ multipliers)
        if gap < _GAP * max(t, 1e-12) and max(np.abs(dual).max(), np.abs(primal).max()) < 1e-8:
            break
        curvature = (A.conj().T * (multipliers[:count] @ member)) @ A
        curvature[limited, limited] += multipliers[count:] / limits**2
        H[:planes, :planes] = H[planes:-1, planes:-1] = 2.0 * curvature.real
        H[planes:-1, :planes] = 2.0 * curvature.imag
        H[:planes, planes:-1] = -H[planes:-1, :planes]
        system = H + (J.T * (multipliers / slack)) @ J
        try:
            step, ds, dm = _newton(system, J, slack, multipliers, dual, primal, -slack * multipliers)
        except np.linalg.LinAlgError:
            break  # nothing left to gain in double precision
        reach = min(_reach(slack, ds), _reach(multipliers, dm))
        after = float((slack + reach * ds) @ (multipliers + reach * dm))
        # Never ahead of the slopes: products far below the aim leave the next step nothing to turn on.
        target = max((after / gap) ** 3 * gap, 0.1 * _GAP * max(t, 1e-12)) / len(f)
        step, ds, dm = _newton(system, J, slack, multipliers, dual, primal, target - slack * multipliers - ds * dm)
        size = min(1.0, _SHY * min(_reach(slack, ds, 2.0), _reach(multipliers, dm, 2.0)))
        w = w + size * (step[:planes] + 1j * step[planes:-1])
        t += size * float(step[-1])
        slack, multipliers = slack + size * ds, multipliers + size * dm
    mu = np.zeros(planes)
    mu[limited] = multipliers[count:] / limits**2
    total = multipliers[:count].sum()
    # The last iterate may pass a limit by rounding.
    masses = problem.start + w
    masses *= np.minimum(1.0, problem.limits / np.maximum(np.abs(masses), 1e-300))
    return masses - problem.start, multipliers[:count] / total, mu / total


def _newton(
    system: FloatArray,
    J: FloatArray,
    slack: FloatArray,
    multipliers: FloatArray,
    dual: FloatArray,
    primal: FloatArray,
    centring: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Solve for the steps of the point, of the slack and of the multipliers."""
    step = np.asarray(
        np.linalg.solve(system, -dual - ((centring + multipliers * primal) / slack) @ J), dtype=np.float64
    )
    ds = -primal - J @ step
    return step, ds, (centring - multipliers * ds) / slack


def _reach(values: FloatArray, change: FloatArray, most: float = 1.0) -> float:
    """How much of the change keeps the values positive, at most `most`."""
    falling = change < 0.0
    return min(most, float((-values[falling] / change[falling]).min(initial=np.inf)))


def _certificate(problem: _Problem, lam: FloatArray, mu: FloatArray) -> float:
    """Lower bound that lam (G,), sum 1, and mu (P,) prove, in the scaled problem.

    The residual of the stacked least squares is what remains outside the span of all columns, dependent or not, so
    rounding can only lower the bound.
    """
    root, price = np.sqrt(lam)[problem.groups], np.sqrt(mu)
    stacked = np.concatenate([root[:, None] * problem.A, np.diag(price).astype(np.complex128)])
    right = np.concatenate([root * problem.b, price * problem.start])
    Q = np.linalg.qr(stacked)[0]
    outside = right - Q @ (Q.conj().T @ right)
    priced = float((mu * np.where(mu > 0.0, problem.limits, 0.0) ** 2).sum())
    return float(np.sqrt(max(0.0, float(np.vdot(outside, outside).real) - priced)))
