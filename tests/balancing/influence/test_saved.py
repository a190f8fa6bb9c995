"""Saved coefficients: one run, learning within bounds, statistics; trims and pieces combined."""

from __future__ import annotations

import numpy as np
import pytest

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.fit import KNOWN_SCATTER, fit_influence, predict
from service.balancing.influence.saved import SavedInfluence, from_fit, learn, one_run, typical
from service.balancing.influence.trim import combined, saved_mass, trim
from service.errors import NumericsError
from tests.support.numerics.runs import measured, normal, trial_plan

RNG = np.random.default_rng(2)
A = normal(RNG, 3, 2) / 50.0
TRIALS = trial_plan(np.array([60.0, 60.0]))


def test_one_run_balances_the_next_drum() -> None:
    rng = np.random.default_rng(0)
    saved = from_fit(fit_influence(measured(A, normal(rng, 3), TRIALS)))
    v0, present = normal(rng, 3), np.array([30.0, 10.0j])
    fit = one_run(saved, present, v0 + A @ present, np.full(3, np.nan))
    np.testing.assert_allclose(least_squares(fit).masses, np.linalg.lstsq(A, -v0, rcond=None)[0], atol=1e-9)
    assert np.isnan(fit.covariance).all()


def test_one_run_carries_both_scatters() -> None:
    rng = np.random.default_rng(1)
    v0, present, s = normal(rng, 3), np.array([30.0, 10.0j]), 0.02
    told = one_run(
        from_fit(fit_influence(measured(A, v0, TRIALS, scatter=s))), present, v0 + A @ present, np.full(3, s)
    )
    assert told.scatter_dof.tolist() == [KNOWN_SCATTER] * 3
    answers = []
    for _ in range(3000):
        saved = from_fit(fit_influence(measured(A, normal(rng, 3), TRIALS, rng, s)))
        answers.append(one_run(saved, present, v0 + A @ present + s * normal(rng, 3), np.full(3, s)))
    stand = np.array([5.0, -20.0])
    seen = np.array([predict(fit, stand).vibration for fit in answers])
    np.testing.assert_allclose(0.5 * np.var(seen, axis=0), predict(told, stand).scatter ** 2, rtol=0.08)


def test_a_sensor_that_gave_nothing_is_left_out() -> None:
    saved = SavedInfluence(A, np.full((3, 2, 2), np.nan + 0j))
    vibration = np.array([1.0, np.nan, 2.0j])
    fit = one_run(saved, np.zeros(2, complex), vibration, np.full(3, np.nan))
    assert np.isnan(fit.influence[1]).all()
    assert np.abs(predict(fit, least_squares(fit).masses).vibration[[0, 2]]).max() < 1e-9


def test_learning_weighs_by_precision_and_narrows() -> None:
    rng = np.random.default_rng(3)
    precise, poor, learned = [], [], []
    for _ in range(400):
        first = fit_influence(measured(A, normal(rng, 3), TRIALS, rng, 0.005))
        second = fit_influence(measured(A, normal(rng, 3), TRIALS, rng, 0.002))
        result = learn(from_fit(first), second)
        assert not result.refused.any()
        assert result.saved.sessions == 2
        learned.append(np.abs(result.saved.influence - A) ** 2)
        precise.append(np.abs(second.influence - A) ** 2)
        poor.append(np.abs(first.influence - A) ** 2)
    assert np.mean(learned) < np.mean(precise) < np.mean(poor)
    stated = 2.0 * result.saved.covariance.diagonal(axis1=1, axis2=2).real.mean()
    assert np.mean(learned) == pytest.approx(stated, rel=0.1)


@pytest.mark.parametrize("factor", [1.6, 0.4, np.exp(0.9j), 0.0])
def test_learning_is_bounded(factor: complex) -> None:
    saved = from_fit(fit_influence(measured(A, np.ones(3, complex), TRIALS)))
    changed = A.copy()
    changed[1, 0] *= factor
    result = learn(saved, fit_influence(measured(changed, np.ones(3, complex), TRIALS)))
    assert np.argwhere(result.refused).tolist() == [[1, 0]]
    np.testing.assert_allclose(result.saved.influence, A, atol=1e-12)


def test_learning_without_scatter_averages_over_the_sessions() -> None:
    saved = SavedInfluence(A, np.full((3, 2, 2), np.nan + 0j), sessions=3)
    result = learn(saved, fit_influence(measured(1.2 * A, np.ones(3, complex), TRIALS)))
    np.testing.assert_allclose(result.saved.influence, 1.05 * A)


def test_statistics_of_a_type_predict_the_next_machine() -> None:
    rng = np.random.default_rng(5)
    machines = A + 0.003 * normal(rng, 12, 3, 2)
    found = typical(machines)
    assert found.sessions == 12
    np.testing.assert_allclose(found.influence, machines.mean(axis=0))
    spread = found.covariance.diagonal(axis1=1, axis2=2).real
    np.testing.assert_allclose(np.sqrt(spread.mean()), 0.003 * np.sqrt(13.0 / 12.0), rtol=0.15)
    with pytest.raises(NumericsError, match="two machines"):
        typical(machines[:1])


def test_shapes_are_checked() -> None:
    saved = SavedInfluence(A, np.full((3, 2, 2), np.nan + 0j))
    with pytest.raises(
        NumericsError, match=r"one run must have masses \(2,\), vibration and scatter \(3,\), got \(3,\), "
    ):
        one_run(saved, np.zeros(3, complex), np.zeros(3, complex), np.zeros(3))
    with pytest.raises(NumericsError, match="saved"):
        learn(saved, fit_influence(measured(A[:2], np.ones(2, complex), TRIALS)))


def test_trim_and_pieces_of_several_trims() -> None:
    pieces = np.array([100.0, 100.0j, -30.0, 50.0])
    planes = np.array([0, 0, 0, 1])
    np.testing.assert_allclose(combined(pieces, planes, 3), [70.0 + 100.0j, 50.0, 0.0])
    assert saved_mass(pieces, planes, 3) == pytest.approx(1.0 - (abs(70.0 + 100.0j) + 50.0) / 280.0)
    assert saved_mass(pieces[:0], planes[:0], 3) == 0.0
    np.testing.assert_allclose(trim(np.array([5j, 1]), np.array([2.0, 1])), [5j - 2.0, 0.0])
    with pytest.raises(NumericsError, match="every piece must have a plane from 0 to 2, got 3, 3, 3 and 4"):
        combined(pieces, planes + 3, 3)
    with pytest.raises(NumericsError, match="one mass vector per plane"):
        trim(np.zeros(2, complex), np.zeros(3, complex))
