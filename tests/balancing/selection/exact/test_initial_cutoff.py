"""The first level: holds about as many joint selections as are wanted, and none above what is known already."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from service.balancing.selection.brute_force import _choices
from service.balancing.selection.exact.bounds import bounds_of
from service.balancing.selection.exact.initial_cutoff import first_level
from service.balancing.selection.exact.meet_in_middle import Split, split_of
from service.balancing.selection.exact.subsets import placements_of
from service.balancing.selection.objectives import evaluate, residual_vibration
from service.balancing.selection.problem import SelectionProblem
from tests.support.numerics.problems import field_experiment
from tests.support.numerics.steps import finished


def splits(problem: SelectionProblem, most: int) -> list[Split]:
    made = [finished(split_of(placements_of(plane, problem.stock), most)) for plane in problem.planes]
    return [one for one in made if one is not None]


def three_sensors(pieces: int) -> SelectionProblem:
    """The field experiment seen by three sensors: no correction brings all of them to nothing."""
    bare = field_experiment(pieces)
    influence = np.array([[0.010 + 0j, 0.002j], [0.003 + 0j, 0.012 + 0j], [0.006j, -0.005 + 0j]])
    return replace(bare, objective=residual_vibration(influence, np.array([2.0 + 1j, -1.0 + 2j, 1.5 - 1j]), np.ones(3)))


def test_is_between_the_bound_and_what_is_known() -> None:
    problem = three_sensors(2)
    bounds = bounds_of(problem)
    level = finished(first_level(bounds, splits(problem, 2), bounds.unit))
    assert bounds.floor < level <= bounds.unit


def test_holds_some_selections_and_not_most() -> None:
    problem = three_sensors(2)
    bounds = bounds_of(problem)
    level = finished(first_level(bounds, splits(problem, 2), bounds.unit))
    first, second = (_choices(problem, p).vectors for p in (0, 1))
    values = np.concatenate(
        [evaluate(problem.objective, np.stack([np.full(len(second), u), second], axis=1)) for u in first[::25]]
    )
    within = 25.0 * float((values <= level).sum())
    assert within < 1e-3 * len(first) * len(second)


def test_a_level_that_holds_few_is_searched_at_once() -> None:
    """The whole of 1 + 108 selections a plane is fewer than are looked at in any case."""
    problem = field_experiment(1)
    bounds = bounds_of(problem)
    assert bounds.dual is None
    assert finished(first_level(bounds, splits(problem, 1), 0.3 * bounds.unit)) == 0.3 * bounds.unit
