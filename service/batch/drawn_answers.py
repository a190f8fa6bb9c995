"""Answers of many draws of one session at once: fit, correction, plan and prediction in arrays.

The same as solving each draw by itself (`studies`), for the sessions that most are: a least-squares correction from
runs with phase, and a plan of the smallest objective whose planes can be listed. Of any other session, and of a draw
whose runs hardly tell its planes apart, nothing is answered here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from service.balancing.influence.speed_scatter import with_speed_scatter
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.rotor.reactions import reaction_matrix
from service.balancing.rotor.units import angular_speed
from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.solver import solve_batch
from service.balancing.selection.batch.tables import Shared, shared_rows
from service.balancing.selection.objectives import NEGLIGIBLE_REACTION
from service.balancing.selection.placements import vectors_of
from service.balancing.selection.problem import BoolArray, Norm
from service.engine import mapping
from service.engine.influence_fits import FittedModel
from service.engine.selection_problem import PlanProblem
from service.model.correction import CorrectionRequest
from service.model.machine import Machine
from service.model.plan import Placement
from service.model.run import Run
from service.model.session import SessionLog

WORST_CONDITION = 1e6
"""Of a draw's coefficients: those of a worse one are looked at by themselves."""


@dataclass(frozen=True)
class Prepared:
    """One session whose draws can be answered together.

    cells: (readings, 2) run and row of each reading of the log that is used, -1 for others. sigma: (readings,) standard
    deviation per component. limits: (S,) weights of the correction's rows.
    """

    log: SessionLog
    fitted: FittedModel
    cells: IntArray
    sigma: FloatArray
    speeds: FloatArray
    used: BoolArray
    weights: FloatArray
    posed: PlanProblem | None
    shared: Shared | None
    names: tuple[str, ...]
    placed: dict[object, tuple[tuple[Placement, ...], ComplexArray]] = field(default_factory=dict)


@dataclass(frozen=True)
class Drawn:
    """Answers of D draws: masses (D, P) complex g, amplitudes (D, S), placements, and which draws are answered."""

    masses: ComplexArray
    amplitudes: FloatArray
    placements: tuple[tuple[Placement, ...], ...]
    answered: BoolArray


def prepare(log: SessionLog, fitted: FittedModel, posed: PlanProblem | None, scatter: float | None) -> Prepared | None:
    """What all draws of a session share; None where they have to be solved one by one.

    log: with one correction at most one plan. fitted, posed: of the session itself.
    """
    request = log.corrections[-1].request if log.corrections else CorrectionRequest(source="fit")
    if not _plain(log, request, fitted) or (posed is not None and not _plain_plan(posed)):
        return None
    shared = None if posed is None else shared_rows(posed.problem.planes, posed.problem.stock)
    if posed is not None and shared is None:
        return None
    machine = log.machine
    runs = _used(log)
    cells, sigma = _cells(log, runs, fitted, scatter)
    used = np.isfinite(fitted.fit.initial)
    weights = mapping.weights(machine, fitted.rows, request.method)
    return Prepared(
        log=log,
        fitted=fitted,
        cells=cells,
        sigma=sigma,
        speeds=mapping.speeds(runs, fitted.rows),
        used=used,
        weights=np.ones(int(used.sum())) if weights is None else weights[used],
        posed=posed,
        shared=shared,
        names=tuple(
            f"{row.sensor.name} at {row.speed_rpm:g} r/min" for row, use in zip(fitted.rows, used, strict=True) if use
        ),
    )


def _plain(log: SessionLog, request: CorrectionRequest, fitted: FittedModel) -> bool:
    """Whether a correction is least squares of the session's own runs, and nothing else."""
    of_runs = request.source == "fit" and request.method in (None, "least_squares", "weighted")
    wishes = (request.damping, request.max_mass_g, request.planes, request.mounted_later, request.earlier_sessions)
    earlier = any(correction.earlier_runs for correction in log.corrections)
    return of_runs and not any(wishes) and not earlier and bool(np.isfinite(fitted.fit.initial).any())


def _plain_plan(posed: PlanProblem) -> bool:
    """Whether a plan asks for the smallest objective, proved, and nothing of it was fitted."""
    request = posed.request
    return request.mode == "best" and request.method != "modified_jaya" and request.slack == 0.0


def _used(log: SessionLog) -> tuple[Run, ...]:
    """Runs of the correction, in order."""
    named = log.corrections[-1].runs if log.corrections else ()
    return tuple(run for run in log.runs if (run.number in named if named else not run.excluded))


