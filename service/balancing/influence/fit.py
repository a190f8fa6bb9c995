"""Influence coefficients and as-found vibration from any set of runs.

Every run states all the masses on the rotor, so one affine model v = v0 + A u covers initial, trial (removed or left
in, one plane or several), repeated, check and correction runs alike. Sensors are independent: each has its own row of
A, its own weights and its own missing readings. Several speeds are several rows: one per sensor and speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from service.balancing.rotor.intervals import amplitude_interval
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.errors import NumericsError
from service.messages import Message

__all__ = [
    "KNOWN_SCATTER",
    "InfluenceFit",
    "Prediction",
    "RunSet",
    "amplitude_interval",
    "condition",
    "fit_influence",
    "predict",
    "refuted",
]

KNOWN_SCATTER = math.inf
"""Degrees of freedom behind a scatter that was stated with the readings instead of estimated from the residuals."""

# Columns of the scaled design below this share of the largest singular value carry no information of their own.
_RANK_TOLERANCE = 1e-10

# Probability under which the residuals are too large for the scatter stated: then they, not it, set the variance.
_SCATTER_REFUTED = 1e-3


@dataclass(frozen=True)
class RunSet:
    """K runs of a rotor with P correction planes and S sensors.

    masses: (K, P) complex g, internal sense, ALL masses on the rotor relative to as-found, trial masses included.
    vibration: (K, S) complex 1x vectors, internal sense, any unit; nan where a sensor gave nothing.
    scatter: (K, S) standard deviation of each reading per real component, same unit; nan or 0 where unknown; that
    between the runs included, see `speed_scatter`.
    """

    masses: ComplexArray
    vibration: ComplexArray
    scatter: FloatArray
    labels: Labels = field(default_factory=Labels)


@dataclass(frozen=True)
class InfluenceFit:
    """v = v0 + A u, fitted.

    influence: (S, P) complex, unit of the sensor per g. initial: (S,) complex v0, the rotor as found. covariance:
    (S, P + 1, P + 1) complex Hermitian C of (v0, row of A), per real component: E[e e^H] / 2; nan where there is
    neither scatter nor a degree of freedom. dof: (S,) real degrees of freedom of the residuals. scatter_dof: (S,)
    those behind the covariance: `dof` where it comes from the residuals, `KNOWN_SCATTER` where it was stated, 0 where
    the covariance is nan. condition: of A with its columns scaled to length 1 (inf when planes are dependent).
    residuals: (K, S) complex, measured minus fitted; nan where not measured. chi_square: (S,) sum of squared
    standardised residuals where scatter was stated, else nan. leverage: (K, S) share of each reading in its own fitted
    value: at 1 nothing else can contradict it. estimator: (S, P + 1, K) complex, (v0, row of A) = estimator @ readings.
    shared: (J, S, P + 1) complex, errors of (v0, row of A) that all sensors have together, for one standard deviation
    per real component of each of J circular errors; their part is in `covariance` as well.
    """

    influence: ComplexArray
    initial: ComplexArray
    covariance: ComplexArray
    dof: IntArray
    scatter_dof: FloatArray
    condition: float
    residuals: ComplexArray
    chi_square: FloatArray
    leverage: FloatArray
    labels: Labels = field(default_factory=Labels)
    estimator: ComplexArray = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=np.complex128))
    shared: ComplexArray = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=np.complex128))


@dataclass(frozen=True)
class Prediction:
    """1x vibration expected with certain masses on the rotor.

    vibration: (S,) complex. scatter: (S,) standard deviation per real component, nan where unknown. dof: (S,) degrees
    of freedom behind it, as `InfluenceFit.scatter_dof`.
    """

    vibration: ComplexArray
    scatter: FloatArray
    dof: FloatArray


def fit_influence(runs: RunSet, incomplete: Literal["refuse", "leave_out"] = "refuse") -> InfluenceFit:
    """Weighted least squares of v = v0 + A u, for each sensor over the runs that have it.

    Readings of a sensor weigh by inverse variance where all of them have a scatter, else equally, with the variance of
    the residuals. `incomplete` says what to do with a sensor whose own readings do not determine its row while those of
    another sensor do: refuse, or leave its row nan.

    Raises NumericsError for wrong shapes, a NaN mass, negative scatter, readings that are all zero, and runs that do
    not determine the coefficients; the advice says which run to add.
    """
    _validate(runs)
    scale = np.abs(runs.masses).max(axis=0)
    _require_masses(runs, scale)
    design = np.empty((len(runs.masses), 1 + len(scale)), dtype=np.complex128)
    design[:, 0] = 1.0
    np.divide(runs.masses, scale, out=design[:, 1:])

    present = np.isfinite(runs.vibration)
    complete = bool(present.all())
    weight, unit, stated = _weights(runs.scatter, present, complete)
    left, singular, right = np.linalg.svd(weight.T[:, :, None] * design, full_matrices=False)
    solvable = singular[:, -1] > _RANK_TOLERANCE * singular[:, 0]
    whole = len(design) >= design.shape[1] and bool(solvable.all())
    if not whole:
        solvable &= len(design) >= design.shape[1]
        _refuse_or_leave_out(runs, design, present, solvable, incomplete)
        singular = np.where(solvable[:, None], singular, 1.0)
    # The small inverse keeps the row order (v0, A) and undoes the column scaling.
    inverse = right.conj().swapaxes(1, 2) / singular[:, None, :]
    inverse[:, 1:] /= scale[:, None]
    measured = runs.vibration if complete else np.where(present, runs.vibration, 0.0)
    estimator = (inverse @ left.conj().swapaxes(1, 2)) * weight.T[:, None, :]
    solved = (inverse @ (left.conj().swapaxes(1, 2) @ (weight * measured).T[:, :, None]))[:, :, 0]

    initial, influence = solved[:, 0].copy(), solved[:, 1:].copy()
    residuals = runs.vibration - (initial + runs.masses @ influence.T)
    dof = 2 * (present.sum(axis=0) - design.shape[1])
    variance, scatter_dof, chi_square = _variance(residuals, weight, unit, dof, stated, complete)
    covariance = variance[:, None, None] * (inverse @ inverse.conj().swapaxes(1, 2))
    if not whole:
        for part in (initial, influence, covariance, residuals.T, estimator):
            part[~solvable] = np.nan
        dof, scatter_dof = np.where(solvable, dof, 0), np.where(solvable, scatter_dof, 0.0)
    return InfluenceFit(
        influence=influence,
        initial=initial,
        covariance=covariance,
        dof=dof,
        scatter_dof=scatter_dof,
        condition=condition(influence if whole else influence[solvable]),
        residuals=residuals,
        chi_square=chi_square,
        leverage=(left.real**2 + left.imag**2).sum(axis=2).T,
        labels=runs.labels,
        estimator=estimator,
    )


def predict(fit: InfluenceFit, masses: ComplexArray, reading_scatter: FloatArray | float = 0.0) -> Prediction:
    """Vibration with `masses` (P,) complex g on the rotor as found, with first-order scatter.

    The scatter is that of the true 1x vector; with `reading_scatter` (S,), per real component, it is that of the next
    reading. Raises NumericsError for a wrong number of planes or a NaN mass.
    """
    if masses.shape != fit.influence.shape[1:] or not np.isfinite(masses).all():
        raise NumericsError(
            Message("numerics.masses_of_fit", count=fit.influence.shape[1], masses=masses.tolist()), field="masses"
        )
    state = np.ones(1 + len(masses), dtype=np.complex128)
    state[1:] = masses
    with np.errstate(invalid="ignore"):  # rows that are nan stay nan
        variance = ((fit.covariance @ state.conj()) @ state).real
        vibration = fit.initial + fit.influence @ masses
    return Prediction(
        vibration=vibration,
        scatter=np.sqrt(np.maximum(variance, 0.0) + np.square(reading_scatter)),
        dof=fit.scatter_dof,
    )


def condition(influence: ComplexArray) -> float:
    """Condition number of (S, P) coefficients with columns scaled to length 1; inf when planes are dependent."""
    length = np.sqrt((influence.real**2 + influence.imag**2).sum(axis=0))
    if influence.shape[0] < influence.shape[1] or not length.all():
        return float("inf")
    singular = np.linalg.svd(influence / length, compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] > 0.0 else float("inf")


def _weights(
    scatter: FloatArray, present: NDArray[np.bool_], complete: bool
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Weights (K, S), the greatest of each sensor 1; the factors (S,) taken out; which sensors stated their scatter."""
    known = scatter > 0.0
    stated = np.all(known if complete else known | ~present, axis=0)
    if complete and stated.all():
        weight = 1.0 / scatter
    else:
        weight = np.where(present, 1.0, 0.0)
        np.divide(1.0, scatter, out=weight, where=present & stated)
    # A common factor per sensor changes nothing but keeps the products away from overflow.
    unit = weight.max(axis=0)
    unit[unit == 0.0] = 1.0
    return weight / unit, unit, np.asarray(stated)


