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
    (replace(GOOD, planes=()), "no correction plane"),
    (replace(GOOD, planes=(PLANE,)), r"shape \(2, 2\).*1 columns"),
    (replace(GOOD, objective=replace(OBJECTIVE, offset=np.zeros(3, complex))), "objective.offset has shape"),
    (replace(GOOD, objective=replace(OBJECTIVE, matrix=OBJECTIVE.matrix * NAN)), "matrix holds a value that is not"),
    (replace(GOOD, objective=replace(OBJECTIVE, weights=np.array([0.5, 0.0]))), "a weight is 0"),
    (replace(GOOD, objective=replace(OBJECTIVE, norm=cast(Norm, "mean"))), "norm 'mean' is unknown"),
    (replace(GOOD, planes=(PLANE, plane(np.empty(0), 2))), "plane 2 has no position"),
    (replace(GOOD, planes=(PLANE, plane(np.array([0.1, NAN]), 2))), "plane 2 has a position that is not"),
    (replace(GOOD, planes=(PLANE, plane(np.array([0.0, 1.0, 2.0 * np.pi]), 2))), "position at 0 degrees twice"),
    (replace(GOOD, planes=(PLANE, replace(PLANE, capacity=np.ones(3, int)))), "plane 2.capacity has shape"),
    (replace(GOOD, planes=(replace(PLANE, capacity=-np.ones(18, int)), PLANE)), "plane 1.capacity holds -1"),
    (replace(GOOD, planes=(replace(PLANE, capacity_g=np.full(18, NAN)), PLANE)), "plane 1.capacity_g holds nan"),
    (replace(GOOD, planes=(replace(PLANE, max_pieces=-1), PLANE)), "plane 1.max_pieces holds -1"),
    (replace(GOOD, planes=(replace(PLANE, max_mass_g=NAN), PLANE)), "plane 1.max_mass_g holds nan"),
    (replace(GOOD, planes=(replace(PLANE, fixed=complex(NAN, 0)), PLANE)), "plane 1 carries a fixed vector"),
    (replace(GOOD, stock=replace(STOCK, masses_g=np.empty(0))), "catalogue is empty"),
    (replace(GOOD, stock=replace(STOCK, masses_g=-STOCK.masses_g)), "a stock mass of -10 g"),
    (replace(GOOD, stock=replace(STOCK, masses_g=STOCK.masses_g * np.inf)), "a stock mass of inf g"),
    (replace(GOOD, stock=replace(STOCK, fasteners_g=np.full(6, -1.0))), "stock.fasteners_g holds -1"),
    (replace(GOOD, stock=replace(STOCK, counts=np.array([1, 2, 3, -4, 5, 6]))), "stock.counts holds -4"),
    (replace(GOOD, stock=replace(STOCK, masses_g=np.array([10.0, 20, 50, 20, 200, 300]))), "20 g stands .* twice"),
]


@pytest.mark.parametrize(("problem", "message"), BAD, ids=[m for _, m in BAD])
def test_a_broken_rule_is_named(problem: SelectionProblem, message: str) -> None:
    with pytest.raises(NumericsError, match=message):
        validate(problem)


def test_solvers_validate_first() -> None:
    with pytest.raises(NumericsError, match="no correction plane"):
        solve_exhaustive(BAD[0][0])
    with pytest.raises(NumericsError, match="no correction plane"):
        solve_jaya(BAD[0][0], seed=1)


def test_a_good_problem_passes_and_one_mass_with_two_fasteners_is_two_items() -> None:
    validate(thesis_rotor("static", 4))
    twice = replace(STOCK, masses_g=np.array([10.0, 20, 50, 20, 200, 300]), fasteners_g=np.array([0.0, 0, 0, 5, 0, 0]))
    validate(replace(GOOD, stock=twice))
