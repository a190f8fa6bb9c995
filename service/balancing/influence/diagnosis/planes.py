"""Findings about correction planes: seen too little, too alike, bucking, or lost in the scatter."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from service.balancing.influence.corrections import Correction, usable
from service.balancing.influence.diagnosis.findings import Finding
from service.balancing.influence.fit import KNOWN_SCATTER, InfluenceFit, RunSet
from service.balancing.influence.uncertainty import f_quantile
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.messages import Message, Quantity

# A coefficient less than this many standard deviations long is easily wrong by 20 % or 11 degrees.
_SEEN = 5.0
# Acoem, how to balance: a trial mass should change the amplitude by 30 % or the phase by 30 degrees. Either moves the
# vector by 30 % at least; less of both together may still move it by more, and is as good.
_CHANGE = 0.3
DEPENDENT = 0.2
"""Significance at or below which a plane counts as dependent (Darlow 1987; hsbalance tools.ill_condition)."""
# Damping is offered where it saves this share of the mass and costs this share of the vibration as found, at most.
_SAVED = 0.5
_COST = 0.05
# A rotor that needs nothing is told so but for one chance in fifty. Where the scatter is stated, the quantile is
# higher: such a scatter is itself estimated, from eight readings to a fifth, and its tails are longer than normal ones.
_IN_NOISE = 0.995
_DAMPINGS = np.array([0.02, 0.05, 0.1, 0.2, 0.3])


def examine(
    runs: RunSet, fit: InfluenceFit, correction: Correction | None, weights: FloatArray | None
) -> list[Finding]:
    """Examine what the trial masses did, whether planes act alike, and whether the correction means anything."""
    A, b = fit.influence, fit.initial
    if weights is not None or np.isnan(b).any():
        used, w = usable(fit, weights)
        A, b = A[used] * w[:, None], b[used] * w
    found = _unseen(runs, fit) + _dependent(A, fit)
    if correction is not None and len(A) >= A.shape[1]:
        found += _bucking(A, b) + _in_noise(fit, correction)
    return found


def significance(A: ComplexArray) -> FloatArray:
    """Darlow's significance (P,) of each column of A (S, P): the share of it that the planes chosen before leave.

    Columns are scaled to length 1 and taken in the order of what is left of them, the largest first (Gram-Schmidt with
    pivoting; Darlow, Balancing of High-Speed Machinery, 1989, chapter 6). 0 for a plane that moves nothing.
    """
    length = np.sqrt((A.real**2 + A.imag**2).sum(axis=0))
    rest = A / np.where(length > 0.0, length, 1.0)
    left = (length > 0.0).astype(np.float64)
    order = length.copy()
    factor = np.zeros(A.shape[1])
    for _ in range(A.shape[1]):
        # The strongest plane is kept; the others stand by what is new in them.
        best = int(np.argmax(order))
        factor[best] = left[best]
        order[best] = -1.0
        if left[best] <= 0.0:
            continue
        axis = rest[:, best] / left[best]
        rest = rest - np.outer(axis, axis.conj() @ rest)
        left = np.sqrt((rest.real**2 + rest.imag**2).sum(axis=0))
        order = np.where(order >= 0.0, left * length, order)
    return factor


def damping_trade_off(A: ComplexArray, b: ComplexArray, dampings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Length of the correction (D,), and root mean square of the weighted residual (D,), for each damping (D,).

    A: (S, P), b: (S,), weighted. damping: as `corrections.Wishes`.
    """
    left, singular, right = np.linalg.svd(A, full_matrices=False)
    part = left.conj().T @ b
    filters = singular / (singular**2 + (dampings[:, None] * singular[0]) ** 2)
    masses = -(filters * part) @ right.conj()
    residual = b + masses @ A.T
    mass: FloatArray = np.sqrt((np.abs(masses) ** 2).sum(axis=1))
    return mass, np.sqrt((np.abs(residual) ** 2).mean(axis=1))


def _unseen(runs: RunSet, fit: InfluenceFit) -> list[Finding]:
    spread = np.sqrt(np.maximum(fit.covariance.diagonal(axis1=1, axis2=2)[:, 1:].real, 0.0))
    known = (spread > 0.0) & (fit.scatter_dof > 2)[:, None]
    seen = np.where(known, np.abs(fit.influence) / np.where(known, spread, 1.0), -1.0).max(axis=0)
    found = []
    for plane, ratio in enumerate(seen):
        if ratio >= _SEEN:
            continue
        change, turn, moved = _change(runs, plane)
        if ratio < 0.0 and not moved < _CHANGE:
            continue
        reasons = [Message("trial_response_small.scattered", times=ratio)] if ratio >= 0.0 else []
        if np.isfinite(change):
            degrees = Quantity(float(np.degrees(turn)), "deg")
            reasons.append(Message("trial_response_small.change", change=change, turn=degrees))
        else:
            reasons.append(Message("trial_response_small.not_alone"))
        told = Message("trial_response_small", plane=runs.labels.plane(plane), reasons=reasons)
        found.append(Finding(told, "warning", planes=(plane,)))
    return found


