"""Uncertainty of a correction and of what it leads to: ellipses, inexact placement, intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.influence.fit import KNOWN_SCATTER, InfluenceFit, Prediction, predict
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


def ellipses(masses: ComplexArray, covariance: FloatArray, dof: int, confidence: float = 0.95) -> Ellipses:
    """Confidence ellipse of each plane: u' C^-1 u = 2 F(confidence; 2, dof), C the plane's 2 x 2 block.

    masses: (P,) complex g; covariance: (2P, 2P), as `Correction`. dof: degrees of freedom behind it.
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
    masses: ComplexArray, covariance: FloatArray, dof: int, confidence: float = 0.95
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
    known = dof == KNOWN_SCATTER
    freedom = np.where(known, 1, dof)
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
    counted = np.isfinite(fit.initial)
    spread = fit.covariance[counted]
    size = 2 * fit.influence.shape[1]
    if not np.isfinite(spread).all():
        return np.full((size, size), np.nan)
    values, axes = np.linalg.eigh(spread)
    root = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    answers = np.empty((draws, size))
    for draw in answers:
        error = (root @ _circular(rng, spread.shape[:2])[:, :, None])[:, :, 0]
        initial, influence = fit.initial.copy(), fit.influence.copy()
        initial[counted] += error[:, 0]
        influence[counted] += error[:, 1:]
        masses = solve(replace(fit, initial=initial, influence=influence))
        draw[::2], draw[1::2] = masses.real, masses.imag
    return np.atleast_2d(np.cov(answers.T))


def _circular(rng: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
    return np.asarray(rng.standard_normal(shape) + 1j * rng.standard_normal(shape))


def f_quantile(dof: int, confidence: float) -> float:
    """Quantile of F(2, dof), in closed form; -ln(1 - confidence) where the scatter is known, nan for no freedom."""
    miss = 1.0 - confidence
    if dof >= KNOWN_SCATTER:
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
    fit: InfluenceFit, masses: ComplexArray, placement: FloatArray, reading_scatter: FloatArray | float = 0.0
) -> Prediction:
    """Predict the next reading with `masses` (P,) placed with covariance `placement` (2P, 2P) on the rotor.

    Adds to `predict` half the mean square of A du: the spread of the placed masses seen through the coefficients, as
    scatter per real component.
    """
    plain = predict(fit, masses, reading_scatter)
    rows = np.zeros((len(fit.initial), 2 * len(masses)), dtype=np.complex128)
    rows[:, ::2], rows[:, 1::2] = fit.influence, 1j * fit.influence
    with np.errstate(invalid="ignore"):  # rows that are nan stay nan
        added = 0.5 * ((rows @ placement) * rows.conj()).sum(axis=1).real
    return Prediction(plain.vibration, np.sqrt(plain.scatter**2 + added), plain.dof)
