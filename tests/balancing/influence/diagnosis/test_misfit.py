"""Leaving a run out without fitting again, against fitting again; and the short cuts against the long way."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.diagnosis import planes
from service.balancing.influence.diagnosis.misfit import misfit_of, worst_miss
from service.balancing.influence.fit import RunSet, fit_influence, predict
from tests.support.numerics.runs import measured, normal, trial_plan

seeds = st.integers(0, 2**32 - 1)


def some_runs(seed: int, stated: bool = True, lost: bool = False) -> RunSet:
    rng = np.random.default_rng(seed)
    masses = np.vstack([trial_plan(np.array([50.0, 50.0])), 40.0 * normal(rng, 4, 2)])
    runs = measured(normal(rng, 3, 2) / 50.0, normal(rng, 3), masses, rng, 0.03, stated)
    if lost:
        runs.vibration[seed % 7, seed % 3] = np.nan
    return runs


@settings(max_examples=30)
@given(seeds, st.booleans(), st.booleans())
def test_what_the_others_predict(seed: int, stated: bool, lost: bool) -> None:
    runs = some_runs(seed, stated, lost)
    misfit = misfit_of(runs, fit_influence(runs))
    assert worst_miss(runs, fit_influence(runs)) == pytest.approx(misfit.relative.max())
    for k in range(len(runs.masses)):
        kept = np.arange(len(runs.masses)) != k
        rest = fit_influence(RunSet(runs.masses[kept], runs.vibration[kept], runs.scatter[kept]))
        missed = runs.vibration[k] - predict(rest, runs.masses[k]).vibration
        np.testing.assert_allclose(misfit.missed[k], missed, atol=1e-9)


@pytest.mark.parametrize("stated", [True, False])
def test_the_statistic_is_chi_square_for_sound_runs(stated: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its mean is its degrees of freedom, for a machine that repeats itself exactly."""
    monkeypatch.setattr("service.balancing.influence.diagnosis.misfit.REPEATABILITY", 0.0)
    found = [misfit_of(runs, fit_influence(runs)) for runs in (some_runs(seed, stated) for seed in range(400))]
    ratio = np.mean([misfit.statistic / misfit.freedom for misfit in found])
    assert ratio == pytest.approx(1.0, abs=0.05)


@given(seeds)
def test_short_cuts_hide_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A = normal(rng, 3, 2) / 50.0
    A[:, 1] = A[:, 0] * rng.normal() + 10.0 ** rng.uniform(-2, 0) * A[:, 1]
    runs = measured(A, normal(rng, 3) * 10.0 ** rng.uniform(-2, 1), trial_plan(np.array([50.0, 50.0])), rng, 0.02)
    fit = fit_influence(runs)
    codes = {finding.code for finding in planes.examine(runs, fit, least_squares(fit), None)}
    weak = planes.significance(fit.influence).min() <= planes.DEPENDENT
    assert ("planes_dependent" in codes) == weak
    mass, residual = planes.damping_trade_off(fit.influence, fit.initial, np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.3]))
    cost = (residual - residual[0]) / np.sqrt((np.abs(fit.initial) ** 2).mean())
    assert ("planes_buck" in codes) == bool(((mass <= 0.5 * mass[0]) & (cost <= 0.05)).any())


@given(seeds)
def test_a_correction_is_in_noise_by_the_full_test_only(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A = normal(rng, 2, 2) / 50.0 + 0.02 * np.eye(2)
    runs = measured(A, normal(rng, 2) * 10.0 ** rng.uniform(-2, 0), trial_plan(np.array([50.0, 50.0])), rng, 0.02)
    correction = least_squares(fit_influence(runs))
    flat = np.stack([correction.masses.real, correction.masses.imag], axis=1).ravel()
    # 99.5 % quantile of chi-square with 4 degrees of freedom.
    expected = flat @ np.linalg.solve(correction.covariance, flat) <= 14.8603
    found = planes.examine(runs, fit_influence(runs), correction, None)
    assert ("correction_in_noise" in {finding.code for finding in found}) == expected
