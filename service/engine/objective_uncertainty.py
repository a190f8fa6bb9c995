"""Uncertainty of an objective: differences below the measurement's scatter are not worth a search."""

from __future__ import annotations

import numpy as np

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.fit import predict
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.problem import Objective
from service.engine import mapping
from service.engine.influence_fits import FittedModel
from service.model.plan import ObjectiveName


def objective_scatter(
    objective: Objective, name: ObjectiveName, fitted: FittedModel | None, target: ComplexArray
) -> float:
    """Standard deviation of the objective near its optimum `target` (P,), first order; 0 where it cannot be known."""
    if fitted is None:
        return 0.0
    if name == "residual_vibration":
        used = np.isfinite(fitted.fit.initial)
        variance = 2.0 * predict(fitted.fit, target).scatter[used] ** 2
    else:
        weights = 1.0 / mapping.scales(fitted.rows) if fitted.rows else None
        variance = _through(objective.matrix, least_squares(fitted.fit, weights).covariance)
    if not np.isfinite(variance).all():
        return 0.0
    spread = objective.weights * np.sqrt(variance)
    if objective.norm == "max":
        return float(spread.max())
    mean_or_sum = np.mean if objective.norm == "rms" else np.sum
    return float(np.sqrt(mean_or_sum(spread**2)))


def _through(matrix: ComplexArray, covariance: FloatArray) -> FloatArray:
    """Variance (S,), both components together, of matrix @ t for masses t with covariance (2P, 2P)."""
    real = np.empty((2 * len(matrix), covariance.shape[0]))
    real[0::2, 0::2], real[0::2, 1::2] = matrix.real, -matrix.imag
    real[1::2, 0::2], real[1::2, 1::2] = matrix.imag, matrix.real
    return np.asarray(np.diag(real @ covariance @ real.T).reshape(-1, 2).sum(axis=1))