def _change(runs: RunSet, plane: int) -> tuple[float, float, float]:
    """Greatest change of amplitude (share), of phase, and of the vector (share) by this plane alone; nan if none."""
    others = np.delete(runs.masses, plane, axis=1)
    tolerance = 1e-9 * np.abs(runs.masses).max()
    change, turn, moved = float("nan"), float("nan"), float("nan")
    for a in range(len(runs.masses)):
        alike = (np.abs(others - others[a]) <= tolerance).all(axis=1)
        alike &= np.abs(runs.masses[:, plane] - runs.masses[a, plane]) > tolerance
        alike &= np.abs(runs.masses[:, plane]) >= np.abs(runs.masses[a, plane])
        base = runs.vibration[a]
        for k in np.flatnonzero(alike):
            ok = np.isfinite(base) & np.isfinite(runs.vibration[k]) & (base != 0.0)
            if not ok.any():
                continue
            ratio = runs.vibration[k][ok] / base[ok]
            change = np.fmax(change, np.abs(np.abs(ratio) - 1.0).max())
            turn = np.fmax(turn, np.abs(np.angle(ratio)).max())
            moved = np.fmax(moved, np.abs(ratio - 1.0).max())
    return float(change), float(turn), float(moved)


def _dependent(A: ComplexArray, fit: InfluenceFit) -> list[Finding]:
    # No column of length 1 is nearer to the others than the smallest singular value, 1 / condition at least.
    if A.shape[1] == 1 or (A is fit.influence and fit.condition < 1.0 / DEPENDENT):
        return []
    factor = significance(A)
    weak = [int(p) for p in np.flatnonzero(factor <= DEPENDENT)]
    if not weak:
        return []
    return [
        Finding(
            Message("planes_dependent", planes=map(fit.labels.plane, weak), significance=factor[weak].min()),
            "warning",
            planes=tuple(weak),
        )
    ]


def _bucking(A: ComplexArray, b: ComplexArray) -> list[Finding]:
    # The greatest damping shortens no part of the correction to less than 1 / (1 + (damping sigma_1 / sigma_P)^2).
    singular = np.linalg.svd(A, compute_uv=False)
    if A.shape[1] == 1 or _DAMPINGS[-1] * singular[0] < singular[-1]:
        return []
    mass, residual = damping_trade_off(A, b, np.concatenate([[0.0], _DAMPINGS]))
    before = float(np.sqrt((np.abs(b) ** 2).mean()))
    good = np.flatnonzero((mass <= (1.0 - _SAVED) * mass[0]) & (residual - residual[0] <= _COST * before))
    if len(good) == 0:
        return []
    k = int(good[0])
    return [
        Finding(
            Message(
                "planes_buck",
                damping=_DAMPINGS[k - 1],
                mass=mass[k] / mass[0],
                damped=residual[k] / before,
                undamped=residual[0] / before,
            ),
            "warning",
        )
    ]


def _in_noise(fit: InfluenceFit, correction: Correction) -> list[Finding]:
    """Find that the correction, or its part in a plane, might as well be none."""
    spread = correction.covariance
    # A plane held as it is has no scatter and nothing to say.
    planes = np.flatnonzero(spread.diagonal()[::2] > 0.0)
    if not np.isfinite(spread).all() or len(planes) == 0:
        return []
    dof = float(fit.scatter_dof[fit.scatter_dof > 0].min())
    masses = correction.masses[planes]
    limit = f_quantile(dof, _IN_NOISE if dof == KNOWN_SCATTER else 0.95)
    # A quadratic form is at least the square of the length over the trace, and a joint one at least each of its parts.
    least = np.abs(masses) ** 2 / spread.diagonal().reshape(-1, 2).sum(axis=1)[planes]
    # Where the scatter was stated the limit of all planes together is below that of one.
    joint = limit if dof == KNOWN_SCATTER else _hotelling(2 * len(masses), dof)
    if least.min() > 2.0 * limit and least.max() > 2.0 * len(masses) * joint:
        return []
    if len(planes) < len(correction.masses):
        kept = (2 * planes[:, None] + [0, 1]).ravel()
        spread = spread[np.ix_(kept, kept)]
    # The plane's own 2 x 2 block of the covariance of all.
    own = np.arange(len(planes))
    blocks = spread.reshape(len(planes), 2, len(planes), 2)[own, :, own, :]
    lost = [int(p) for p in planes[_mean_square(masses[:, None], blocks) <= limit]]
    whole = bool(_mean_square(masses, spread) <= _hotelling(2 * len(masses), dof))
    if not lost and not whole:
        return []
    if whole:
        return [Finding(Message("correction_in_noise"), "warning", planes=tuple(int(p) for p in planes))]
    told = Message("plane_correction_in_noise", planes=map(fit.labels.plane, lost))
    return [Finding(told, "info", planes=tuple(lost))]


def _mean_square(masses: ComplexArray, spread: FloatArray) -> FloatArray:
    """Mean square, over their 2P components, of masses (..., P) in units of their scatter (..., 2P, 2P)."""
    flat = np.stack([masses.real, masses.imag], axis=-1).reshape(*masses.shape[:-1], -1)
    solved = np.linalg.solve(spread, flat[..., None])[..., 0]
    return np.asarray((flat * solved).sum(axis=-1) / flat.shape[-1])


@lru_cache(maxsize=64)
def _hotelling(components: int, dof: float) -> float:
    """98 % quantile of F(components, dof), and `_IN_NOISE` of it where the scatter was stated."""
    from scipy.special import chdtri, fdtri

    if dof == KNOWN_SCATTER:
        return float(chdtri(components, 1.0 - _IN_NOISE)) / components
    return float(fdtri(components, dof, 0.98))
