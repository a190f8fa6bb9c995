"""The lower bound: below every selection, and met by the continuous optimum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.exact.bounds import bounds_of, complex_of, real_of
from service.balancing.selection.objectives import residual_vibration
from service.balancing.selection.problem import Norm
from tests.support.numerics.against_brute_force import Every
from tests.support.numerics.problems import FIELD_TARGET, field_experiment
from tests.support.numerics.random_problems import KINDS, random_problem


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(6))
def test_no_selection_is_below(kind: str, seed: int) -> None:
    problem = random_problem(kind, seed)
    found, every = bounds_of(problem), Every.of(problem)
    assert found.floor <= every.best + every.close
    assert found.unit >= every.values.max() * (1.0 - 1e-9)


def test_a_correction_within_reach_is_the_optimum_and_the_bound_is_zero() -> None:
    """The field experiment: two planes, two targets, both within 3 x 300 g."""
    found = bounds_of(field_experiment(3))
    np.testing.assert_allclose(found.continuous, FIELD_TARGET, rtol=1e-9)
    assert found.floor == 0.0
    assert found.dual is None


def test_a_correction_out_of_reach_leaves_what_cannot_be_reached() -> None:
    """One piece of at most 300 g a plane against a target of 1,000 g: 700 g and more are left, in both components."""
    bare = field_experiment(1)
    objective = replace(bare.objective, offset=np.array([-330e3 + 0j, 0j]), norm="sum")
    objective = replace(objective, weights=np.array([1.0, 1.0]))
    floor = bounds_of(replace(bare, objective=objective)).floor
    assert floor == pytest.approx(330.0 * 700.0, rel=0.02)
    assert floor <= 330.0 * 700.0 * (1.0 + 1e-9)


@pytest.mark.parametrize("norm", ["sum", "max", "rms"])
def test_more_sensors_than_planes_leave_the_continuous_optimum(norm: Norm) -> None:
    """One plane, two sensors of equal influence and opposite vibration: nothing can be done, and the bound says so."""
    bare = field_experiment(2)
    objective = residual_vibration(np.array([[0.01 + 0j], [0.01 + 0j]]), np.array([1.0 + 0j, -1.0 + 0j]), np.ones(2))
    problem = replace(bare, objective=replace(objective, norm=norm), planes=bare.planes[:1])
    wanted = {"sum": 2.0, "max": 1.0, "rms": 1.0}[norm]
    assert bounds_of(problem).floor == pytest.approx(wanted, rel=1e-5)


def test_real_and_complex_coordinates_are_the_same_point() -> None:
    u = np.array([1.0 - 2j, 3j])
    assert real_of(u).tolist() == [1.0, -2.0, 0.0, 3.0]
    assert complex_of(real_of(u)).tolist() == u.tolist()