def _cells(
    log: SessionLog, runs: Sequence[Run], fitted: FittedModel, scatter: float | None
) -> tuple[IntArray, FloatArray]:
    """Where each reading of the log enters the fit, in the order in which they are drawn, and its deviation."""
    column = {(row.sensor.name, row.speed_rpm): s for s, row in enumerate(fitted.rows)}
    number = {run.number: k for k, run in enumerate(runs)}
    cells, sigma = [], []
    for run in log.runs:
        for reading in run.readings:
            s = column.get((reading.sensor, run.nominal_speed_rpm), -1)
            k = number.get(run.number, -1)
            cells.append((k, s) if k >= 0 and s >= 0 and reading.phase_deg is not None else (-1, -1))
            sigma.append(reading.scatter if reading.scatter is not None else (scatter or 0.0) * reading.amplitude)
    return np.array(cells, dtype=np.int64).reshape(-1, 2), np.array(sigma)


def answer(prepared: Prepared, numbers: Sequence[int], seed: int) -> Drawn:
    """Answer draws by number, each drawn as `studies.drawn` does."""
    vibration = _vibration(prepared, numbers, seed)
    initial, influence, good = _fit(prepared, vibration)
    masses = _least_squares(prepared, initial, influence)
    good &= np.isfinite(masses).all(axis=1)
    if prepared.posed is None or prepared.shared is None:
        return Drawn(masses, _amplitudes(initial, influence, masses), ((),) * len(masses), good)
    objectives = _objectives(prepared.posed, initial, influence, masses)
    objectives = objectives.taken(np.flatnonzero(good))
    answers = solve_batch(prepared.shared, prepared.posed.problem.planes, objectives)
    placements: list[tuple[Placement, ...]] = [()] * len(masses)
    vectors = np.zeros_like(masses)
    for at, number in enumerate(np.flatnonzero(good).tolist()):
        placements[number], vectors[number] = _placed(prepared, answers.selection(at))
        good[number] = answers.proved[at]
    return Drawn(masses, _amplitudes(initial, influence, vectors), tuple(placements), good)


def _placed(
    prepared: Prepared, selection: tuple[tuple[object, ...], ...]
) -> tuple[tuple[Placement, ...], ComplexArray]:
    """Placements and vectors of a selection; many draws choose the same."""
    posed = prepared.posed
    if selection not in prepared.placed and posed is not None:
        pieces, _ = posed.placements(selection)  # type: ignore[arg-type]
        prepared.placed[selection] = pieces, vectors_of(posed.problem, selection)  # type: ignore[arg-type]
    return prepared.placed[selection]


def _vibration(prepared: Prepared, numbers: Sequence[int], seed: int) -> ComplexArray:
    """Readings (D, K, S) drawn anew, complex, each draw by its own generator."""
    readings = len(prepared.sigma)
    normal = np.empty((len(numbers), 2 * readings))
    for at, number in enumerate(numbers):
        normal[at] = np.random.default_rng([seed, number]).standard_normal(2 * readings)
    noise = prepared.sigma * (normal[:, 0::2] + 1j * normal[:, 1::2])
    vibration = np.repeat(prepared.fitted.runs.vibration[None], len(numbers), axis=0)
    for reading, (k, s) in enumerate(prepared.cells.tolist()):
        if k >= 0:
            vibration[:, k, s] += noise[:, reading]
    return vibration


def _fit(prepared: Prepared, vibration: ComplexArray) -> tuple[ComplexArray, ComplexArray, BoolArray]:
    """As-found vibration (D, S), coefficients (D, S, P), and which draws determine them well."""
    known = prepared.fitted.runs
    weight = _weights(prepared, vibration)
    scale = np.abs(known.masses).max(axis=0)
    design = np.concatenate([np.ones((len(known.masses), 1)), known.masses / scale], axis=1)
    draws, _, rows = vibration.shape
    normal = np.zeros((draws, rows, design.shape[1], design.shape[1]), dtype=np.complex128)
    right = np.zeros((draws, rows, design.shape[1]), dtype=np.complex128)
    for k, x in enumerate(design):
        square = weight[:, k] ** 2
        normal += square[:, :, None, None] * (x.conj()[:, None] * x[None, :])
        right += (square * np.where(np.isfinite(vibration[:, k]), vibration[:, k], 0.0))[:, :, None] * x.conj()
    used = prepared.used
    solved = np.linalg.solve(normal[:, used], right[:, used, :, None])[..., 0]
    initial = np.asarray(solved[:, :, 0], dtype=np.complex128)
    influence = np.asarray(solved[:, :, 1:] / scale, dtype=np.complex128)
    size = np.sqrt((np.abs(influence) ** 2).sum(axis=1))
    good = np.isfinite(solved).all(axis=(1, 2)) & (size > 0.0).all(axis=1)
    scaled = influence / np.maximum(size, 1e-300)[:, None, :]
    singular = np.linalg.svd(scaled, compute_uv=False)
    enough = influence.shape[1] >= influence.shape[2]
    good &= enough and singular[:, -1] * WORST_CONDITION > singular[:, 0]
    return initial, influence, np.asarray(good)


