"""Modified Jaya on the drum: success over seeds, limits kept, repeatable, stoppable."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from service.balancing.selection.jaya import runs_together, search_jaya, solve_jaya
from service.balancing.selection.placements import broken_limit
from service.balancing.selection.problem import UNLIMITED, SelectionProblem
from service.errors import NumericsError
from service.messages import render
from tests.support.numerics.problems import field_experiment, plane, stock, thesis_rotor

ONE_MASS = {"static": 0.31724, "dynamic": 0.24046}  # proved by trying all


@pytest.mark.parametrize("case", ["static", "dynamic"])
def test_published_rules_and_budget_reach_the_one_mass_optimum_in_most_runs(case: str) -> None:
    """The thesis's budget for one mass a plane; 19 and 20 of 20 runs were measured with another generator."""
    assert successes(case, 3, as_published=True) >= 16


@pytest.mark.parametrize("case", ["static", "dynamic"])
def test_improved_rules_reach_the_one_mass_optimum_in_most_runs(case: str) -> None:
    assert successes(case, 4, as_published=False) >= 16


def successes(case: str, seed: int, *, as_published: bool) -> int:
    """Of twenty independent runs of 100 generations, those that end at the optimum."""
    states = search_jaya(thesis_rotor(case, 1), np.random.default_rng(seed), runs=20, as_published=as_published)
    *_, last = islice(states, 100)
    assert len(last.values) == 20
    return sum(value == pytest.approx(ONE_MASS[case], abs=1e-5) for value in last.values)


@pytest.mark.parametrize("as_published", [True, False])
def test_runs_are_independent_and_the_best_of_them_is_the_answer(as_published: bool) -> None:
    """Together they are as good as one by one: success with two masses a plane, either way."""
    problem = thesis_rotor("dynamic", 2)
    optimum = 0.01667
    together = solve_jaya(problem, 1, members=40, generations=80, runs=20, as_published=as_published)
    states = search_jaya(problem, np.random.default_rng(1), members=40, runs=20, as_published=as_published)
    *_, last = islice(states, 80)
    assert min(last.values) == last.value
    assert together.value == pytest.approx(last.value, rel=1e-12)
    assert together.details["runs"] == 20
    assert together.details["agreeing"] == sum(v <= last.value * (1.0 + 1e-9) for v in last.values)
    assert f"{together.details['agreeing']:g} of 20 runs ended at this value" in render(together.message)
    alone = [
        solve_jaya(problem, seed, members=40, generations=80, as_published=as_published).value for seed in range(8)
    ]
    shares = [np.mean(np.array(v) < 1.01 * optimum) for v in (last.values, alone)]
    assert abs(shares[0] - shares[1]) < 0.4
    assert len(set(last.values)) > 1


def test_a_plane_that_takes_nothing_and_runs_together() -> None:
    states = search_jaya(field_experiment(0), np.random.default_rng(1), runs=3)
    assert len(next(states).values) == 3


def test_a_step_is_bounded_whatever_is_asked_for() -> None:
    """A long box, every plane full: more runs than a step may move are refused, with how many it may."""
    long = replace(field_experiment(12), stock=stock(tuple(np.arange(1.0, 5001.0).tolist()), counts=1))
    with pytest.raises(
        NumericsError, match="100 runs of 150 members with 24 slots are too many for one step: at most 16 runs fit"
    ) as refused:
        search_jaya(long, np.random.default_rng(1), members=150, runs=100)
    most = runs_together(long, 150)
    assert f"at most {most} runs" in refused.value.message
    state = next(search_jaya(long, np.random.default_rng(1), members=150, runs=most))
    assert broken_limit(long, state.selection) is None


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
    assert "stopped" in render(stopped.message)


def test_a_plane_that_takes_nothing_stays_empty() -> None:
    problem = field_experiment(0)
    assert solve_jaya(problem, 1).pieces == ((), ())


def test_counts_without_limit_are_no_overflow() -> None:
    problem = replace(field_experiment(3), stock=stock(counts=UNLIMITED))
    assert solve_jaya(problem, 1, generations=3).pieces is not None
