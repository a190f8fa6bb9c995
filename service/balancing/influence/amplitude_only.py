"""Influence from amplitudes alone, where no phase can be measured.

For each sensor |v0 + A u_k| = V_k over the runs. A common turn of v0 and the row of A changes nothing, so v0 is taken
real and 2P + 1 unknowns remain; each sensor stands for itself. The equations may have several solutions: all are
found, and the extra run that tells them apart is proposed.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice, product

import numpy as np

from service.balancing.influence.fit import InfluenceFit, condition
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from service.messages import Message, Quantity

_STARTS = 96
_STEPS = 80
# Solutions this far apart, as a share of their length, are different ones.
_DISTINCT = 0.02
# A further solution is taken as possible while it misses the readings by no more than this share of the amplitude, or
# by this multiple of the best solution's miss.
_MISS = 0.02
_WORSE = 3.0
_MAX_ALTERNATIVES = 16
_DIRECTIONS = 24


@dataclass(frozen=True)
class AmplitudeFit:
    """Every model that explains the amplitudes, the best first.

    models: as fits, phases relative to v0 = real and >= 0, sensor by sensor; no covariance. misses: (M,) root mean
    square of what each leaves of the amplitudes. resolving_run: (P,) complex g to put on the rotor as found so that the
    models differ most, None where there is one model only. difference: by how much at least, at one sensor, such a run
    tells any two models apart, as a share of the greatest amplitude.
    """

    models: tuple[InfluenceFit, ...]
    misses: FloatArray
    resolving_run: ComplexArray | None
    difference: float

    @property
    def ambiguous(self) -> bool:
        """Whether more than one model explains the amplitudes."""
        return len(self.models) > 1


@dataclass(frozen=True)
class FourRun:
    """trial_effect: amplitude that the trial mass alone would cause. correction: complex g, internal sense."""

    trial_effect: float
    correction: complex


def four_run(initial: float, trial_mass: float, angles: FloatArray, amplitudes: FloatArray) -> FourRun:
    """Solve one plane and one sensor from the as-found amplitude and N >= 3 trials of one mass, in closed form.

    V_k^2 = V0^2 + t^2 + 2 V0 t cos(angle_k + phi) is linear in t^2, t cos phi and t sin phi; the correction is
    -V0 / t of the trial mass at -phi. angles: (N,) radians; amplitudes: (N,). Raises NumericsError for fewer than three
    different angles, or amplitudes that no trial effect explains.
    """
    if len(angles) != len(amplitudes) or not np.isfinite([initial, trial_mass, *angles, *amplitudes]).all():
        raise NumericsError(Message("numerics.amplitudes_and_angles"), field="runs")
    design = np.stack([np.ones_like(angles), np.cos(angles), -np.sin(angles)], axis=1)
    if initial <= 0.0 or trial_mass == 0.0 or np.linalg.matrix_rank(design, tol=1e-6) < 3:
        raise NumericsError(
            Message(
                "too_few_runs.amplitudes_of_one_plane",
                count=len(angles),
                mass=Quantity(trial_mass, "g"),
                initial=initial,
            ),
            field="runs",
        )
    square, c, s = np.linalg.lstsq(design, amplitudes**2 - initial**2, rcond=None)[0]
    if square <= 0.0:
        raise NumericsError(Message("runs_contradict.amplitudes_too_small"), field="runs", value=amplitudes.tolist())
    effect = float(np.sqrt(square))
    return FourRun(effect, complex(-initial * trial_mass / effect * np.exp(-1j * np.arctan2(s, c))))


def fit_amplitudes(
    masses: ComplexArray, amplitudes: FloatArray, rng: np.random.Generator, labels: Labels | None = None
) -> AmplitudeFit:
    """Non-linear least squares of | |v0 + A u_k| - V_k | from many starts, sensor by sensor.

    masses: (K, P) complex g, all masses on the rotor. amplitudes: (K, S), nan where missing. Raises NumericsError for
    fewer than 2P + 1 amplitudes of a sensor, and where the runs leave a continuum of solutions.
    """
    labels = labels or Labels()
    _validate(masses, amplitudes, labels)
    found = [_solutions(masses, amplitudes[:, s], rng, s, labels) for s in range(amplitudes.shape[1])]
    choices = list(islice(product(*found), _MAX_ALTERNATIVES))
    models = [_as_fit(masses, amplitudes, choice, labels) for choice in choices]
    misses = np.array([np.sqrt(np.nanmean(np.abs(model.residuals) ** 2)) for model in models])
    order = np.argsort(misses, kind="stable")
    run, difference = _resolving_run(masses, models) if len(models) > 1 else (None, 0.0)
    return AmplitudeFit(tuple(models[k] for k in order), misses[order], run, difference)


def _validate(masses: ComplexArray, amplitudes: FloatArray, labels: Labels) -> None:
    if masses.ndim != 2 or amplitudes.ndim != 2 or len(masses) != len(amplitudes) or 0 in amplitudes.shape:
        raise NumericsError(
            Message("numerics.amplitudes_shape", masses=masses.shape, amplitudes=amplitudes.shape), field="runs"
        )
    if not np.isfinite(masses).all() or (amplitudes < 0.0).any() or np.isinf(amplitudes).any():
        raise NumericsError(Message("numerics.amplitudes_not_finite"), field="runs")
    needed = 2 * masses.shape[1] + 1
    for s, count in enumerate(np.isfinite(amplitudes).sum(axis=0)):
        if count < needed:
            raise NumericsError(
                Message(
                    "too_few_runs.amplitudes",
                    sensor=labels.sensor(s),
                    count=count,
                    planes=masses.shape[1],
                    needed=needed,
                ),
                field="runs",
                value=int(count),
            )
    if not np.nan_to_num(amplitudes).any():
        raise NumericsError(Message("all_readings_zero.amplitudes"), field="runs")


def _solutions(
    masses: ComplexArray, amplitude: FloatArray, rng: np.random.Generator, sensor: int, labels: Labels
) -> list[ComplexArray]:
    """Distinct (v0, row of A), each (P + 1,), of one sensor, best first."""
    seen = np.isfinite(amplitude)
    scale = np.abs(masses).max(axis=0)
    bare = [p for p in range(len(scale)) if scale[p] == 0.0]
    if bare:
        raise NumericsError(
            Message(
                "too_few_runs.plane_without_mass_amplitudes",
                planes=map(labels.plane, bare),
                plane=labels.plane(bare[0]),
            ),
            field="runs",
            value=bare,
        )
    design = np.concatenate([np.ones((seen.sum(), 1)), masses[seen] / scale], axis=1)
    V = amplitude[seen]
    size = float(np.sqrt((V**2).mean()))
    unknown = 2 * design.shape[1] - 1
    x = _descend(design, V / size, _starts(design.shape[1], rng))
    x *= np.exp(-1j * np.angle(x[:, :1]))
    misses = np.sqrt(((np.abs(x @ design.T) - V / size) ** 2).mean(axis=1))
    x, misses = x[np.argsort(misses)], np.sort(misses)
    allowed = max(_MISS if len(V) > unknown else 1e-6, _WORSE * float(misses[0]))
    distinct: list[ComplexArray] = []
    for candidate in x[misses <= allowed]:
        if all(np.linalg.norm(candidate - other) > _DISTINCT * np.linalg.norm(other) for other in distinct):
            distinct.append(candidate)
    _refuse_continuum(design, distinct[0], sensor, labels)
    return [candidate * size / np.concatenate([[1.0], scale]) for candidate in distinct[:_MAX_ALTERNATIVES]]


def _starts(count: int, rng: np.random.Generator) -> ComplexArray:
    """Starts (N, P + 1) of about the size of the readings, v0 first."""
    length = np.exp(rng.normal(0.0, 0.7, (_STARTS, count)))
    return np.asarray(length * np.exp(2j * np.pi * rng.random((_STARTS, count))))


def _jacobian(design: ComplexArray, x: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Amplitudes (N, K) and their slopes (N, K, 2P + 2) by real and imaginary parts of x (N, P + 1)."""
    vibration = x @ design.T
    amplitude = np.abs(vibration)
    turned = (vibration.conj() / np.maximum(amplitude, 1e-12))[:, :, None] * design
    return amplitude, np.concatenate([turned.real, -turned.imag], axis=2)


