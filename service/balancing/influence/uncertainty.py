"""Uncertainty of a correction and of what it leads to: ellipses, inexact placement, intervals."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.influence.fit import InfluenceFit, Prediction, predict
from service.balancing.rotor.intervals import amplitude_interval
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.errors import NumericsError
from service.messages import Message


@dataclass(frozen=True)
class Ellipses:
    """Regions (P,) that hold the true correction of each plane with the confidence asked for.

    centre: (P,) complex g. major, minor: (P,) semi-axes in g. turn: (P,) radians, internal sense, of the major axis.
    All but the centre are nan where the covariance is.
    """

    centre: ComplexArray
    major: FloatArray
    minor: FloatArray
    turn: FloatArray


def ellipses(masses: ComplexArray, covariance: FloatArray, dof: float, confidence: float = 0.95) -> Ellipses:
    """Confidence ellipse of each plane: u' C^-1 u = 2 F(confidence; 2, dof), C the plane's 2 x 2 block.

    masses: (P,) complex g; covariance: (2P, 2P), as `Correction`. dof: degrees of freedom behind it, inf where stated.
    """
    blocks = np.array([covariance[2 * p : 2 * p + 2, 2 * p : 2 * p + 2] for p in range(len(masses))])
    known = np.isfinite(blocks).all(axis=(1, 2)) & (dof > 0)
    values, axes = np.linalg.eigh(np.where(known[:, None, None], blocks, 0.0))
    radius = np.sqrt(2.0 * f_quantile(dof, confidence)) * np.sqrt(np.maximum(values, 0.0))
    return Ellipses(
        centre=masses,
        major=np.where(known, radius[:, 1], np.nan),
        minor=np.where(known, radius[:, 0], np.nan),
        turn=np.where(known, np.arctan2(axes[:, 1, 1], axes[:, 0, 1]), np.nan),
    )


def mass_interval(
    masses: ComplexArray, covariance: FloatArray, dof: float, confidence: float = 0.95
) -> tuple[FloatArray, FloatArray]:
    """Interval (low, high), each (P,) g, of the size of each plane's correction; nan where unknown."""
    spread = np.sqrt(covariance.diagonal().reshape(-1, 2).mean(axis=1))
    return amplitude_interval(masses, spread, np.full(len(masses), dof), confidence)


def drawn_coefficients(
    fit: InfluenceFit, draws: int, rng: np.random.Generator
) -> tuple[ComplexArray, ComplexArray] | None:
    """Draw (v0, A) from the errors of a fit: initial (D, S) and influence (D, S, P) of the sensors it counts.

    Errors of a sensor are circular and normal; where its scatter comes from the residuals, each draw has a scatter of
    its own (Student). None where the covariance of a sensor that counts is unknown.
    """
    counted = np.isfinite(fit.initial)
    spread, dof = fit.covariance[counted], fit.scatter_dof[counted]
    if not np.isfinite(spread).all():
        return None
    values, axes = np.linalg.eigh(spread)
    root = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    shape = (draws, *spread.shape[:2])
    circular = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    known = np.isinf(dof)
    freedom = np.where(known, 1.0, dof)
    wider = np.where(known, 1.0, np.sqrt(freedom / rng.chisquare(np.broadcast_to(freedom, (draws, len(dof))))))
    error = wider[:, :, None] * np.einsum("sij,dsj->dsi", root, circular)
    return fit.initial[counted] + error[:, :, 0], fit.influence[counted] + error[:, :, 1:]


def resampled_covariance(
    fit: InfluenceFit, solve: Callable[[InfluenceFit], ComplexArray], rng: np.random.Generator, draws: int = 200
) -> FloatArray:
    """Covariance (2P, 2P) in g^2 of any correction, by solving `draws` fits drawn from the errors of this one.

    For corrections without a derivative: minimax, limited masses, pieces from a stock. solve: masses (P,) of a fit.
    Errors of a sensor are circular and normal. nan where the covariance of a sensor that counts is.
    """
    size = 2 * fit.influence.shape[1]
    if not np.isfinite(fit.covariance[np.isfinite(fit.initial)]).all():
        return np.full((size, size), np.nan)
    answers = np.empty((draws, size))
    for draw, errors in zip(answers, drawn_errors(fit, rng, draws), strict=True):
        masses = solve(replace(fit, initial=fit.initial + errors[:, 0], influence=fit.influence + errors[:, 1:]))
        draw[::2], draw[1::2] = masses.real, masses.imag
    return np.atleast_2d(np.cov(answers.T))


