"""The whole way from runs to findings: several speeds, lost readings, bad input."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from service.balancing.influence.analysis import analyse
from service.balancing.influence.corrections import CorrectionOptions, least_squares
from service.balancing.influence.diagnosis.findings import RunConditions
from service.balancing.influence.fit import RunSet
from service.balancing.rotor.labels import Labels
from service.balancing.rotor.phasors import ComplexArray
from service.errors import NumericsError
from tests.support.numerics.runs import measured, normal, trial_plan

TRIALS = trial_plan(np.array([60.0, 60.0j]))


def two_speeds(rng: np.random.Generator) -> tuple[RunSet, ComplexArray, ComplexArray]:
    """Two sensors at two speeds: as found and trials at each, in separate runs, and a check at the first."""
    A, v0 = normal(rng, 4, 2) / 50.0, normal(rng, 4) * 3.0
    masses = np.vstack([TRIALS, TRIALS, [[-20.0, 30.0j]]])
    runs = measured(A, v0, masses, rng, 0.01)
    runs.vibration[3:6, :2] = np.nan
    runs.vibration[:3, 2:] = np.nan
    runs.vibration[6, 2:] = np.nan
    return RunSet(runs.masses, runs.vibration, np.where(np.isnan(runs.vibration), np.nan, 0.01)), A, v0


def test_several_speeds_are_several_rows() -> None:
    runs, A, v0 = two_speeds(np.random.default_rng(0))
    nominal = np.array([460.0, 460.0, 900.0, 900.0])
    speed = np.where(np.isnan(runs.vibration), np.nan, nominal)
    for known in (RunConditions(speed_rpm=speed, nominal_rpm=nominal), RunConditions(speed_rpm=speed)):
        assert analyse(runs, circumstances=known).findings == ()
    speed[4] *= 1.04
    analysis = analyse(runs, circumstances=RunConditions(speed_rpm=speed, nominal_rpm=nominal))
    assert [(finding.code, finding.runs) for finding in analysis.findings] == [("speed_drift", (4,))]
    assert np.abs(analysis.fit.influence - A).max() < 0.002
    expected = np.linalg.lstsq(A, -v0, rcond=None)[0]
    assert np.abs(analysis.correction.masses - expected).max() < 0.05 * np.abs(expected).max()
    assert analysis.fit.dof.tolist() == [2, 2, 0, 0]


@pytest.mark.parametrize("stated", [True, False])
def test_a_lost_reading_is_survived_without_a_warning(stated: bool) -> None:
    rng = np.random.default_rng(1)
    A, v0 = normal(rng, 3, 2) / 50.0, normal(rng, 3) * 3.0
    for k in range(3):
        for s in range(3):
            runs = measured(A, v0, TRIALS, rng, 0.01, stated)
            runs.vibration[k, s] = np.nan
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                analysis = analyse(
                    runs, CorrectionOptions(weights=np.ones(3)), circumstances=RunConditions(overall=np.ones((3, 3)))
                )
            assert [f.sensors for f in analysis.findings if f.code == "sensor_incomplete"] == [(s,)]
            assert np.isfinite(analysis.correction.masses).all()


def codes(runs: RunSet) -> list[str]:
    return [finding.code for finding in analyse(runs).findings]


def test_same_masses_ten_sigma_apart_are_named() -> None:
    rng = np.random.default_rng(2)
    A, v0 = normal(rng, 2, 2) / 50.0, np.array([3.0, 2.0j])
    runs = measured(A, v0, np.vstack([TRIALS, TRIALS[1:2]]), rng, 0.01)
    assert codes(runs) == []
    runs.vibration[3, 1] = runs.vibration[1, 1] + 0.1
    labels = Labels(runs=("as found", "left", "right", "left again"), sensors=("P", "Q"))
    (finding,) = analyse(RunSet(runs.masses, runs.vibration, runs.scatter, labels)).findings
    assert (finding.code, finding.severity, finding.runs, finding.sensors) == ("runs_contradict", "error", (1, 3), (1,))
    assert 'run "left" and run "left again" have the same masses, yet their readings of sensor "Q"' in finding.message


@pytest.mark.parametrize(
    ("masses", "code"),
    [
        (TRIALS[:1], "too_few_runs"),
        (TRIALS * 0, "too_few_runs"),
        (TRIALS[[0, 1]], "too_few_runs"),
        (np.vstack([TRIALS[:1], [[5, 5], [9, 9]]]).astype(np.complex128), "planes_not_separated"),
    ],
)
def test_too_little_to_go_by_is_refused(masses: ComplexArray, code: str) -> None:
    rng = np.random.default_rng(3)
    with pytest.raises(NumericsError) as caught:
        analyse(measured(normal(rng, 2, 2), normal(rng, 2), masses))
    assert caught.value.code == code
    assert caught.value.advice


def test_one_sensor_for_two_planes_is_refused_with_advice() -> None:
    rng = np.random.default_rng(4)
    with pytest.raises(NumericsError, match="act alike on the 1 sensors"):
        analyse(measured(normal(rng, 1, 2), normal(rng, 1), TRIALS, rng, 0.01))


def test_a_dead_sensor_is_named_as_the_cause() -> None:
    rng = np.random.default_rng(5)
    runs = measured(normal(rng, 2, 2), normal(rng, 2), TRIALS, rng, 0.01)
    runs.vibration[:, 1] = 0.0
    with pytest.raises(NumericsError, match="sensor 2 reads zero in all 3 runs; therefore") as caught:
        analyse(runs)
    assert caught.value.code == "sensor_silent"


def test_minimax_is_a_method_of_its_own() -> None:
    rng = np.random.default_rng(6)
    runs = measured(normal(rng, 4, 2) / 50.0, normal(rng, 4), TRIALS, rng, 0.01)
    least, greatest = analyse(runs), analyse(runs, method="minimax")
    assert np.abs(greatest.correction.predicted.vibration).max() < np.abs(least.correction.predicted.vibration).max()
    np.testing.assert_allclose(least.correction.masses, least_squares(least.fit).masses)


@pytest.mark.parametrize(("measured_rpm", "warned"), [(1200.0, True), (1480.0, False), (1600.0, True)])
def test_one_measured_speed_that_is_not_the_nominal_one_is_warned_of(measured_rpm: float, warned: bool) -> None:
    vibration = np.array([[5.0 + 1.0j], [4.0 + 2.0j]])
    runs = RunSet(np.array([[0.0j], [12.0 + 0.0j]]), vibration, np.full((2, 1), 0.05))
    known = RunConditions(speed_rpm=np.array([[np.nan], [measured_rpm]]), nominal_rpm=np.array([1500.0]))
    codes = [finding.code for finding in analyse(runs, circumstances=known).findings]
    assert ("speed_off_nominal" in codes) == warned
