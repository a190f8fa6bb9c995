"""Modified Jaya first, then the proof: both are reported."""

from __future__ import annotations

from itertools import pairwise

import pytest

from service.balancing.selection.certified import FIRST_GENERATIONS, search_certified, solve_certified
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.placements import broken_limit
from tests.support.numerics.problems import thesis_rotor
from tests.support.numerics.random_problems import KINDS, random_problem


@pytest.mark.parametrize("case", ["static", "dynamic"])
def test_the_answer_is_proved_and_both_methods_are_told(case: str) -> None:
    problem = thesis_rotor(case, 3)
    both = solve_certified(problem, seed=4)
    assert both.first.status == "heuristic"
    assert both.result.status == "optimal"
    assert both.result.value == pytest.approx(solve_exact(problem).value, rel=1e-9)
    assert both.result.value <= both.first.value
    assert both.result.details["first_value"] == both.first.value
    assert both.result.details["improvement"] == pytest.approx(1.0 - both.result.value / both.first.value)


@pytest.mark.parametrize("kind", KINDS)
def test_never_worse_than_the_first_answer_and_as_good_as_exact(kind: str) -> None:
    for seed in range(4):
        problem = random_problem(kind, 500 + seed)
        both = solve_certified(problem, seed)
        assert both.result.value <= both.first.value * (1.0 + 1e-9)
        assert both.result.value == pytest.approx(solve_exact(problem).value, rel=1e-8, abs=1e-8)
        assert both.result.pieces is not None
        assert broken_limit(problem, both.result.pieces) is None


def test_same_seed_same_answer() -> None:
    first, again = (solve_certified(thesis_rotor("dynamic", 2), 9) for _ in range(2))
    assert first.result.pieces == again.result.pieces
    assert first.first.pieces == again.first.pieces


def test_a_stop_before_the_exact_search_leaves_the_heuristic_answer() -> None:
    both = solve_certified(thesis_rotor("static", 3), 1, stop=lambda: True)
    assert both.result.status == "heuristic"
    assert both.result == both.first


def test_progress_is_jaya_then_exact_and_values_only_fall() -> None:
    states = list(search_certified(thesis_rotor("static", 3), 1))
    assert [s.exact is None for s in states[:FIRST_GENERATIONS]] == [True] * FIRST_GENERATIONS
    assert all(s.exact is not None for s in states[FIRST_GENERATIONS:])
    values = [s.value for s in states]
    assert all(later <= earlier * (1.0 + 1e-9) for earlier, later in pairwise(values))
    assert states[-1].proved
    assert states[0].lower_bound == 0.0