def blur(fit: InfluenceFit, weights: FloatArray | None = None) -> float:
    """How uncertain the coefficients are against what tells the planes apart: at 1 they might as well be dependent.

    Root mean square error of the weighted coefficients, their columns scaled to length 1, over their smallest singular
    value. weights: (S,); all 1 where None.
    """
    used = np.isfinite(fit.initial)
    w = np.ones(int(used.sum())) if weights is None else weights[used]
    A = fit.influence[used] * w[:, None]
    length = np.sqrt((np.abs(A) ** 2).sum(axis=0))
    variance = 2.0 * fit.covariance[used].diagonal(axis1=1, axis2=2)[:, 1:].real * (w**2)[:, None]
    if not np.isfinite(variance).all() or not length.all() or len(A) < A.shape[1]:
        return float("nan")
    smallest = float(np.linalg.svd(A / length, compute_uv=False)[-1])
    return float(np.sqrt((variance / length**2).sum(axis=0).max()) / max(smallest, 1e-300))


def simulated_moment(
    fit: InfluenceFit, weights: FloatArray | None, rng: np.random.Generator, draws: int = 400
) -> FloatArray:
    """Mean square (2P, 2P) in g^2 of the error of a least-squares correction, simulated.

    Where coefficients are uncertain a correction is not only scattered but drawn to one side: the noise makes planes
    look less alike than they are. What is simulated is therefore a rotor whose planes are as much more alike as the
    noise has them apart in the mean square, at least a third as far, seen through the errors of this fit (Efron and
    Tibshirani, An Introduction to the Bootstrap, 1993, chapter 10; deconvolution by subtracting the mean square of the
    noise: Fuller, Measurement Error Models, 1987, section 2.2).
    """
    used = np.isfinite(fit.initial)
    w = np.ones(int(used.sum())) if weights is None else weights[used]
    b = fit.initial[used] * w
    observed = fit.influence[used] * w[:, None]
    left, singular, right = np.linalg.svd(observed, full_matrices=False)
    # Mean square of A x for each right direction x that the errors alone would show.
    noise = 2.0 * np.einsum(
        "qa,sab,qb,s->q", right, fit.covariance[used][:, 1:, 1:].swapaxes(1, 2), right.conj(), w**2, optimize=True
    )
    nearer = np.sqrt(np.maximum(singular**2 - noise.real, (singular / 3.0) ** 2))
    A = (left * nearer) @ right
    truth = _solved(A, b)
    errors = drawn_errors(fit, rng, draws)[:, used] * w[:, None]
    off = _solved(A + errors[..., 1:], b + errors[..., 0]) - truth
    flat = np.stack([off.real, off.imag], axis=-1).reshape(draws, -1)
    return np.asarray(flat.T @ flat / draws)


