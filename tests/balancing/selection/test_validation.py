"""Every rule of a selection problem is refused by name, value and advice."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.jaya import solve_jaya
from service.balancing.selection.problem import Norm, SelectionProblem
from service.balancing.selection.validation import validate
from service.errors import NumericsError
from tests.support.numerics.problems import field_experiment, plane, thesis_rotor

GOOD = field_experiment(2)
OBJECTIVE, PLANE, STOCK = GOOD.objective, GOOD.planes[0], GOOD.stock
NAN = float("nan")

BAD = [
    (replace(GOOD, planes=()), "at least one correction plane must be stated"),
    (
        replace(GOOD, planes=(PLANE,)),
        r"the objective's matrix must have one row per residual and 1 columns, got the shape \(2, 2\)",
    ),
    (
        replace(GOOD, objective=replace(OBJECTIVE, offset=np.zeros(3, complex))),
        r"objective\.offset must have the shape \(2,\), got \(3,\)",
    ),
    (
        replace(GOOD, objective=replace(OBJECTIVE, matrix=OBJECTIVE.matrix * NAN)),
        "the objective's matrix must be finite numbers",
    ),
    (replace(GOOD, objective=replace(OBJECTIVE, weights=np.array([0.5, 0.0]))), "weights must be above 0, got 0"),
    (
        replace(GOOD, objective=replace(OBJECTIVE, norm=cast(Norm, "mean"))),
        'the norm must be one of components, sum, max or rms, got "mean"',
    ),
    (replace(GOOD, planes=(PLANE, plane(np.empty(0), 2))), "plane 2 must have at least one position"),
    (replace(GOOD, planes=(PLANE, plane(np.array([0.1, NAN]), 2))), "every position of plane 2 must be a finite angle"),
    (
        replace(GOOD, planes=(PLANE, plane(np.array([0.0, 1.0, 2.0 * np.pi]), 2))),
        "plane 2 must have each position once, got 0 degrees twice",
    ),
    (
        replace(GOOD, planes=(PLANE, replace(PLANE, capacity=np.ones(3, int)))),
        r"plane 2\.capacity must have the shape \(18,\), got \(3,\)",
    ),
    (
        replace(GOOD, planes=(replace(PLANE, capacity=-np.ones(18, int)), PLANE)),
        r"plane 1\.capacity must be 0 or more, got -1 \(0 blocks a position\)",
    ),
    (
        replace(GOOD, planes=(replace(PLANE, capacity_g=np.full(18, NAN)), PLANE)),
        r"plane 1\.capacity_g must be 0 or more, got nan \(0 blocks a position\)",
    ),
    (
        replace(GOOD, planes=(replace(PLANE, max_pieces=-1), PLANE)),
        r"plane 1\.max_pieces must be 0 or more, got -1 \(0 leaves the plane empty\)",
    ),
    (
        replace(GOOD, planes=(replace(PLANE, max_mass_g=NAN), PLANE)),
        r"plane 1\.max_mass_g must be 0 or more, got nan \(0 leaves the plane empty\)",
    ),
    (
        replace(GOOD, planes=(replace(PLANE, fixed=complex(NAN, 0)), PLANE)),
        r"the fixed vector of plane 1 must be a finite number of g, got \(nan\+0j\)",
    ),
    (replace(GOOD, stock=replace(STOCK, masses_g=np.empty(0))), "the catalogue must hold at least one mass"),
    (
        replace(GOOD, stock=replace(STOCK, masses_g=-STOCK.masses_g)),
        "every stock mass must be a finite number above 0, got -10 g",
    ),
    (
        replace(GOOD, stock=replace(STOCK, masses_g=STOCK.masses_g * np.inf)),
        "every stock mass must be a finite number above 0, got inf g",
    ),
    (
        replace(GOOD, stock=replace(STOCK, fasteners_g=np.full(6, -1.0))),
        r"stock\.fasteners_g must be 0 or more, got -1 \(0 where the fastener is not weighed\)",
    ),
    (
        replace(GOOD, stock=replace(STOCK, counts=np.array([1, 2, 3, -4, 5, 6]))),
        r"stock\.counts must be 0 or more, got -4 \(0 where the catalogue is used up\)",
    ),
    (
        replace(GOOD, stock=replace(STOCK, masses_g=np.array([10.0, 20, 50, 20, 200, 300]))),
        "a stock mass must be stated once, got 20 g twice",
    ),
]


@pytest.mark.parametrize(("problem", "message"), BAD, ids=[m for _, m in BAD])
def test_a_broken_rule_is_named(problem: SelectionProblem, message: str) -> None:
    with pytest.raises(NumericsError, match=message):
        validate(problem)


def test_solvers_validate_first() -> None:
    with pytest.raises(NumericsError, match="at least one correction plane must be stated"):
        solve_exhaustive(BAD[0][0])
    with pytest.raises(NumericsError, match="at least one correction plane must be stated"):
        solve_jaya(BAD[0][0], seed=1)


def test_a_good_problem_passes_and_one_mass_with_two_fasteners_is_two_items() -> None:
    validate(thesis_rotor("static", 4))
    twice = replace(STOCK, masses_g=np.array([10.0, 20, 50, 20, 200, 300]), fasteners_g=np.array([0.0, 0, 0, 5, 0, 0]))
    validate(replace(GOOD, stock=twice))
