"""Worked examples with runs or coefficients and a printed correction; source and tolerance stand with each case."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.balancing.influence.amplitude_only import fit_amplitudes, four_run
from service.balancing.influence.corrections import Correction, CorrectionOptions, least_squares, minimax
from service.balancing.influence.diagnosis.planes import DEPENDENT, significance
from service.balancing.influence.fit import RunSet, fit_influence
from service.balancing.rotor.phasors import ComplexArray, phasor

Case = dict[str, Any]
DATA: dict[str, list[Case]] = json.loads(Path(__file__).with_name("published_runs.json").read_text())
CASES = DATA["cases"] + DATA["special"]


def having(key: str, among: str = "expected") -> list[Any]:
    """The cases with `key`, for parametrize."""
    return [pytest.param(case, id=case["id"]) for case in CASES if key in (case[among] if among else case)]


def vectors(pairs: list[list[float]]) -> ComplexArray:
    return np.array([phasor(amplitude, degrees, "lag") for amplitude, degrees in pairs])


def runs_of(case: Case) -> RunSet:
    if case["kind"] == "matrix":
        masses = np.vstack([np.zeros((1, case["planes"])), np.eye(case["planes"])]).astype(complex)
        vibration = vectors(case["initial"]) + masses @ np.array([vectors(row) for row in case["influence"]]).T
    else:
        masses = np.zeros((len(case["runs"]), case["planes"]), dtype=complex)
        vibration = np.full((len(case["runs"]), case["sensors"]), np.nan, dtype=complex)
        for k, run in enumerate(case["runs"]):
            for mass in run["masses"]:
                masses[k, mass["plane"] - 1] += phasor(mass["mass"], mass["angle_deg"], "lag")
            for reading in run["readings"]:
                vibration[k, reading["sensor"] - 1] = phasor(reading["amplitude"], reading["phase_deg"], "lag")
    if "run_out" in case:
        vibration -= vectors(case["run_out"])
    return RunSet(masses, vibration, np.full(vibration.shape, np.nan))


def corrected(case: Case) -> Correction:
    fit = fit_influence(runs_of(case))
    if case.get("method") == "minimax":
        return minimax(
            fit, None, CorrectionOptions(max_mass=np.array(case["max_mass"]) if "max_mass" in case else None)
        )
    return least_squares(fit)


def agrees(found: ComplexArray, expected: ComplexArray, tolerance: dict[str, float]) -> bool:
    mass = (np.abs(np.abs(found) - np.abs(expected)) <= tolerance["mass_rel"] * np.abs(expected)).all()
    return bool(mass and np.degrees(np.abs(np.angle(found / expected))).max() <= tolerance["angle_deg"])


@pytest.mark.parametrize("case", having("corrections"))
def test_correction_as_published(case: Case) -> None:
    found = corrected(case).masses
    as_printed = agrees(found, vectors(case["expected"]["corrections"]), case["tolerance"])
    if "not_reproduced" not in case:
        assert as_printed
        return
    assert not as_printed
    assert agrees(found, vectors(case["not_reproduced"]["corrections"]), {"mass_rel": 0.001, "angle_deg": 0.1})


@pytest.mark.parametrize("case", having("influence"))
def test_influence_as_published(case: Case) -> None:
    fit = fit_influence(runs_of(case))
    expected = np.array([vectors(row) for row in case["expected"]["influence"]])
    assert (np.abs(fit.influence - expected) < case["tolerance"]["influence_rel"] * np.abs(expected)).all()


@pytest.mark.parametrize("case", having("residuals"))
def test_residuals_as_published(case: Case) -> None:
    found = np.abs(corrected(case).predicted.vibration)
    np.testing.assert_allclose(found, case["expected"]["residuals"], atol=case["tolerance"]["residual_abs"])


@pytest.mark.parametrize("case", having("method", among=""))
def test_published_minimax_is_no_better_than_the_proved_bound(case: Case) -> None:
    found = corrected(case)
    printed = vectors(case["expected"]["corrections"])
    published = np.abs(vectors(case["initial"]) + np.array([vectors(row) for row in case["influence"]]) @ printed).max()
    assert found.lower_bound == pytest.approx(found.objective, rel=1e-8)
    assert found.objective <= published


@pytest.mark.parametrize("case", having("dependent_planes"))
def test_dependent_planes_as_published(case: Case) -> None:
    factor = significance(fit_influence(runs_of(case)).influence)
    assert [int(p) + 1 for p in np.flatnonzero(factor <= DEPENDENT)] == case["expected"]["dependent_planes"]


@pytest.mark.parametrize("case", DATA["amplitude_only"], ids=[case["id"] for case in DATA["amplitude_only"]])
def test_four_runs_without_phase_as_published(case: Case) -> None:
    angles = np.radians([angle for angle, _ in case["trials"]])
    amplitudes = np.array([amplitude for _, amplitude in case["trials"]])
    expected = vectors(case["expected"]["corrections"])
    closed = four_run(case["initial_amplitude"], case["trial_mass"], angles, amplitudes)
    assert agrees(np.array([closed.correction]), expected, case["tolerance"])
    assert closed.trial_effect == pytest.approx(case["expected"]["trial_effect"], abs=0.05)
    masses = np.concatenate([[0.0], case["trial_mass"] * np.exp(1j * angles)])[:, None]
    readings = np.array([case["initial_amplitude"], *amplitudes])[:, None]
    fitted = fit_amplitudes(masses, readings, np.random.default_rng(0))
    assert not fitted.ambiguous
    assert agrees(least_squares(fitted.models[0]).masses, expected, case["tolerance"])
