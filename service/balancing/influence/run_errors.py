"""What a run's vectors err by besides the scatter of their readings: repeatability, warming up, pieces off their place.

The scatter stated with a reading is that of its mean within one run. Started again, the same rotor reads differently by
a share of its amplitude. That error is a run's and a sensor's own. Others are shared: a piece that is
heavier than stated, or not quite in its place, shows at all sensors and in every run that it is on the rotor for; what
warms up changes all sensors alike, from run to run. They are carried as modes: vectors of errors that come and go
together (Aitken 1935; Fuller, Measurement Error Models, 1987, section 1.2, for masses that are not known exactly).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from service.balancing.influence.fit import KNOWN_SCATTER, InfluenceFit, RunSet, fit_influence, refuted
from service.balancing.rotor.phasors import ComplexArray, IntArray

REPEATABILITY = 0.02
"""Standard deviation of a vector from start to start, as a share of its amplitude; both components together."""
MASS_SD = 0.005
"""Standard deviation of the mass of a piece, as a share of it."""
ANGLE_SD = float(np.radians(0.5))
"""Standard deviation of the angle of a piece, radians."""


@dataclass(frozen=True)
class Errors:
    """repeatability: see `REPEATABILITY`. dof: degrees of freedom behind it, `KNOWN_SCATTER` where it was stated.

    drift: standard deviation of the change from a run to the next, a share of the amplitude, all sensors alike; the
    first run shows the rotor as it is meant.
    mass_sd, angle_sd: see `MASS_SD` and `ANGLE_SD`.
    """

    repeatability: float = REPEATABILITY
    drift: float = 0.0
    mass_sd: float = MASS_SD
    angle_sd: float = ANGLE_SD
    dof: float = KNOWN_SCATTER

    @property
    def per_component(self) -> float:
        """Repeatability of one real component."""
        return self.repeatability / float(np.sqrt(2.0))

    @property
    def placement(self) -> float:
        """Error of a piece's vector per real component, as a share of its mass."""
        return float(np.sqrt(0.5 * (self.mass_sd**2 + self.angle_sd**2)))


@dataclass(frozen=True)
class Pieces:
    """N pieces that were on the rotor in some of K runs.

    plane: (N,) index. mass: (N,) complex g, as stated. on: (K, N) whether it was on the rotor.
    """

    plane: IntArray
    mass: ComplexArray
    on: NDArray[np.bool_]


@dataclass(frozen=True)
class Repeats:
    """What runs of the same masses tell. share: repeatability, both components together. dof: real ones behind it."""

    share: float
    dof: int


CONTRADICT = 0.12
"""Runs of the same masses further apart than this share of their amplitude contradict each other: one of them is wrong,
and nothing is learned from them (six times the usual repeatability)."""
MIN_DOF = 4
"""Weight of the usual repeatability, in degrees of freedom, against runs that repeat better than it."""


def repeats_of(runs: RunSet) -> Repeats:
    """Repeatability that runs of the same masses show beyond the scatter of their readings; dof 0 where none are.

    By moments: the sum over such runs and sensors of |v - mean|^2, less twice the stated variance of the readings, over
    the sum of |mean|^2, each counted once less than there are runs.
    """
    tolerance = 1e-6 * np.abs(runs.masses).max(initial=0.0)
    left = list(range(len(runs.masses)))
    moved, size, dof = 0.0, 0.0, 0
    while left:
        alike = [k for k in left if (np.abs(runs.masses[k] - runs.masses[left[0]]) <= tolerance).all()]
        left = [k for k in left if k not in alike]
        vibration, scatter = runs.vibration[alike], runs.scatter[alike]
        for s in np.flatnonzero(np.isfinite(vibration).sum(axis=0) > 1):
            seen = np.isfinite(vibration[:, s])
            v, more = vibration[seen, s], int(seen.sum()) - 1
            if float(np.abs(v[:, None] - v).max()) > CONTRADICT * float(np.abs(v.mean())):
                continue
            known = np.where(scatter[seen, s] > 0.0, scatter[seen, s], 0.0)
            moved += float((np.abs(v - v.mean()) ** 2).sum() - 2.0 * more * (known**2).mean())
            size += more * float(np.abs(v.mean()) ** 2)
            dof += 2 * more
    return Repeats(float(np.sqrt(max(moved, 0.0) / size)) if size > 0.0 else 0.0, dof if size > 0.0 else 0)


