"""Worked examples with runs or coefficients and a printed correction; source and tolerance stand with each case."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.balancing.corrections import least_squares
from service.balancing.fit import InfluenceFit, RunSet, fit_influence
from service.balancing.phasors import ComplexArray, phasor

CASES: list[dict[str, Any]] = json.loads(Path(__file__).with_name("published_runs.json").read_text())["cases"]


def vectors(pairs: list[list[float]]) -> ComplexArray:
    return np.array([phasor(amplitude, degrees, "lag") for amplitude, degrees in pairs])


def runs_of(case: dict[str, Any]) -> RunSet:
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
    return RunSet(masses, vibration, np.full(vibration.shape, np.nan))


def assert_masses(found: ComplexArray, case: dict[str, Any]) -> None:
    expected, tolerance = vectors(case["expected"]["corrections"]), case["tolerance"]
    np.testing.assert_allclose(np.abs(found), np.abs(expected), rtol=tolerance["mass_rel"])
    assert np.degrees(np.abs(np.angle(found / expected))).max() < tolerance["angle_deg"]


@pytest.mark.parametrize("case", CASES, ids=[case["id"] for case in CASES])
def test_correction_as_published(case: dict[str, Any]) -> None:
    assert_masses(least_squares(fit_influence(runs_of(case))).masses, case)


@pytest.mark.parametrize(
    "case", [case for case in CASES if "influence" in case["expected"]], ids=lambda case: case["id"]
)
def test_influence_as_published(case: dict[str, Any]) -> None:
    fit: InfluenceFit = fit_influence(runs_of(case))
    expected = np.array([vectors(row) for row in case["expected"]["influence"]])
    assert (np.abs(fit.influence - expected) < case["tolerance"]["influence_rel"] * np.abs(expected)).all()
