"""The affine fit: exact recovery, invariances, weights, missing readings, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.fit import KNOWN_SCATTER, RunSet, fit_influence, predict
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray
from service.errors import NumericsError
from tests.support.numerics.runs import fits_of_repeated, measured, normal, trial_plan

seeds = st.integers(0, 2**32 - 1)


def truth(seed: int, planes: int, sensors: int) -> tuple[ComplexArray, ComplexArray]:
    """Random coefficients (sensors, planes) per g and vibration as found (sensors,)."""
    rng = np.random.default_rng(seed)
    return normal(rng, sensors, planes) / 50.0, normal(rng, sensors)


def rotor(seed: int, planes: int, sensors: int, runs: int, scatter: float = 0.0, stated: bool = True) -> RunSet:
    """Runs that take masses out, leave them in and repeat."""
    rng = np.random.default_rng([seed, 1])
    trial = 50.0 * np.exp(2j * np.pi * rng.random(planes))
    masses = np.vstack([trial_plan(trial), 50.0 * normal(rng, runs, planes)])[:runs]
    return measured(*truth(seed, planes, sensors), masses, rng, scatter, stated)


@given(seeds, st.integers(1, 4), st.integers(1, 8), st.integers(0, 5))
def test_recovers_exactly_without_noise(seed: int, planes: int, sensors: int, extra: int) -> None:
    fit = fit_influence(rotor(seed, planes, sensors, planes + 1 + extra))
    influence, initial = truth(seed, planes, sensors)
    np.testing.assert_allclose(fit.influence, influence, atol=1e-12)
    np.testing.assert_allclose(fit.initial, initial, atol=1e-10)
    assert np.abs(fit.residuals).max() < 1e-10


@given(seeds, st.floats(0.0, 360.0), st.floats(0.0, 360.0))
def test_turning_the_mark_or_a_sensor_turns_the_answer(seed: int, mark: float, pick_up: float) -> None:
    """Another zero of the mass angles turns A back; another zero of the phases turns A and v0."""
    runs = rotor(seed, 2, 3, 5, scatter=0.02)
    m, p = np.exp(1j * np.radians(mark)), np.exp(1j * np.radians(pick_up))
    fit, turned = fit_influence(runs), fit_influence(RunSet(runs.masses * m, runs.vibration * p, runs.scatter))
    np.testing.assert_allclose(turned.influence, fit.influence * p / m, atol=1e-10)
    np.testing.assert_allclose(turned.initial, fit.initial * p, atol=1e-10)
    np.testing.assert_allclose(np.abs(turned.covariance), np.abs(fit.covariance), rtol=1e-6, atol=1e-14)


@given(seeds)
def test_mirroring_both_senses_conjugates_the_answer(seed: int) -> None:
    runs = rotor(seed, 2, 3, 5, scatter=0.02)
    fit = fit_influence(runs)
    mirrored = fit_influence(RunSet(runs.masses.conj(), runs.vibration.conj(), runs.scatter))
    np.testing.assert_allclose(mirrored.influence, fit.influence.conj(), atol=1e-10)
    np.testing.assert_allclose(mirrored.covariance, fit.covariance.conj(), atol=1e-12)


@given(seeds, st.floats(0.01, 100.0))
def test_units_scale_through(seed: int, factor: float) -> None:
    runs = rotor(seed, 2, 2, 4, scatter=0.05)
    fit = fit_influence(runs)
    other = fit_influence(RunSet(runs.masses * factor, runs.vibration * 10.0, runs.scatter * 10.0))
    np.testing.assert_allclose(other.influence, fit.influence * 10.0 / factor, rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(other.initial, fit.initial * 10.0, rtol=1e-8)


@given(seeds)
def test_agrees_with_the_direct_two_plane_solution(seed: int) -> None:
    """Each trial's change over its mass, the textbook's coefficient."""
    runs = rotor(seed, 2, 2, 3)
    direct = np.stack([(runs.vibration[k] - runs.vibration[0]) / runs.masses[k, k - 1] for k in (1, 2)], axis=1)
    np.testing.assert_allclose(fit_influence(runs).influence, direct, atol=1e-10)


def test_repetitions_fitted_together_are_those_fitted_one_by_one() -> None:
    A, v0, masses = np.array([[0.1, 0.2j], [0.3j, 0.1]]), np.array([1.0, 2j]), trial_plan(np.array([40.0, 40.0j]))
    several = list(fits_of_repeated(A, v0, masses, np.random.default_rng(5), 0.05, 3))
    runs = measured(np.tile(A, (3, 1)), np.tile(v0, 3), masses, np.random.default_rng(5), 0.05)
    for number, fit in enumerate(several):
        mine = slice(2 * number, 2 * number + 2)
        alone = fit_influence(RunSet(masses, runs.vibration[:, mine], runs.scatter[:, mine]))
        np.testing.assert_allclose(fit.influence, alone.influence, rtol=1e-12)
        np.testing.assert_allclose(fit.covariance, alone.covariance, rtol=1e-12)
        np.testing.assert_allclose(least_squares(fit).masses, least_squares(alone).masses, rtol=1e-9)


def test_covariance_matches_the_scatter_of_repeated_experiments() -> None:
    rng = np.random.default_rng(3)
    A, v0 = normal(rng, 1, 2) / 50.0, normal(rng, 1)
    masses = np.array([[0, 0], [40, 0], [40, 30j], [0, 30], [20, 20]], dtype=complex)
    fits = list(fits_of_repeated(A, v0, masses, rng, 0.05, 4000))
    errors = np.array([np.concatenate([f.initial - v0, f.influence[0] - A[0]]) for f in fits])
    observed = np.einsum("ni,nj->ij", errors, errors.conj()) / (2 * len(errors))
    scale = np.sqrt(np.outer(observed.diagonal().real, observed.diagonal().real))
    assert (np.abs(observed - fits[0].covariance[0]) < 0.06 * scale).all()


def test_residual_variance_is_unbiased_where_no_scatter_is_stated() -> None:
    rng = np.random.default_rng(4)
    masses = np.vstack([trial_plan(np.array([40.0, 40.0])), [[30, 20], [10, 50]]]).astype(complex)
    A, v0 = normal(rng, 1, 2) / 50.0, normal(rng, 1)
    stated = fit_influence(measured(A, v0, masses, rng, 0.05)).covariance[0, 0, 0].real
    fits = list(fits_of_repeated(A, v0, masses, rng, 0.05, 3000, stated=False))
    assert np.mean([f.covariance[0, 0, 0].real for f in fits]) == pytest.approx(stated, rel=0.06)
    assert fits[0].dof.tolist() == [4]
    assert fits[0].scatter_dof.tolist() == [4]


def test_a_precise_run_weighs_more() -> None:
    masses = np.array([[0], [0], [10]], dtype=complex)
    runs = RunSet(masses, np.array([[1.0], [2.0], [3.0]]) + 0j, np.array([[0.1], [0.3], [0.1]]))
    assert fit_influence(runs).initial[0] == pytest.approx(1.1)


def test_scatter_far_below_the_residuals_is_not_believed() -> None:
    masses = np.array([[0], [0], [10], [10]], dtype=complex)
    readings = np.array([[1.0], [1.5], [3.0], [3.6]]) + 0j
    fit = fit_influence(RunSet(masses, readings, np.full((4, 1), 0.01)))
    assert fit.scatter_dof.tolist() == [4]
    unweighted = fit_influence(RunSet(masses, readings, np.full((4, 1), np.nan)))
    np.testing.assert_allclose(fit.covariance, unweighted.covariance)


def test_no_scatter_and_no_freedom_leave_the_interval_unknown() -> None:
    fit = fit_influence(rotor(0, 2, 2, 3))
    assert np.isnan(fit.covariance).all()
    prediction = predict(fit, np.array([1 + 0j, 2j]))
    assert np.isnan(prediction.scatter).all()
    assert np.isfinite(prediction.vibration).all()
    assert prediction.dof.tolist() == [0, 0]


def test_a_missing_reading_costs_its_sensor_only() -> None:
    runs = rotor(5, 2, 3, 5, scatter=0.01)
    vibration = runs.vibration.copy()
    vibration[2, 1] = np.nan
    scatter = runs.scatter.copy()
    scatter[2, 1] = np.nan
    whole, fit = fit_influence(runs), fit_influence(RunSet(runs.masses, vibration, scatter))
    np.testing.assert_allclose(fit.influence[[0, 2]], whole.influence[[0, 2]])
    alone = fit_influence(
        RunSet(np.delete(runs.masses, 2, 0), np.delete(runs.vibration, 2, 0), np.delete(runs.scatter, 2, 0))
    )
    np.testing.assert_allclose(fit.influence[1], alone.influence[1])
    np.testing.assert_allclose(fit.covariance[1], alone.covariance[1])
    assert fit.dof.tolist() == [4, 2, 4]
    assert fit.scatter_dof.tolist() == [KNOWN_SCATTER] * 3
    assert np.isnan(fit.residuals[2, 1])


def test_a_sensor_without_enough_readings_is_refused_or_left_out() -> None:
    runs = rotor(6, 2, 3, 3, scatter=0.01)
    vibration = runs.vibration.copy()
    vibration[1, 0] = np.nan
    short = RunSet(runs.masses, vibration, runs.scatter, Labels(("as found", "left", "right"), ("L", "R"), ("A",)))
    with pytest.raises(
        NumericsError, match='sensor "A" gave no reading in run "left", and without it some run must be without'
    ) as caught:
        fit_influence(short)
    assert caught.value.advice == 'add a run with a different mass in plane "L" and nothing else changed'
    fit = fit_influence(short, incomplete="leave_out")
    assert np.isnan(fit.influence[0]).all()
    assert np.isnan(fit.initial[0])
    np.testing.assert_allclose(fit.influence[1:], fit_influence(runs).influence[1:])
    assert np.isfinite(fit.condition)


def stated(*rows: list[complex]) -> ComplexArray:
    return np.array(rows, dtype=complex)


READ = stated([1, 1], [2, 2], [3, 3])
SOUND = stated([0, 0], [5, 0], [0, 5])


@pytest.mark.parametrize(
    ("masses", "vibration", "message", "code"),
    [
        (
            SOUND * 0,
            READ,
            "each plane must have a mass in some run, got none in plane 1 and plane 2 in 3 runs",
            "too_few_runs",
        ),
        (
            stated([0, 0], [5, 0], [5j, 0]),
            READ,
            "each plane must have a mass in some run, got none in plane 2 in 3 runs",
            "too_few_runs",
        ),
        (
            SOUND[:1],
            READ[:1],
            "each plane must have a mass in some run, got none in plane 1 and plane 2 in 1 runs",
            "too_few_runs",
        ),
        (
            stated([0, 0], [5, 7]),
            READ[:2],
            "the runs must tell plane 1 and plane 2 apart, got 2 runs for 3 unknowns that do not",
            "too_few_runs",
        ),
        (
            stated([0, 0], [5, 7], [10, 14]),
            READ,
            "the runs must tell plane 1 and plane 2 apart, got 3 runs for 3 unknowns that do not",
            "planes_not_separated",
        ),
        (
            stated([5, 7], [5, 7], [5, 7]),
            READ,
            "the runs must differ in their masses, got the same in all 3",
            "planes_not_separated",
        ),
        (
            stated([3, 0], [3, 5], [3, 9]),
            READ,
            "some run must be without the mass in plane 1: otherwise its influence is not known",
            "planes_not_separated",
        ),
        (stated([0, 0], [np.nan, 0], [0, 5]), READ, "the mass of run 2 in plane 1", "numerics"),
        (SOUND, READ * 0, "all readings are zero", "all_readings_zero"),
        (SOUND, READ * np.nan, "all readings are zero or missing", "all_readings_zero"),
        (SOUND, stated([1, 1], [2, np.inf], [3, 3]), "reading of sensor 2 in run 2", "numerics"),
        (SOUND, READ[:2], "runs must be masses", "numerics"),
        (SOUND[:0], READ[:0], "there must be at least one run, plane and sensor, got 0, 2 and 2", "numerics"),
    ],
)
def test_runs_that_cannot_be_solved_say_what_to_do(
    masses: ComplexArray, vibration: ComplexArray, message: str, code: str
) -> None:
    with pytest.raises(NumericsError, match=message) as caught:
        fit_influence(RunSet(masses, vibration, np.full(vibration.shape, np.nan)))
    assert caught.value.code == code


def test_dependent_planes_are_named_by_index() -> None:
    masses = np.array([[0, 0, 0], [5, 0, 2], [0, 3, 0], [10, 0, 4]], dtype=complex)
    with pytest.raises(NumericsError, match="plane 1 and plane 3") as caught:
        fit_influence(RunSet(masses, np.ones((4, 1), complex), np.full((4, 1), np.nan)))
    assert caught.value.value == [0, 2]


def test_negative_scatter_is_refused() -> None:
    with pytest.raises(NumericsError, match="scatter"):
        fit_influence(RunSet(np.array([[0], [5 + 0j]]), np.ones((2, 1), complex), np.array([[0.1], [-0.1]])))


def test_prediction_needs_one_mass_per_plane() -> None:
    fit = fit_influence(rotor(0, 2, 2, 3))
    with pytest.raises(NumericsError, match="2 finite vectors"):
        predict(fit, np.array([1 + 0j]))


@settings(max_examples=20)
@given(seeds)
def test_reading_scatter_adds_in_squares(seed: int) -> None:
    fit = fit_influence(rotor(seed, 2, 2, 3, scatter=0.03))
    true, next_reading = predict(fit, np.array([9j, 4])), predict(fit, np.array([9j, 4]), reading_scatter=0.04)
    np.testing.assert_allclose(next_reading.scatter**2, true.scatter**2 + 0.04**2)
