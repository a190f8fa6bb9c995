"""Least-squares corrections and their covariance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.influence.corrections import CorrectionOptions, least_squares, minimax
from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from tests.support.numerics.runs import fits_of_repeated, measured, normal, trial_plan

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
    answers = np.array([least_squares(fit, w).masses for fit in fits_of_repeated(A, v0, masses, rng, 0.01, 4000)])
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
        ([[1, 0], [2, 0]], "masses in plane 2 must move a sensor, got no effect at all", [1]),
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


def random_fit(rng: np.random.Generator, planes: int, sensors: int, scatter: float = 0.0) -> InfluenceFit:
    A, v0 = normal(rng, sensors, planes), normal(rng, sensors)
    return fit_influence(measured(A, v0, trial_plan(np.exp(1j * np.arange(planes))), rng, scatter))


@given(seeds, st.integers(1, 4), st.integers(1, 8), st.booleans())
def test_minimax_is_proved_by_its_dual(seed: int, planes: int, extra: int, limited: bool) -> None:
    rng = np.random.default_rng(seed)
    fit = random_fit(rng, planes, planes + extra)
    w = rng.uniform(0.3, 3.0, planes + extra)
    free = least_squares(fit, w)
    limit = np.abs(free.masses) * rng.uniform(0.3, 1.5, planes) if limited else None
    best = minimax(fit, w, CorrectionOptions(max_mass=limit))
    residual = w * np.abs(best.predicted.vibration)
    assert residual.max() == pytest.approx(best.objective)
    assert best.objective - best.lower_bound <= 1e-6 * best.objective
    if limit is None:
        assert best.objective <= (w * np.abs(free.predicted.vibration)).max() * (1.0 + 1e-9)
    else:
        assert (np.abs(best.masses) <= limit * (1.0 + 1e-9)).all()


@given(seeds, st.integers(1, 3))
def test_no_nearby_masses_beat_a_limited_correction(seed: int, planes: int) -> None:
    rng = np.random.default_rng(seed)
    fit = random_fit(rng, planes, planes + 2)
    limit = np.abs(least_squares(fit).masses) * rng.uniform(0.3, 0.9, planes)
    for method, order in ((least_squares, 2), (minimax, np.inf)):
        best = method(fit, None, CorrectionOptions(max_mass=limit))
        tried = best.masses + normal(rng, 300, planes) * limit * 10.0 ** rng.uniform(-4, 0, (300, 1))
        tried *= np.minimum(1.0, limit / np.abs(tried))
        residuals = np.abs(fit.initial + tried @ fit.influence.T)
        assert (np.linalg.norm(residuals, order, axis=1) >= best.objective * (1.0 - 1e-7)).all()


def test_minimax_reaches_zero_where_the_planes_suffice() -> None:
    fit = random_fit(np.random.default_rng(0), 2, 2)
    assert minimax(fit).objective < 1e-12
    np.testing.assert_allclose(minimax(fit).masses, least_squares(fit).masses)


@given(seeds, st.floats(0.0, 1.0))
def test_damping_trades_mass_for_residual(seed: int, damping: float) -> None:
    fit = random_fit(np.random.default_rng(seed), 2, 4)
    plain, damped = least_squares(fit), least_squares(fit, None, CorrectionOptions(damping=damping))
    assert np.linalg.norm(damped.masses) <= np.linalg.norm(plain.masses) + 1e-12
    assert damped.objective >= plain.objective - 1e-12
    ridge = damping * np.linalg.svd(fit.influence, compute_uv=False)[0]
    slope = fit.influence.conj().T @ damped.predicted.vibration + ridge**2 * damped.masses
    assert np.abs(slope).max() < 1e-9


def test_covariance_of_a_damped_and_restricted_correction_matches_repeated_experiments() -> None:
    rng = np.random.default_rng(11)
    A, v0 = normal(rng, 4, 3), normal(rng, 4)
    masses = trial_plan(np.ones(3))
    wishes = CorrectionOptions(damping=0.3, planes=(0, 2), held=np.array([9.0, 0.4j, 9.0]))
    truth = least_squares(fit_influence(measured(A, v0, masses, scatter=0.01)), None, wishes)
    answers = np.array(
        [least_squares(fit, None, wishes).masses for fit in fits_of_repeated(A, v0, masses, rng, 0.01, 3000)]
    )
    assert (answers[:, 1] == 0.4j).all()
    observed = np.cov(interleaved(answers).T)
    scale = np.sqrt(np.outer(observed.diagonal(), observed.diagonal())) + 1e-12
    assert (np.abs(observed - truth.covariance) < 0.08 * scale).all()


@given(seeds)
def test_restricted_planes_are_those_of_a_smaller_rotor(seed: int) -> None:
    fit = random_fit(np.random.default_rng(seed), 3, 4)
    held = np.array([0.0, 0.5 - 0.2j, 0.0])
    found = least_squares(fit, None, CorrectionOptions(planes=(0, 2), held=held))
    rest = np.linalg.lstsq(fit.influence[:, [0, 2]], -(fit.initial + fit.influence @ held), rcond=None)[0]
    np.testing.assert_allclose(found.masses, [rest[0], held[1], rest[1]], atol=1e-9)


@given(seeds)
def test_parts_mounted_later_are_allowed_for(seed: int) -> None:
    fit = random_fit(np.random.default_rng(seed), 2, 3)
    later = np.array([0.7j, -0.3 + 0j])
    np.testing.assert_allclose(
        least_squares(fit, None, CorrectionOptions(mounted_later=later)).masses,
        least_squares(fit).masses - later,
        atol=1e-9,
    )


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        (CorrectionOptions(max_mass=np.array([1.0])), "max_mass must be 2"),
        (CorrectionOptions(max_mass=np.array([1.0, 0.0])), "above 0"),
        (CorrectionOptions(planes=()), "at least one of 0 to 1"),
        (CorrectionOptions(planes=(0, 2)), "at least one of 0 to 1"),
        (CorrectionOptions(held=np.array([np.nan, 0j])), "held must be 2 finite"),
        (CorrectionOptions(mounted_later=np.array([1j])), "mounted_later must be 2"),
        (CorrectionOptions(damping=-0.1), "damping must be"),
        (CorrectionOptions(damping=0.1), r"damping must not be stated with minimax, got 0\.1"),
    ],
)
def test_wishes_out_of_range_are_refused(wishes: CorrectionOptions, message: str) -> None:
    fit = random_fit(np.random.default_rng(0), 2, 2)
    with pytest.raises(NumericsError, match=message):
        minimax(fit, None, wishes)
