"""Variables: what snapping does at the midpoint, at the bounds, and around a circle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.errors import NumericsError
from service.optimize.problem import Circular, Continuous, Discrete, Integer, MixedProblem, Variable, validate


def test_midpoints_go_to_the_lower_neighbour() -> None:
    x = np.array([0.0, 14.99, 15.0, 15.01, 99.0])
    assert Discrete((10.0, 20.0, 50.0)).snap(x).tolist() == [10.0, 10.0, 10.0, 20.0, 50.0]
    assert Integer(-2, 2).snap(np.array([-1.5, -0.4, 0.5, 0.51, 9.0])).tolist() == [-2.0, 0.0, 0.0, 1.0, 2.0]
    assert Continuous(-1.0, 1.0).snap(np.array([-3.0, 0.25])).tolist() == [-1.0, 0.25]


@given(st.floats(-50.0, 50.0), st.sets(st.integers(0, 359), min_size=1, max_size=12))
def test_a_circle_snaps_to_the_nearest_way_round(x: float, degrees: set[int]) -> None:
    values = np.deg2rad(sorted(degrees))
    chosen = float(Circular(tuple(values)).snap(np.array([x]))[0])
    away = np.abs(np.angle(np.exp(1j * (values - x))))
    assert abs(np.angle(np.exp(1j * (chosen - x)))) == pytest.approx(float(away.min()), abs=1e-9)


@pytest.mark.parametrize(
    ("variable", "message"),
    [
        (Continuous(1.0, 0.0), "lower one first"),
        (Integer(3, 2), "lower one first"),
        (Continuous(0.0, math.inf), "finite bounds"),
        (Discrete(()), "variable 0 must have finite values in ascending order, each once"),
        (Discrete((2.0, 1.0)), "ascending order"),
        (Circular((0.0, 7.0)), r"variable 0 must have values from 0 to below 6\.28319, got 0 to 7"),
    ],
)
def test_a_variable_without_a_value_is_refused(variable: Variable, message: str) -> None:
    with pytest.raises(NumericsError, match=message):
        validate(MixedProblem((variable,), lambda x: (x[:, 0], x[:, :0])))


def test_a_problem_without_variables_is_refused() -> None:
    with pytest.raises(NumericsError, match="the problem must have at least one variable"):
        validate(MixedProblem((), lambda x: (x[:, 0], x[:, :0])))
