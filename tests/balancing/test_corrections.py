"""Least-squares corrections and their covariance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.corrections import least_squares
from service.balancing.fit import RunSet, fit_influence
from service.balancing.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from tests.balancing.runs import measured, normal, trial_plan

seeds = st.integers(0, 2**32 - 1)


def interleaved(vector: ComplexArray) -> FloatArray:
    return np.stack([vector.real, vector.imag], axis=-1).reshape(*vector.shape[:-1], -1)


@given(seeds)
def test_two_by_two_is_the_direct_solution(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, v0 = normal(rng, 2, 2) + 3.0 * np.eye(2), normal(rng, 2)
    correction = least_squares(fit_influence(measured(A, v0, trial_plan(normal(rng, 2) + 3.0))))
    np.testing.assert_allclose(correction.masses, np.linalg.solve(A, -v0), atol=1e-8)
    assert np.abs(correction.predicted.vibration).max() < 1e-8


@given(seeds, st.integers(1, 4))
def test_no_other_masses_leave_less_weighted_residual(seed: int, planes: int) -> None:
    rng = np.random.default_rng(seed)
    A, v0, w = normal(rng, planes + 3, planes), normal(rng, planes + 3), rng.uniform(0.2, 5.0, planes + 3)
    correction = least_squares(fit_influence(measured(A, v0, trial_plan(normal(rng, planes) + 3.0))), w)
    residual = w * (v0 + A @ correction.masses)
    assert np.abs((w[:, None] * A).conj().T @ residual).max() < 1e-7 * np.abs(w).max() ** 2


@given(seeds, st.floats(0.0, 360.0))
def test_turning_the_mark_turns_the_masses(seed: int, degrees: float) -> None:
    rng = np.random.default_rng(seed)
    turn = np.exp(1j * np.radians(degrees))
    runs = measured(normal(rng, 3, 2), normal(rng, 3), trial_plan(normal(rng, 2) + 3.0), rng, 0.01)
    masses = least_squares(fit_influence(runs)).masses
    turned = least_squares(fit_influence(RunSet(runs.masses * turn, runs.vibration, runs.scatter))).masses
    np.testing.assert_allclose(turned, masses * turn, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(("sensors", "extra"), [(2, 0), (5, 0), (5, 3)])
def test_covariance_matches_repeated_experiments(sensors: int, extra: int) -> None:
    rng = np.random.default_rng(7)
    A, v0 = normal(rng, sensors, 2) / 50.0, normal(rng, sensors)
    masses = np.vstack([trial_plan(np.array([60.0, 60.0j])), normal(rng, extra, 2) * 40.0])
    w = rng.uniform(0.5, 2.0, sensors)
    truth = fit_influence(measured(A, v0, masses, scatter=0.01))
    answers = np.array(
        [least_squares(fit_influence(measured(A, v0, masses, rng, 0.01)), w).masses for _ in range(4000)]
    )
    observed = np.cov(interleaved(answers).T)
    stated = least_squares(truth, w).covariance
    scale = np.sqrt(np.outer(observed.diagonal(), observed.diagonal()))
    assert (np.abs(observed - stated) < 0.07 * scale).all()
    np.testing.assert_allclose(stated, stated.T, atol=1e-12)


def test_unknown_scatter_leaves_the_covariance_unknown() -> None:
    rng = np.random.default_rng(8)
    correction = least_squares(fit_influence(measured(normal(rng, 2, 2), normal(rng, 2), trial_plan(np.ones(2)))))
    assert np.isnan(correction.covariance).all()


def test_a_sensor_left_out_counts_for_nothing() -> None:
    rng = np.random.default_rng(9)
    runs = measured(normal(rng, 3, 2), normal(rng, 3), trial_plan(np.ones(2)), rng, 0.01)
    runs.vibration[1, 0] = np.nan
    correction = least_squares(fit_influence(runs, incomplete="leave_out"))
    fewer = least_squares(fit_influence(RunSet(runs.masses, runs.vibration[:, 1:], runs.scatter[:, 1:])))
    np.testing.assert_allclose(correction.masses, fewer.masses)
    np.testing.assert_allclose(correction.covariance, fewer.covariance)
    assert np.isnan(correction.predicted.vibration[0])


@pytest.mark.parametrize(
    ("influence", "message", "planes"),
    [
        ([[1, 2], [1, 2]], "plane 1 and plane 2 act alike on the 2 sensors", [0, 1]),
        ([[1, 2]], "act alike on the 1 sensors", [0, 1]),
        ([[1, 0], [2, 0]], "plane 2 move no sensor", [1]),
        ([[1, 5, 2], [1, 3j, 2], [1, 0, 2]], "plane 1 and plane 3 act alike", [0, 2]),
    ],
)
def test_dependent_planes_are_refused_by_name(influence: list[list[complex]], message: str, planes: list[int]) -> None:
    A = np.array(influence, dtype=complex)
    fit = fit_influence(measured(A, np.ones(len(A), complex), trial_plan(np.ones(A.shape[1]))))
    with pytest.raises(NumericsError, match=message) as caught:
        least_squares(fit)
    assert caught.value.code == "planes_dependent"
    assert caught.value.value == planes


@pytest.mark.parametrize("weights", [[1.0], [0.0, 0.0], [1.0, -1.0], [1.0, np.nan]])
def test_bad_weights_are_refused(weights: list[float]) -> None:
    fit = fit_influence(measured(np.eye(2, dtype=np.complex128), np.ones(2, complex), trial_plan(np.ones(2))))
    with pytest.raises(NumericsError, match="weights must be 2"):
        least_squares(fit, np.array(weights))
