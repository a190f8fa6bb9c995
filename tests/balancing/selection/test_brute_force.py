"""The judge itself, against a count and a hand-made answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import count_combinations, solve_exhaustive
from service.balancing.selection.objectives import components
from service.balancing.selection.problem import Piece, SelectionProblem
from service.errors import NumericsError
from tests.support.numerics.problems import even_positions, field_experiment, plane, stock

FOUR = even_positions(4)  # 90, 180, 270, 360 degrees


def test_picks_the_obvious_pieces() -> None:
    objective = components(np.array([30j, -10.0]), np.array([100.0, 100.0]))
    problem = SelectionProblem(objective, (plane(FOUR, 2), plane(FOUR, 1)), stock((10.0, 20.0)))
    found = solve_exhaustive(problem)
    assert found.pieces == ((Piece(0, 0), Piece(0, 1)), (Piece(1, 0),))
    assert found.status == "optimal"
    assert found.value == pytest.approx(0.0, abs=1e-9)
    assert found.gap == 0.0


def test_stock_is_shared_and_a_position_takes_what_it_takes() -> None:
    objective = components(np.array([20j, 20j]), np.array([100.0, 100.0]))
    both = (plane(FOUR, 3, capacity=1),) * 2
    one_left = SelectionProblem(objective, both, stock((20.0,), counts=1))
    assert [len(p) for p in solve_exhaustive(one_left).pieces or ()] in ([0, 1], [1, 0])
    tens = SelectionProblem(objective, both, stock((10.0,)))
    assert solve_exhaustive(tens).value == pytest.approx(1000.0)
    light = replace(both[0], capacity_g=np.full(4, 15.0), max_mass_g=5.0)
    assert solve_exhaustive(replace(tens, planes=(light, light))).pieces == ((), ())


def test_tries_every_selection_once() -> None:
    objective = components(np.array([7j]), np.array([1.0]))
    problem = SelectionProblem(objective, (plane(FOUR, 3),), stock((10.0, 20.0)))
    # multisets of up to 3 of 8 pairs: 1 + 8 + 36 + 120
    assert count_combinations(problem) == 165
    assert solve_exhaustive(problem).evaluations == 165


def test_refuses_what_it_cannot_finish_and_says_how_many() -> None:
    with pytest.raises(
        NumericsError, match="at most 500000 combinations can be tried one by one, got 49201894225"
    ) as refused:
        solve_exhaustive(field_experiment(3))
    assert refused.value.code == "too_many_combinations"
    assert refused.value.value == count_combinations(field_experiment(3))