def learned(known: tuple[Repeats, ...], usual: float = REPEATABILITY) -> Repeats:
    """Repeatability from all that is known of a machine, on the careful side where that is little.

    Runs that repeat worse than is usual are believed with their degrees of freedom, by which intervals are widened;
    runs that repeat better are weighed against `MIN_DOF` degrees of freedom of the usual, so that two lucky runs do
    not make a machine exact.
    """
    dof = sum(one.dof for one in known)
    if dof == 0:
        return Repeats(usual, 0)
    square = sum(one.dof * one.share**2 for one in known) / dof
    if square > usual**2:
        return Repeats(float(np.sqrt(square)), dof)
    return Repeats(float(np.sqrt((dof * square + MIN_DOF * usual**2) / (dof + MIN_DOF))), dof)


def with_repeatability(runs: RunSet, errors: Errors) -> RunSet:
    """Return the runs with each stated scatter widened by the repeatability; what is not stated stays so."""
    added = errors.per_component * np.abs(runs.vibration)
    known = (runs.scatter > 0.0) & (added > 0.0)
    return replace(runs, scatter=np.hypot(runs.scatter, added, out=runs.scatter.copy(), where=known))


def fit_with_errors(runs: RunSet, errors: Errors, pieces: Pieces | None = None) -> InfluenceFit:
    """Fit runs, their scatter widened already, by generalised least squares under the errors that runs share.

    Rows are weighted by all that a run may err by; the covariance is that of the weighted estimate under the errors as
    they are, shared ones as `InfluenceFit.shared`. Sensors without a stated scatter keep the variance of their
    residuals, which contain all of this. Raises as `fit_influence`.
    """
    plain = _within(fit_influence(runs, "leave_out"), errors.dof)
    modes = _modes(runs, plain, errors, pieces)
    if not len(modes):
        return plain
    # What comes and goes together makes a run less certain all the same: it gets less weight.
    added = np.sqrt((np.abs(modes) ** 2).sum(axis=0))
    stated = (runs.scatter > 0.0) & np.isfinite(added)
    wider = replace(runs, scatter=np.hypot(runs.scatter, added, out=runs.scatter.copy(), where=stated))
    fit = _within(fit_influence(wider, "leave_out"), errors.dof)
    known = np.isfinite(fit.chi_square) & np.isfinite(fit.initial)
    variance = np.where(runs.scatter > 0.0, runs.scatter, 0.0) ** 2
    own = np.einsum("sik,ks,sjk->sij", fit.estimator, variance, fit.estimator.conj(), optimize=True)
    shared = np.einsum("sik,jks->jsi", fit.estimator, np.nan_to_num(modes), optimize=True)
    shared[:, ~known] = 0.0
    # Where the residuals refute what was stated, all of it was too small.
    factor = np.where(refuted(fit.chi_square, fit.dof), fit.chi_square / np.maximum(fit.dof, 1), 1.0)
    shared *= np.sqrt(np.where(known, factor, 0.0))[None, :, None]
    both = own * factor[:, None, None] + np.einsum("jsi,jsk->sik", shared, shared.conj())
    covariance = np.where(known[:, None, None], both, fit.covariance)
    return replace(fit, covariance=covariance, shared=shared)


def _within(fit: InfluenceFit, dof: float) -> InfluenceFit:
    """The fit with a covariance that is no surer than the repeatability behind it."""
    stated = fit.scatter_dof == KNOWN_SCATTER
    return replace(fit, scatter_dof=np.where(stated, dof, fit.scatter_dof))


def _modes(runs: RunSet, fit: InfluenceFit, errors: Errors, pieces: Pieces | None) -> ComplexArray:
    """Errors (J, K, S) of the readings for one unit of each shared error: the pieces first, in their order, then drift.

    A unit is a circular complex number with one standard deviation per real component.
    """
    parts = []
    if pieces is not None and len(pieces.mass) and errors.placement > 0.0:
        size = errors.placement * np.abs(pieces.mass)
        each = (fit.influence[:, pieces.plane] * size).T  # (N, S)
        parts.append(pieces.on.T[:, :, None] * each[:, None, :])
    if errors.drift > 0.0:
        steps = np.arange(len(runs.masses))
        parts.append((errors.drift / np.sqrt(2.0) * steps[:, None] * runs.vibration)[None])
    if not parts:
        return np.zeros((0, *runs.vibration.shape), dtype=np.complex128)
    return np.concatenate(parts)
