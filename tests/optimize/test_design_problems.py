"""Modified Jaya on the thesis's five design problems: success rates over independent runs, never a lucky one.

Success is an objective within 0.1 % of the optimum. Rates measured with seeds 1 to 3; each bar below leaves room for
another generator's stream, not for another algorithm.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from service.optimize.jaya import Rules, solve
from service.optimize.problem import FEASIBILITY
from tests.optimize.design_problems import (
    GEAR_TRAIN,
    PRESSURE_VESSEL,
    SPRING,
    TRUSS,
    WELDED_BEAM,
    Design,
)

NEAR = 1.001


@cache
def success(design: Design, members: int, generations: int, runs: int, rules: Rules = "improved") -> float:
    values = solve(design.problem, members, generations, seed=1, runs=runs, rules=rules).values
    assert values.min() >= design.optimum * (1.0 - 1e-8), "better than the proved optimum: the problem is wrong"
    return float((values <= design.optimum * NEAR).mean())


@pytest.mark.parametrize(
    ("design", "digits"),
    [(WELDED_BEAM, 1e-7), (PRESSURE_VESSEL, 1e-9), (TRUSS, 1e-9), (SPRING, 1e-9), (GEAR_TRAIN, 1e-6)],
    ids=["beam", "vessel", "truss", "spring", "gears"],
)
def test_the_equations_give_the_known_optimum(design: Design, digits: float) -> None:
    value, g = design.problem.evaluate(np.array([design.best_x]))
    assert value[0] == pytest.approx(design.optimum, rel=digits)
    assert g.max() <= FEASIBILITY
    assert design.problem.snap(np.array([design.best_x]))[0] == pytest.approx(np.array(design.best_x), rel=1e-12)


def test_welded_beam_by_trying_all_8000_points() -> None:
    grid = np.stack(
        [
            axis.ravel()
            for axis in np.meshgrid(np.arange(1, 11), [1, 2], np.arange(0.5, 10.1, 0.5), np.arange(0.5, 10.1, 0.5))
        ],
        axis=1,
    ).astype(np.float64)
    value, g = WELDED_BEAM.problem.evaluate(grid)
    feasible = (g <= FEASIBILITY).all(axis=1)
    assert len(grid) == 8000
    assert feasible.sum() == 29
    assert np.sort(value[feasible])[:2] == pytest.approx([4.352135, 4.712960], abs=1e-6)


def test_improved_rules_on_each_problem() -> None:
    assert success(WELDED_BEAM, 20, 100, 40) >= 0.95
    assert success(PRESSURE_VESSEL, 30, 1000, 40) >= 0.75
    assert success(TRUSS, 30, 400, 12) >= 0.8
    assert success(SPRING, 30, 1000, 40) >= 0.8
    assert success(GEAR_TRAIN, 100, 1000, 30) >= 0.2


@pytest.mark.parametrize("design", [PRESSURE_VESSEL, SPRING], ids=["vessel", "spring"])
def test_the_printed_rules_are_less_reliable(design: Design) -> None:
    """Why the improved rules are the default: at the same budget the printed ones succeed in one run of ten."""
    printed = success(design, 30, 1000, 40, rules="published")
    assert printed < 0.5
    assert success(design, 30, 1000, 40) > printed + 0.25


def test_the_printed_rules_solve_the_welded_beam() -> None:
    assert success(WELDED_BEAM, 20, 100, 40, rules="published") >= 0.75
