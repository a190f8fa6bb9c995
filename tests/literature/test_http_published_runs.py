"""Published worked examples posed to the service over HTTP; source and tolerance stand with each case.

A matrix case is posed as noise-free runs with 1 g at 0 degrees in each plane. The case without phase (SPM A2010, four
runs) stands in test_http_amplitude_only.
"""

from __future__ import annotations

import cmath
import json
import math
from pathlib import Path
from typing import Any

import pytest

from tests.support.http.workshop import LinearDrum, Workshop, mass, vector_of

DATA: dict[str, list[dict[str, Any]]] = json.loads(Path(__file__).with_name("published_runs.json").read_text())
CASES = DATA["cases"] + [case for case in DATA["special"] if "not_reproduced" not in case]


def vector(pair: list[float]) -> complex:
    return cmath.rect(pair[0], math.radians(pair[1]))


def session_of(shop: Workshop, case: dict[str, Any]) -> str:
    """A session with the case's runs, its planes and sensors numbered from 1."""
    planes = [str(p + 1) for p in range(case["planes"])]
    sensors = [str(s + 1) for s in range(case["sensors"])]
    ring = {"radius_mm": 100.0, "positions_deg": [0.0], "max_masses": 1}
    machine = shop.machine(
        bearings=[], planes=[{"name": p, **ring} for p in planes], sensors=[{"name": s} for s in sensors]
    )
    run_out = [
        {"sensor": name, "amplitude": amplitude, "phase_deg": degrees}
        for name, (amplitude, degrees) in zip(sensors, case.get("run_out", []), strict=False)
    ]
    session = shop.session(machine, run_out=run_out)
    if case["kind"] == "matrix":
        initial = dict(zip(sensors, map(vector, case["initial"]), strict=True))
        influence = {
            (s, p): vector(case["influence"][i][j]) for i, s in enumerate(sensors) for j, p in enumerate(planes)
        }
        shop.learn(session, LinearDrum(initial, influence), grams=1.0)
        return session
    for run in case["runs"]:
        body = {
            "kind": "trial" if run["masses"] else "initial",
            "masses": [mass(str(m["plane"]), m["mass"], m["angle_deg"]) for m in run["masses"]],
            "readings": [{**r, "sensor": str(r["sensor"])} for r in run["readings"]],
        }
        shop.post(f"/sessions/{session}/runs", body)
    return session


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["id"])
def test_correction_and_influence_as_published(shop: Workshop, case: dict[str, Any]) -> None:
    asked: dict[str, Any] = {"method": case["method"]} if "method" in case else {}
    if "max_mass" in case:
        (asked["max_mass_g"],) = set(case["max_mass"])
    correction = shop.correct(session_of(shop, case), **asked)
    tolerance = case["tolerance"]
    for found, (grams, degrees) in zip(correction["corrections"], case["expected"]["corrections"], strict=True):
        assert found["mass_g"] == pytest.approx(grams, rel=tolerance["mass_rel"])
        turned = vector_of(found, "mass_g", "angle_deg") / vector([grams, degrees])
        assert abs(math.degrees(cmath.phase(turned))) < tolerance["angle_deg"]
    for row, published in zip(correction["influence"], case["expected"].get("influence", []), strict=False):
        for coefficient, pair in zip(row, published, strict=True):
            away = abs(vector_of(coefficient, "amplitude_per_g") - vector(pair))
            assert away < tolerance["influence_rel"] * pair[0]
