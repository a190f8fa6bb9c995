"""The scatter that differing speeds add, against the simulated drum, whose mechanics know the true dependence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulator.example import threshing_drum_example
from drivers.simulator.spec import DrumSpec, FittedMass, true_readings
from service.balancing.influence.corrections import least_squares
from service.balancing.influence.fit import RunSet, amplitude_interval, fit_influence, predict
from service.balancing.influence.speed_scatter import SENSITIVITY, with_speed_scatter
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from tests.balancing.influence.diagnosis.sessions import Session

SEEDS = range(7000, 7200)
"""Drawn for this test only."""


def drifting(spec: DrumSpec) -> DrumSpec:
    """With the scatter of the drum as delivered: 3 % and 2 degrees a reading, 0.5 % of the speed between runs."""
    return replace(spec, scatter=threshing_drum_example().scatter)


def widened(session: Session) -> RunSet:
    return with_speed_scatter(session.recorded(), session.circumstances().speed_rpm)


def sigmas(before: RunSet, checked: RunSet, masses: ComplexArray) -> FloatArray:
    """Distance of the check run, the last, from what the runs before predict, in standard deviations of a vector."""
    told = predict(fit_influence(before), masses, checked.scatter[-1])
    return np.asarray(np.abs(checked.vibration[-1] - told.vibration) / (np.sqrt(2.0) * told.scatter))


def truth(session: Session, masses: ComplexArray, speed_rpm: float) -> FloatArray:
    """Amplitudes (S,) that nothing scatters."""
    fitted = [
        FittedMass(plane.name, abs(u), float(np.degrees(np.angle(u))))
        for plane, u in zip(session.spec.planes, masses, strict=True)
    ]
    return np.array([amplitude for amplitude, _ in true_readings(session.spec, fitted, speed_rpm=speed_rpm).values()])


def test_check_runs_and_intervals_on_a_drum_whose_speed_differs_from_run_to_run() -> None:
    away, unaware, inside = [], [], []
    for seed in SEEDS:
        session = Session(seed, rounds=16, altered=drifting)
        trial = session.trial()
        for state in (trial * 0, trial * [1, 0], trial * [0, 1]):
            session.run(state)
        plain, known = session.recorded(), widened(session)
        fit = fit_influence(known)
        masses = least_squares(fit).masses
        reference = float(np.median(session.circumstances().speed_rpm, axis=0)[0])  # type: ignore[arg-type]
        session.run(masses, check=True)
        away += list(sigmas(known, widened(session), masses))
        unaware += list(sigmas(plain, session.recorded(), masses))
        for share in (1.0, 0.6):
            told = predict(fit, share * masses)
            low, high = amplitude_interval(told.vibration, told.scatter, told.dof)
            true = truth(session, share * masses, reference)
            inside += list((low <= true) & (true <= high))
    assert np.mean(np.array(away) > 3.0) <= 0.01
    assert 0.93 <= np.mean(inside) <= 0.97
    # What the scatter of a mean alone would say of the same runs.
    assert np.mean(np.array(unaware) > 3.0) > 0.03


@pytest.mark.parametrize("speed", [300.0, 460.0, 700.0])
def test_the_sensitivity_is_that_of_the_drum_below_its_resonance(speed: float) -> None:
    drum = threshing_drum_example()
    slow, fast = (true_readings(drum, speed_rpm=speed * factor) for factor in (0.995, 1.005))
    for sensor in slow:
        change = (fast[sensor][0] - slow[sensor][0]) / (0.5 * (fast[sensor][0] + slow[sensor][0]))
        assert change / 0.01 == pytest.approx(SENSITIVITY, abs=1.0)


def runs(scatter: float = 0.01) -> RunSet:
    vibration = np.array([[1.0, 2j], [3.0, 1.0], [2.0, np.nan]])
    return RunSet(np.array([[0], [5], [5j]], dtype=complex), vibration, np.full((3, 2), scatter))


def test_a_run_off_the_others_speed_is_believed_less() -> None:
    speed = np.array([[460.0, 460.0], [464.6, 464.6], [460.0, np.nan]])
    found = with_speed_scatter(runs(), speed)
    expected = np.hypot(0.01, SENSITIVITY / np.sqrt(2.0) * 0.01 * 3.0)
    # The other sensor was measured at two speeds only: its median lies half way.
    half = np.hypot(0.01, SENSITIVITY / np.sqrt(2.0) * (2.3 / 462.3) * np.array([2.0, 1.0]))
    np.testing.assert_allclose(found.scatter, [[0.01, half[0]], [expected, half[1]], [0.01, 0.01]])
    np.testing.assert_array_equal(found.vibration, runs().vibration)


def test_against_a_speed_that_is_given() -> None:
    found = with_speed_scatter(runs(), np.full((3, 2), 464.6), 460.0)
    assert found.scatter[0, 0] == pytest.approx(np.hypot(0.01, SENSITIVITY / np.sqrt(2.0) * 0.01))


@pytest.mark.parametrize("speed", [None, np.full((3, 2), 455.0), np.full((3, 2), np.nan)])
def test_equal_or_unknown_speeds_change_nothing(speed: FloatArray | None) -> None:
    np.testing.assert_array_equal(with_speed_scatter(runs(), speed).scatter, runs().scatter)


@pytest.mark.parametrize("unknown", [0.0, np.nan])
def test_a_scatter_that_is_not_stated_stays_unknown(unknown: float) -> None:
    speed = np.array([[460.0, 460.0], [464.6, 464.6], [460.0, 455.0]])
    np.testing.assert_array_equal(with_speed_scatter(runs(unknown), speed).scatter, np.full((3, 2), unknown))