def _solved(A: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Least-squares masses (..., P) for A (..., S, P) and b (..., S)."""
    turned = A.conj().swapaxes(-1, -2)
    return np.asarray(-np.linalg.solve(turned @ A, turned @ b[..., None])[..., 0])


def drawn_errors(fit: InfluenceFit, rng: np.random.Generator, draws: int) -> ComplexArray:
    """Errors (draws, S, P + 1) of (v0, row of A), drawn from the covariance of a fit; nan rows stay out of it.

    Errors of a sensor are circular and normal; what all sensors have together is drawn once for all.
    """
    counted = np.isfinite(fit.initial)
    spread = fit.covariance[counted]
    shared = fit.shared[:, counted] if len(fit.shared) else np.zeros((0, *spread.shape[:2]), dtype=np.complex128)
    values, axes = np.linalg.eigh(spread - np.einsum("jsa,jsb->sab", shared, shared.conj()))
    root = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    errors = np.zeros((draws, *fit.covariance.shape[:2]), dtype=np.complex128)
    own = (root @ _circular(rng, (draws, *spread.shape[:2]))[..., None])[..., 0]
    errors[:, counted] = own + np.einsum("dj,jsa->dsa", _circular(rng, (draws, len(shared))), shared)
    return errors


def _circular(rng: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
    return np.asarray(rng.standard_normal(shape) + 1j * rng.standard_normal(shape))


def f_quantile(dof: float, confidence: float) -> float:
    """Quantile of F(2, dof), in closed form; -ln(1 - confidence) where the scatter is known, nan for no freedom."""
    miss = 1.0 - confidence
    if math.isinf(dof):
        return float(-np.log(miss))
    return 0.5 * dof * (float(miss ** (-2.0 / dof)) - 1.0) if dof > 0 else float("nan")


def placement_covariance(
    pieces: ComplexArray, planes: IntArray, count: int, mass_sd: FloatArray | float, angle_sd: FloatArray | float
) -> FloatArray:
    """Covariance (2P, 2P) in g^2 of the vector sums of pieces that are not placed exactly as planned.

    pieces: (N,) complex g; planes: (N,) index of each; count: P. mass_sd: g; angle_sd: radians; of each piece or of
    all. A piece errs by mass_sd along its radius and by mass times angle_sd across it, on its own.
    """
    size = np.abs(pieces)
    along = np.where(size > 0.0, pieces / np.where(size > 0.0, size, 1.0), 1.0)
    radial, across = np.broadcast_to(mass_sd, size.shape) ** 2, (size * angle_sd) ** 2
    if (np.asarray(mass_sd) < 0.0).any() or (np.asarray(angle_sd) < 0.0).any():
        raise NumericsError(Message("numerics.tolerance_negative"), field="mass_sd")
    result = np.zeros((2 * count, 2 * count))
    c, s = along.real, along.imag
    np.add.at(result, (2 * planes, 2 * planes), radial * c**2 + across * s**2)
    np.add.at(result, (2 * planes + 1, 2 * planes + 1), radial * s**2 + across * c**2)
    np.add.at(result, (2 * planes, 2 * planes + 1), (radial - across) * c * s)
    np.add.at(result, (2 * planes + 1, 2 * planes), (radial - across) * c * s)
    return result


def predict_fitted(
    fit: InfluenceFit,
    masses: ComplexArray,
    placement: FloatArray,
    reading_scatter: FloatArray | float = 0.0,
    kept: ComplexArray | None = None,
) -> Prediction:
    """Predict the next reading with `masses` (P,) placed with covariance `placement` (2P, 2P) on the rotor.

    Adds to `predict` half the mean square of A du: the spread of the placed masses seen through the coefficients, as
    scatter per real component. kept: (J, S) what each of the fit's shared errors does to the vibration itself, 0 for
    those of pieces that come off: what a piece on the rotor errs by is in the runs that were measured with it, and is
    there again, so that it is not counted twice.
    """
    plain = predict(fit, masses, reading_scatter)
    rows = np.zeros((len(fit.initial), 2 * len(masses)), dtype=np.complex128)
    rows[:, ::2], rows[:, 1::2] = fit.influence, 1j * fit.influence
    with np.errstate(invalid="ignore"):  # rows that are nan stay nan
        added = 0.5 * ((rows @ placement) * rows.conj()).sum(axis=1).real
    if kept is not None and len(kept):
        seen = fit.shared @ np.concatenate([[1.0], masses])
        added = added + (np.abs(seen - kept) ** 2 - np.abs(seen) ** 2).sum(axis=0)
    with np.errstate(invalid="ignore"):
        variance = np.maximum(plain.scatter**2 + added, 0.0)
    return Prediction(plain.vibration, np.sqrt(variance), plain.dof)