def _descend(design: ComplexArray, V: FloatArray, x: ComplexArray) -> ComplexArray:
    """Levenberg and Marquardt from all starts at once."""
    parts = 2 * design.shape[1]
    damping = np.full(len(x), 1e-2)
    amplitude, J = _jacobian(design, x)
    cost = ((amplitude - V) ** 2).sum(axis=1)
    for _ in range(_STEPS):
        system = J.swapaxes(1, 2) @ J
        # The common turn of x is free: the damping, never zero, keeps the system regular.
        system[:, np.arange(parts), np.arange(parts)] += np.maximum(damping, 1e-12)[:, None]
        step = np.linalg.solve(system, (J.swapaxes(1, 2) @ (V - amplitude)[:, :, None]))[:, :, 0]
        tried = x + step[:, : parts // 2] + 1j * step[:, parts // 2 :]
        new_amplitude, new_J = _jacobian(design, tried)
        new_cost = ((new_amplitude - V) ** 2).sum(axis=1)
        better = new_cost < cost
        if not better.any() and (damping > 1e3).all():
            break
        x = np.where(better[:, None], tried, x)
        amplitude = np.where(better[:, None], new_amplitude, amplitude)
        J = np.where(better[:, None, None], new_J, J)
        cost = np.where(better, new_cost, cost)
        damping = np.where(better, damping * 0.2, np.minimum(damping * 5.0, 1e6))
    return x


def _refuse_continuum(design: ComplexArray, x: ComplexArray, sensor: int, labels: Labels) -> None:
    J = _jacobian(design, x[None, :])[1][0]
    singular = np.linalg.svd(J, compute_uv=False)
    # One direction, the common turn, is always free.
    if int((singular > 1e-7 * singular[0]).sum()) >= J.shape[1] - 1:
        return
    raise NumericsError(
        Message("planes_not_separated.amplitudes", sensor=labels.sensor(sensor)), field="runs", value=sensor
    )


def _as_fit(
    masses: ComplexArray, amplitudes: FloatArray, rows: tuple[ComplexArray, ...], labels: Labels
) -> InfluenceFit:
    x = np.array(rows)
    vibration = x[:, 0] + masses @ x[:, 1:].T
    count, sensors, planes = len(masses), len(x), masses.shape[1]
    # A reading has no phase of its own: what is missed lies along the fitted vector.
    residuals = (amplitudes - np.abs(vibration)) * np.exp(1j * np.angle(vibration))
    return InfluenceFit(
        influence=x[:, 1:],
        initial=x[:, 0],
        covariance=np.full((sensors, planes + 1, planes + 1), complex(np.nan, np.nan)),
        dof=np.maximum(np.isfinite(amplitudes).sum(axis=0) - 2 * planes - 1, 0),
        scatter_dof=np.zeros(sensors),
        condition=condition(x[:, 1:]),
        residuals=residuals,
        chi_square=np.full(sensors, np.nan),
        leverage=np.full((count, sensors), np.nan),
        labels=labels,
    )


def _resolving_run(masses: ComplexArray, models: list[InfluenceFit]) -> tuple[ComplexArray, float]:
    """One mass, the size of the largest trial, in the plane and at the angle where the models differ most."""
    planes = masses.shape[1]
    turns = np.exp(2j * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS)
    tried = np.concatenate([np.outer(turns * np.abs(masses[:, p]).max(), np.eye(planes)[p]) for p in range(planes)])
    told = np.array([np.abs(model.initial + tried @ model.influence.T) for model in models])
    first, second = np.triu_indices(len(models), 1)
    apart = (np.abs(told[first] - told[second]) / told.max()).max(axis=2).min(axis=0)
    best = int(np.argmax(apart))
    return tried[best], float(apart[best])
