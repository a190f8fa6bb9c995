"""How badly each run fits the rest, without fitting again.

Leaving run k out changes the sum of squares by |e|^2 / (1 - h), e its residual and h its leverage, and the rest
predicts it with the error e / (1 - h) (Cook and Weisberg, Residuals and Influence in Regression, 1982, section 2.2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.balancing.influence.fit import InfluenceFit, RunSet
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray

# A machine repeats its vibration from start to start no better than this share of its amplitude; the scatter of an
# averaged reading knows nothing of it.
REPEATABILITY = 0.02

# A run with less freedom than this is needed to determine the fit, and nothing can contradict it.
_FREEDOM = 1e-6


@dataclass(frozen=True)
class Misfit:
    """statistic: (K,) -2 ln p summed over the sensors, chi-square with `freedom` (K,) if the run is sound.

    missed: (K, S) complex, reading minus what the other runs predict; nan where they do not. relative: (K,) greatest
    |missed| over the sensor's amplitude. size: (S,) typical amplitude. total, dof: chi-square of all runs together over
    sensors with stated scatter.
    """

    statistic: FloatArray
    freedom: IntArray
    missed: ComplexArray
    relative: FloatArray
    size: FloatArray
    total: float
    dof: int


def worst_miss(runs: RunSet, fit: InfluenceFit) -> float:
    """Greatest `Misfit.relative`, quickly; nan readings count for nothing."""
    present = np.isfinite(fit.residuals)
    amplitude = np.where(present, np.abs(runs.vibration), 0.0)
    size = np.sqrt((amplitude**2).sum(axis=0) / np.maximum(present.sum(axis=0), 1))
    missed = np.where(present, np.abs(fit.residuals), 0.0)
    freedom = np.where(present, 1.0 - fit.leverage, 0.0)
    testable = freedom > _FREEDOM
    share = missed / np.where(testable, freedom, np.inf) / np.where(size > 0.0, size, np.inf)
    return float(share.max())


def misfit_of(runs: RunSet, fit: InfluenceFit) -> Misfit:
    """Compare each run with the fit of the others; see `Misfit`."""
    present = np.isfinite(fit.residuals)
    amplitude = np.where(present, np.abs(runs.vibration), 0.0)
    size = np.sqrt((amplitude**2).sum(axis=0) / np.maximum(present.sum(axis=0), 1))
    size = np.where(size > 0.0, size, np.inf)
    freedom = np.where(present, 1.0 - fit.leverage, 0.0)
    testable = freedom > _FREEDOM
    safe = np.where(testable, freedom, 1.0)
    missed = fit.residuals * np.where(testable, 1.0 / safe, np.nan)
    residual = np.where(present, np.abs(fit.residuals), 0.0)
    error = np.where(testable, residual, 0.0) ** 2

    stated = np.isfinite(fit.chi_square)
    scatter = np.where(present & (runs.scatter > 0.0), runs.scatter, 0.0)
    variance = scatter**2 + (REPEATABILITY * size) ** 2
    score = np.where(stated, error / (np.where(variance > 0.0, variance, np.inf) * safe), 0.0)
    left = fit.dof - 2
    # Exactly: -2 ln p of the F test with 2 and `left` degrees of freedom.
    estimated = ~stated & (left > 0)
    if estimated.any():
        whole = (residual**2).sum(axis=0)
        rest = np.maximum(whole - error / safe, 1e-30 * np.maximum(whole, 1e-270))
        score = np.where(estimated & testable, left * np.log(np.maximum(whole, 1e-300) / rest), score)
    scored = testable & (stated | estimated)
    return Misfit(
        statistic=np.where(scored, score, 0.0).sum(axis=1),
        freedom=2 * scored.sum(axis=1),
        missed=missed,
        relative=(np.sqrt(error) / (safe * size)).max(axis=1),
        size=size,
        total=float(np.where(stated, score * safe, 0.0).sum()),
        dof=int(fit.dof[stated].sum()),
    )


def improbable(statistic: FloatArray, freedom: IntArray, probability: float) -> NDArray[np.bool_]:
    """Whether a chi-square `statistic` with `freedom` degrees would be exceeded with less than `probability`."""
    # Far quicker than the tail function, and never misses: no chi-square below its mean is improbable.
    if not (statistic > freedom).any():
        return np.zeros(np.shape(statistic), dtype=bool)
    from scipy.special import chdtrc

    return np.asarray((freedom > 0) & (chdtrc(np.maximum(freedom, 1), statistic) < probability))