def _variance(
    residuals: ComplexArray,
    weight: FloatArray,
    unit: FloatArray,
    dof: IntArray,
    stated: NDArray[np.bool_],
    complete: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Variance of unit weight per real component, the degrees of freedom behind it, and chi-square."""
    away = weight * np.abs(residuals)
    total = ((away if complete else np.where(weight > 0.0, away, 0.0)) ** 2).sum(axis=0)
    chi_square = np.where(stated, total * unit**2, np.nan)
    believed = stated & ~refuted(chi_square, dof)
    if believed.all():
        return unit**-2.0, np.full(len(dof), KNOWN_SCATTER), chi_square
    estimated = np.divide(total, dof, out=np.full(total.shape, np.nan), where=dof > 0)
    variance = np.where(believed, unit**-2.0, estimated)
    return variance, np.where(believed, KNOWN_SCATTER, np.maximum(dof, 0.0)), chi_square


def refuted(chi_square: FloatArray, dof: IntArray) -> NDArray[np.bool_]:
    """Whether the residuals are far larger than the scatter stated allows."""
    # Wilson-Hilferty: a screen against the mean spares the quantile in the usual case.
    if not (chi_square > np.maximum(dof, 1)).any():
        return np.zeros(chi_square.shape, dtype=bool)
    from scipy.special import chdtrc

    return (dof > 0) & (chdtrc(np.maximum(dof, 1), chi_square) < _SCATTER_REFUTED)


def _validate(runs: RunSet) -> None:
    masses, vibration, scatter = runs.masses, runs.vibration, runs.scatter
    if masses.ndim != 2 or vibration.ndim != 2 or scatter.shape != vibration.shape or len(masses) != len(vibration):
        raise NumericsError(
            Message("numerics.runs_shape", masses=masses.shape, vibration=vibration.shape, scatter=scatter.shape),
            field="runs",
        )
    if 0 in masses.shape or 0 in vibration.shape:
        raise NumericsError(
            Message("numerics.runs_empty", runs=len(masses), planes=masses.shape[1], sensors=vibration.shape[1]),
            field="runs",
        )
    if not np.isfinite(masses).all():
        bad = np.argwhere(~np.isfinite(masses))
        run, plane = (int(index) for index in bad[0])
        raise NumericsError(
            Message("numerics.mass_not_finite", run=runs.labels.run(run), plane=runs.labels.plane(plane)),
            field="masses",
            value=str(masses[run, plane]),
        )
    wrong = np.isinf(vibration) | (scatter < 0.0) | np.isinf(scatter)
    if wrong.any():
        bad = np.argwhere(wrong)
        run, sensor = (int(index) for index in bad[0])
        raise NumericsError(
            Message(
                "numerics.reading_not_finite",
                sensor=runs.labels.sensor(sensor),
                run=runs.labels.run(run),
                value=vibration[run, sensor],
                scatter=scatter[run, sensor],
            ),
            field="vibration",
        )
    if not (np.abs(vibration) > 0.0).any():
        raise NumericsError(Message("all_readings_zero"), field="vibration")


def _require_masses(runs: RunSet, scale: FloatArray) -> None:
    if scale.all():
        return
    bare = [int(plane) for plane in np.flatnonzero(scale == 0.0)]
    raise NumericsError(
        Message(
            "too_few_runs.plane_without_mass",
            planes=map(runs.labels.plane, bare),
            count=len(runs.masses),
            plane=runs.labels.plane(bare[0]),
        ),
        field="runs",
        value=bare,
    )


def _refuse_or_leave_out(
    runs: RunSet,
    design: ComplexArray,
    present: NDArray[np.bool_],
    solvable: NDArray[np.bool_],
    incomplete: Literal["refuse", "leave_out"],
) -> None:
    _require_rank(runs, design)
    if incomplete == "leave_out" and solvable.any():
        return
    sensor = int(np.flatnonzero(~solvable)[0])
    seen = present[:, sensor]
    rest = RunSet(runs.masses[seen], runs.vibration[seen], runs.scatter[seen], Labels(planes=runs.labels.planes))
    try:
        _require_rank(rest, design[seen])
    except NumericsError as error:
        lacking = [runs.labels.run(int(run)) for run in np.flatnonzero(~seen)]
        told = Message("without_runs", sensor=runs.labels.sensor(sensor), runs=lacking, effect=error.data)
        raise NumericsError(told, code=error.code, field=error.field, value=error.value) from None


def _require_rank(runs: RunSet, design: ComplexArray) -> None:
    """Raise unless the design determines v0 and every column of A."""
    needed = design.shape[1]
    _, singular, right = np.linalg.svd(design)
    rank = int((singular > _RANK_TOLERANCE * singular[:1]).sum())
    if rank == needed:
        return
    # A direction of (v0, u) that no run can see: the planes that take part in it are the dependent ones.
    unseen = np.abs(right[rank:]).max(axis=0)
    planes = [int(plane) for plane in np.flatnonzero(unseen[1:] > 1e-6)]
    names = tuple(map(runs.labels.plane, planes))
    if rank == 1 and len(design) > 1:
        told = Message("planes_not_separated.same_masses", runs=len(design), plane=names[0])
    elif len(planes) > 1:
        told = Message("planes_not_separated", runs=len(design), unknowns=needed, planes=names, plane=names[0])
    else:
        told = Message("planes_not_separated.always_there", plane=names[0])
    raise NumericsError(
        told,
        code="too_few_runs" if len(design) < needed else "planes_not_separated",
        field="runs",
        value=planes,
    )