def _weights(prepared: Prepared, vibration: ComplexArray) -> FloatArray:
    """Weight of each reading (D, K, S), as `fit_influence` gives it: by inverse deviation where all have one."""
    log, known = prepared.log, prepared.fitted.runs
    stated = _stated_scatter(log, prepared)
    present = np.isfinite(known.vibration)
    all_stated = ((stated > 0.0) | ~present).all(axis=0)
    weight = np.empty(vibration.shape)
    bare = replace(known, scatter=stated)
    for draw in range(len(vibration)):
        scatter = with_speed_scatter(replace(bare, vibration=vibration[draw]), prepared.speeds).scatter
        weight[draw] = np.where(present & all_stated, 1.0 / np.where(scatter > 0.0, scatter, 1.0), present)
    largest = weight.max(axis=1, keepdims=True)
    return np.asarray(weight / np.where(largest > 0.0, largest, 1.0), dtype=np.float64)


def _stated_scatter(log: SessionLog, prepared: Prepared) -> FloatArray:
    """Scatter (K, S) that the readings state themselves; nan where they state none."""
    runs = _used(log)
    return mapping.run_set(log.machine, runs, log.run_out, prepared.fitted.rows).scatter


def _least_squares(prepared: Prepared, initial: ComplexArray, influence: ComplexArray) -> ComplexArray:
    """Masses (D, P) that leave the least vibration."""
    inverse = np.linalg.pinv(prepared.weights[None, :, None] * influence)
    masses = np.zeros((len(initial), influence.shape[2]), dtype=np.complex128)
    for s in range(initial.shape[1]):
        masses -= inverse[:, :, s] * (prepared.weights[s] * initial[:, s])[:, None]
    return masses


def _amplitudes(initial: ComplexArray, influence: ComplexArray, masses: ComplexArray) -> FloatArray:
    """Vibration (D, S) left with masses (D, P)."""
    left = initial.copy()
    for p in range(masses.shape[1]):
        left += influence[:, :, p] * masses[:, p, None]
    return np.abs(left)


def _objectives(posed: PlanProblem, initial: ComplexArray, influence: ComplexArray, masses: ComplexArray) -> Objectives:
    """The plan's objective in each draw, weights multiplied in."""
    machine, one = posed.ground.machine, posed.objective
    norm: Norm = one.norm
    if posed.request.objective == "residual_vibration":
        weight = one.weights
        return Objectives(influence * weight[:, None], initial * weight, np.ones(len(weight)), norm)
    radius = np.array([plane.radius_mm for plane in machine.planes])
    if posed.request.objective == "components":
        matrix = np.repeat(one.matrix[None], len(masses), axis=0)
        return Objectives(matrix, -radius * masses, one.weights, norm)
    per_gram = _per_gram(machine, radius)
    start = np.zeros((len(masses), 2), dtype=np.complex128)
    for p in range(masses.shape[1]):
        start -= per_gram[:, p] * masses[:, p, None]
    size = np.abs(start)
    largest = size.max(axis=1, keepdims=True)
    weights = 0.5 / np.where(size < NEGLIGIBLE_REACTION * largest, largest, np.maximum(size, 1e-300))
    return Objectives(per_gram[None] * weights[:, :, None], start * weights, np.ones(2), norm)


def _per_gram(machine: Machine, radius: FloatArray) -> ComplexArray:
    """Bearing reactions (2, P), N per gram."""
    _, bearings, places = mapping.require_geometry(machine)
    speed = angular_speed(machine.service_speed_rpm)
    return np.asarray(reaction_matrix(places, bearings, speed) * radius, dtype=np.complex128)
