"""Shaft set with three fuzzy aims (Vibroengineering Procedia 4, 2014), on two synthetic cases with known optimum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from service.design.documents import patched, preset
from service.design.optimising import optimise
from service.design.shaft_set.case import read_shaft
from service.design.shaft_set.study import ShaftSetStudy
from service.mechanics.shaft_set import FuzzyGoals, ShaftSet, aims
from service.optimize.differential_search import DifferentialSearch

UTOPIA, CONFLICT = preset("shaft_set_utopia"), preset("shaft_set_conflict")
STUDY = ShaftSetStudy()
PAPER = {"design": {"masses": [1152.05, 898.0, 1151.32], "angles": [83.65, 151.71, 299.43]}}
OPTIMUM = {"design": {"masses": [1217.2652, 988.8740, 1235.8667], "angles": [82.9835, 156.3434, 303.2584]}}
ALONE = {"aim": {"weights": [0.0, 1.0, 0.0]}}


@pytest.mark.parametrize(
    ("document", "energy", "largest", "spread", "h", "tolerance"),
    [
        (UTOPIA, 12737.446865, 62.25556274, 53.34034783, 0.0, 1e-8),
        (patched(UTOPIA, PAPER), 1152.0, 12.0, 0.0, 1.0, 1e-8),
        (CONFLICT, 12919.729688, 64.40139582, 58.30862259, 0.0, 1e-8),
        (patched(CONFLICT, PAPER), 1353.6, 19.2, 14.4, 0.95120628, 1e-8),
        (patched(CONFLICT, OPTIMUM), 1418.49912, 16.42911875, 12.09692928, 0.96201124, 5e-6),
    ],
    ids=["utopia without", "utopia least squares", "conflict without", "conflict least squares", "conflict optimum"],
)
def test_reference_values(
    document: dict[str, Any], energy: float, largest: float, spread: float, h: float, tolerance: float
) -> None:
    simulation = STUDY.simulate(document)
    values = [simulation.value(name) for name in ("energy", "largest", "spread", "h")]
    np.testing.assert_allclose(values, [energy, largest, spread, h], rtol=tolerance, atol=1e-8)


def test_limits_are_those_attainable() -> None:
    for document, best in ((UTOPIA, (1152.0, 12.0, 0.0)), (CONFLICT, (1353.6, 13.00769003, 0.0))):
        case, _ = read_shaft(document)
        assert case is not None
        np.testing.assert_allclose(case.goals.best, best, rtol=1e-9)
        np.testing.assert_allclose(case.goals.worst, aims(case.shaft.initial))
        assert case.shaft.condition == pytest.approx(3.75, abs=0.01)


@pytest.mark.parametrize(
    ("document", "h", "masses", "angles"),
    [
        (UTOPIA, 1.0, [1152.05, 898.0, 1151.32], [83.65, 151.71, 299.43]),
        (CONFLICT, 0.96201124, [1217.2652, 988.8740, 1235.8667], [82.9835, 156.3434, 303.2584]),
    ],
    ids=["utopia", "conflict"],
)
def test_fuzzy_optimum(document: dict[str, Any], h: float, masses: list[float], angles: list[float]) -> None:
    for seed in range(1, 21):
        found = optimise(document, seed=seed, steps=3)
        assert found.value == pytest.approx(h, abs=1e-6)
        assert found.value <= h + 2e-8
        assert found.after.feasible
    after = found.after
    np.testing.assert_allclose([after.value(f"mass.{plane}") for plane in "ABC"], masses, atol=0.05)
    np.testing.assert_allclose([math.degrees(after.value(f"angle.{plane}")) for plane in "ABC"], angles, atol=0.01)


def test_least_largest_vibration_is_proved() -> None:
    found = optimise(patched(CONFLICT, ALONE))
    assert found.result.status == "optimal"
    assert found.after.value("largest") == pytest.approx(15.50191346, rel=1e-5)
    masses = [found.after.value(f"mass.{plane}") for plane in "ABC"]
    np.testing.assert_allclose(masses, [1305.0891, 834.4649, 1200.1311], atol=0.05)


@pytest.mark.parametrize(("document", "least"), [(UTOPIA, 0.9985), (CONFLICT, 0.961)], ids=["utopia", "conflict"])
def test_differential_search_comes_near(document: dict[str, Any], least: float) -> None:
    """The published method, best of five runs; its optimum is never asserted from one."""
    problem = STUDY.problem(document).mixed
    assert problem is not None
    best = 0.0
    for seed in range(8):
        search = DifferentialSearch(problem, 60, np.random.default_rng(seed))
        for _ in range(500):
            state = next(search)
        best = max(best, -state.value)
    assert best >= least - 0.001


def test_h_does_not_change_when_all_is_turned_or_scaled() -> None:
    case, _ = read_shaft(CONFLICT)
    assert case is not None
    w = np.array([700.0 + 300.0j, -500.0j, 900.0 + 0.0j], dtype=np.complex128)
    h = case.goals.h(aims(case.shaft.residual(w)))
    turn = np.exp(0.7j)
    turned = ShaftSet(case.shaft.initial * turn, case.shaft.influence * turn)
    assert FuzzyGoals.of(turned, case.goals.weights).h(aims(turned.residual(w))) == pytest.approx(h, abs=1e-12)
    scaled = ShaftSet(3.0 * case.shaft.initial, case.shaft.influence)
    assert FuzzyGoals.of(scaled, case.goals.weights).h(aims(scaled.residual((3.0 + 0j) * w))) == pytest.approx(
        h, abs=1e-12
    )
    energy, largest, _ = aims(case.shaft.residual(w))
    assert largest**2 <= energy <= 8.0 * largest**2
