"""Intervals cover the truth as often as they say: on the simulated drum, and with pieces placed inexactly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulator.spec import FittedMass, Scatter, true_readings
from service.balancing.influence.corrections import CorrectionOptions, least_squares, minimax
from service.balancing.influence.fit import KNOWN_SCATTER, InfluenceFit, amplitude_interval, fit_influence
from service.balancing.influence.uncertainty import (
    ellipses,
    mass_interval,
    placement_covariance,
    predict_fitted,
    resampled_covariance,
)
from service.balancing.rotor.phasors import ComplexArray
from service.errors import NumericsError
from tests.balancing.influence.diagnosis.sessions import Session
from tests.support.numerics.runs import measured, normal, trial_plan


def drum_session(seed: int) -> tuple[InfluenceFit, Session]:
    """As found and two trials, averaged over many rounds, without drift between runs."""
    scatter = Scatter(amplitude=0.035, phase_deg=2.0)
    session = Session(seed, rounds=16, altered=lambda spec: replace(spec, scatter=scatter))
    trial = session.trial()
    for state in (trial * 0, trial * [1, 0], trial * [0, 1]):
        session.run(state)
    return fit_influence(session.recorded()), session


def truth(session: Session, masses: ComplexArray) -> ComplexArray:
    fitted = [
        FittedMass(plane.name, abs(u), float(np.degrees(np.angle(u))))
        for plane, u in zip(session.spec.planes, masses, strict=True)
        if u != 0
    ]
    readings = true_readings(session.spec, fitted)
    return np.array([a * np.exp(1j * np.radians(phase)) for a, phase in readings.values()])


def test_intervals_cover_the_simulated_drum() -> None:
    residual: list[bool] = []
    prediction: list[bool] = []
    inside: list[bool] = []
    for seed in range(250):
        fit, session = drum_session(seed)
        correction = least_squares(fit)
        # The residual of the correction itself, and a prediction well away from zero.
        for masses, hits in ((correction.masses, residual), (0.6 * correction.masses, prediction)):
            told = predict_fitted(fit, masses, np.zeros((4, 4)))
            low, high = amplitude_interval(told.vibration, told.scatter, told.dof)
            true = np.abs(truth(session, masses))
            hits += list((low <= true) & (true <= high))
        as_found, one, two = (truth(session, masses) for masses in np.array([[0j, 0], [100, 0], [0, 100]]))
        needed = np.linalg.solve(np.stack([one - as_found, two - as_found], axis=1) / 100.0, -as_found)
        drawn = ellipses(correction.masses, correction.covariance, float(fit.scatter_dof.min()))
        away = (needed - drawn.centre) * np.exp(-1j * drawn.turn)
        inside += list((away.real / drawn.major) ** 2 + (away.imag / drawn.minor) ** 2 <= 1.0)
    covered = [float(np.mean(hits)) for hits in (residual, prediction, inside)]
    assert min(covered) >= 0.93, covered
    assert max(covered) <= 0.97, covered


def test_pieces_placed_inexactly_widen_the_prediction_by_as_much() -> None:
    rng = np.random.default_rng(1)
    A, v0 = normal(rng, 3, 2) / 50.0, normal(rng, 3)
    fit = fit_influence(measured(A, v0, trial_plan(np.array([50.0, 50.0])), scatter=1e-9))
    pieces, planes = np.array([100.0, 50.0j, -80.0 + 10.0j]), np.array([0, 0, 1])
    spread = placement_covariance(pieces, planes, 2, mass_sd=1.5, angle_sd=np.radians(3.0))
    turned = pieces * np.exp(1j * np.radians(3.0) * rng.normal(size=(20_000, 3)))
    placed = turned + 1.5 * rng.normal(size=(20_000, 3)) * pieces / np.abs(pieces)
    sums = np.stack([placed[:, :2].sum(axis=1), placed[:, 2]], axis=1)
    flat = np.stack([sums.real, sums.imag], axis=-1).reshape(-1, 4)
    np.testing.assert_allclose(np.cov(flat.T), spread, atol=0.04 * spread.max())
    told = predict_fitted(fit, np.array([pieces[:2].sum(), pieces[2]]), spread)
    seen = v0 + sums @ A.T
    np.testing.assert_allclose(told.scatter**2, 0.5 * np.var(seen, axis=0), rtol=0.05)


def test_ellipse_of_a_known_covariance() -> None:
    covariance = np.diag([4.0, 1.0, 1.0, 1.0])
    found = ellipses(np.array([10.0, 20j]), covariance, KNOWN_SCATTER)
    radius = np.sqrt(-2.0 * np.log(0.05))
    np.testing.assert_allclose(found.major, [2.0 * radius, radius])
    np.testing.assert_allclose(found.minor, [radius, radius])
    assert abs(np.sin(found.turn[0])) < 1e-12
    few = ellipses(np.array([10.0, 20j]), covariance, 2)
    # F(0.95; 2, 2) = 19.
    assert few.minor[0] == pytest.approx(np.sqrt(2.0 * 19.0))


def test_unknown_covariance_stays_unknown() -> None:
    unknown = np.full((4, 4), np.nan)
    found = ellipses(np.array([1.0, 2j]), unknown, 0)
    assert np.isnan([found.major, found.minor, found.turn]).all()
    assert np.isnan(mass_interval(np.array([1.0, 2j]), unknown, 0)).all()


def test_negative_tolerances_are_refused() -> None:
    with pytest.raises(NumericsError, match="tolerances of mass and angle must be 0 or more"):
        placement_covariance(np.array([1.0 + 0j]), np.array([0]), 1, -1.0, 0.0)


def test_resampling_agrees_with_the_derivative_where_there_is_one() -> None:
    rng = np.random.default_rng(4)
    A, v0 = normal(rng, 4, 2) / 50.0, normal(rng, 4)
    fit = fit_influence(measured(A, v0, trial_plan(np.array([50.0, 50.0j])), scatter=0.01))
    stated = least_squares(fit).covariance
    drawn = resampled_covariance(fit, lambda one: least_squares(one).masses, rng, draws=1500)
    scale = np.sqrt(np.outer(stated.diagonal(), stated.diagonal()))
    assert (np.abs(drawn - stated) < 0.12 * scale).all()


def test_resampling_serves_minimax_and_respects_its_limits() -> None:
    rng = np.random.default_rng(6)
    A, v0 = normal(rng, 4, 2) / 50.0, normal(rng, 4)
    fit = fit_influence(measured(A, v0, trial_plan(np.array([50.0, 50.0j])), scatter=0.01))
    assert np.isnan(minimax(fit).covariance).all()
    free = resampled_covariance(fit, lambda one: minimax(one).masses, rng, draws=100)
    limits = CorrectionOptions(max_mass=0.5 * np.abs(minimax(fit).masses))
    held = resampled_covariance(fit, lambda one: minimax(one, None, limits).masses, rng, draws=100)
    assert 0.0 < np.trace(held) < np.trace(free)
    unstated = fit_influence(measured(A, v0, trial_plan(np.array([50.0, 50.0j]))))
    assert np.isnan(resampled_covariance(unstated, lambda one: minimax(one).masses, rng, draws=2)).all()
