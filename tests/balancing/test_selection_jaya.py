"""Modified Jaya on the drum: success over seeds, limits kept, repeatable, stoppable."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from service.balancing.jaya import search_jaya, solve_jaya
from service.balancing.placements import broken_limit
from service.balancing.selection import UNLIMITED, SelectionProblem
from tests.balancing.problems import field_experiment, plane, stock, thesis_rotor

ONE_MASS = {"static": 0.31724, "dynamic": 0.24046}  # proved by trying all


@pytest.mark.parametrize("case", ["static", "dynamic"])
def test_published_rules_and_budget_reach_the_one_mass_optimum_in_most_runs(case: str) -> None:
    """The thesis's budget for one mass a plane; 19 and 20 of 20 runs were measured with another generator."""
    values = [solve_jaya(thesis_rotor(case, 1), seed, as_published=True).value for seed in range(20)]
    assert sum(v == pytest.approx(ONE_MASS[case], abs=1e-5) for v in values) >= 16


@pytest.mark.parametrize("case", ["static", "dynamic"])
def test_improved_rules_reach_the_one_mass_optimum_in_most_runs(case: str) -> None:
    values = [solve_jaya(thesis_rotor(case, 1), seed).value for seed in range(20)]
    assert sum(v == pytest.approx(ONE_MASS[case], abs=1e-5) for v in values) >= 16


def tight() -> SelectionProblem:
    """Three masses a plane, each once in the box, one a position, holes missing, a plane light."""
    whole = field_experiment(3)
    angles = np.delete(whole.planes[0].angles, [2, 3, 11])
    first = plane(angles, 3, capacity=1)
    second = replace(plane(angles[::-1], 3, capacity=1), max_mass_g=250.0, capacity_g=np.full(15, 150.0))
    return replace(whole, planes=(first, second), stock=stock(counts=1))


@pytest.mark.parametrize("as_published", [True, False])
def test_every_generation_keeps_every_limit(as_published: bool) -> None:
    problem = tight()
    states = search_jaya(problem, np.random.default_rng(3), members=15, as_published=as_published)
    for state in islice(states, 40):
        assert broken_limit(problem, state.selection) is None


def test_same_seed_same_answer() -> None:
    first, again = (solve_jaya(tight(), 11, generations=30) for _ in range(2))
    assert first.pieces == again.pieces
    assert first.status == "heuristic"
    assert first.lower_bound == 0.0
    assert first.details["seed"] == 11


def test_the_best_never_gets_worse_and_a_stop_is_honoured() -> None:
    states = list(islice(search_jaya(tight(), np.random.default_rng(1), members=20), 50))
    values = [s.value for s in states]
    assert values == sorted(values, reverse=True)
    stopped = solve_jaya(tight(), 1, generations=1000, stop=lambda: True)
    assert stopped.details["generations"] == 1
    assert "stopped" in stopped.message


def test_a_plane_that_takes_nothing_stays_empty() -> None:
    problem = field_experiment(0)
    assert solve_jaya(problem, 1).pieces == ((), ())


def test_counts_without_limit_are_no_overflow() -> None:
    problem = replace(field_experiment(3), stock=stock(counts=UNLIMITED))
    assert solve_jaya(problem, 1, generations=3).pieces is not None
