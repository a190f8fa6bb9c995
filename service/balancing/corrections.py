"""Continuous correction masses from a fit, with their first-order covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.balancing.fit import InfluenceFit, Prediction, predict
from service.balancing.labels import listed
from service.balancing.phasors import ComplexArray, FloatArray
from service.errors import NumericsError

# A direction of the correction seen by less than this share of the strongest is not seen at all.
_RANK_TOLERANCE = 1e-10


@dataclass(frozen=True)
class Correction:
    """Masses to have on the rotor as found, trial masses off.

    masses: (P,) complex g, internal sense, TOTAL. predicted: vibration with them. covariance: (2P, 2P) of
    (re 0, im 0, re 1, im 1, ...) in g^2, nan where the fit's is.
    """

    masses: ComplexArray
    predicted: Prediction
    covariance: FloatArray


def least_squares(fit: InfluenceFit, weights: FloatArray | None = None) -> Correction:
    """Masses u that minimise sum_s (weights_s |v0_s + A_s u|)^2.

    weights: (S,) >= 0, for example 1 / limit; equal where None, which asks for sensors of one unit. A sensor whose row
    is nan counts for nothing. Raises NumericsError where the rows left do not tell the planes apart.
    """
    used, w = usable(fit, weights)
    A, b = fit.influence[used] * w[:, None], fit.initial[used] * w
    masses = -_pseudo_inverse(A, fit) @ b
    return Correction(masses, predict(fit, masses), covariance(fit, masses, weights))


def usable(fit: InfluenceFit, weights: FloatArray | None) -> tuple[NDArray[np.bool_], FloatArray]:
    """Mask (S,) of the sensors that take part, and their weights."""
    sensors = len(fit.initial)
    w = np.ones(sensors) if weights is None else np.asarray(weights, dtype=np.float64)
    if w.shape != (sensors,) or not np.isfinite(w).all() or (w < 0.0).any() or not (w > 0.0).any():
        raise NumericsError(
            f"weights must be {sensors} finite numbers >= 0, not all zero; got {w.tolist()}",
            field="weights",
            value=w.tolist(),
            advice="State one positive limit per sensor.",
        )
    used = np.isfinite(fit.initial) & (w > 0.0)
    return used, w[used]


def covariance(fit: InfluenceFit, masses: ComplexArray, weights: FloatArray | None = None) -> FloatArray:
    """First-order covariance (2P, 2P) of the least-squares correction, in g^2.

    Differentiating A^H W (v0 + A u) = 0 gives du = -M^-1 sum_s w_s^2 (conj(A_s)^T (dv0_s + dA_s u) + conj(dA_s)^T r_s)
    with M = A^H W A and r the residual: a linear map of each sensor's error and one of its conjugate.
    """
    used, w = usable(fit, weights)
    A, C = fit.influence[used] * w[:, None], fit.covariance[used] * (w**2)[:, None, None]
    planes = len(masses)
    inverse = np.linalg.inv(A.conj().T @ A)
    residual = fit.initial[used] * w + A @ masses
    state = np.concatenate([[1.0 + 0j], masses])
    # (S, P, P + 1): the error and its conjugate, carried to the masses.
    direct = -(A.conj() @ inverse.T)[:, :, None] * state
    mirrored = np.zeros_like(direct)
    mirrored[:, :, 1:] = -residual[:, None, None] * inverse
    conjugate = C.conj()
    proper = (direct @ C @ direct.conj().swapaxes(1, 2) + mirrored @ conjugate @ mirrored.conj().swapaxes(1, 2)).sum(0)
    pseudo = (direct @ C @ mirrored.swapaxes(1, 2) + mirrored @ conjugate @ direct.swapaxes(1, 2)).sum(0)
    result = np.empty((planes, 2, planes, 2))
    result[:, 0, :, 0] = (proper + pseudo).real
    result[:, 1, :, 1] = (proper - pseudo).real
    result[:, 0, :, 1] = (pseudo - proper).imag
    result[:, 1, :, 0] = (pseudo + proper).imag
    return result.reshape(2 * planes, 2 * planes)


def _pseudo_inverse(A: ComplexArray, fit: InfluenceFit) -> ComplexArray:
    """Pseudo-inverse (P, S) of a matrix whose columns are independent; raises naming the planes that are not."""
    length = np.sqrt((np.abs(A) ** 2).sum(axis=0))
    dead = [int(plane) for plane in np.flatnonzero(length <= _RANK_TOLERANCE * length.max(initial=0.0))]
    if dead:
        raise NumericsError(
            f"masses in {listed(map(fit.labels.plane, dead))} move no sensor",
            code="planes_dependent",
            field="planes",
            value=dead,
            advice="Check that the trial mass was on the rotor, or correct in the other planes only.",
        )
    left, singular, right = np.linalg.svd(A / length, full_matrices=len(A) < A.shape[1])
    rank = int((singular > _RANK_TOLERANCE * singular[0]).sum())
    if rank == A.shape[1]:
        return np.asarray((right.conj().T / singular) @ left.conj().T / length[:, None])
    planes = [int(plane) for plane in np.flatnonzero(np.abs(right[rank:]).max(axis=0) > 1e-6)]
    names = listed(map(fit.labels.plane, planes))
    raise NumericsError(
        f"masses in {names} act alike on the {len(A)} sensors that count, so many corrections do equally well",
        code="planes_dependent",
        field="planes",
        value=planes,
        advice=f"Correct without {fit.labels.plane(planes[-1])}, or add a sensor that tells the planes apart.",
    )
