"""The exact search: equal to brute force, its bound never violated, stoppable, repeatable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing import exact
from service.balancing.exact import search_exact, solve_exact
from service.balancing.exhaustive import solve_exhaustive
from service.balancing.objectives import evaluate
from service.balancing.placements import broken_limit, vectors_of
from service.balancing.selection import SelectionProblem
from tests.balancing.problems import even_positions, field_experiment, plane, stock, thesis_rotor
from tests.balancing.random_problems import KINDS, random_problem

CLOSE = 1e-8


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("at_once", [0.0, exact.AT_ONCE])
def test_equals_brute_force_and_no_bound_is_violated(
    kind: str, at_once: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With at_once 0 these small problems go through levels, as large ones do."""
    monkeypatch.setattr(exact, "AT_ONCE", at_once)
    for seed in (*range(25), 5148):
        problem = random_problem(kind, seed)
        judge = solve_exhaustive(problem)
        optimum = judge.value
        slack = CLOSE * max(1.0, optimum)
        for state in search_exact(problem):
            assert state.lower_bound <= optimum + slack, f"bound above the optimum, seed {seed}"
            assert state.value >= optimum - slack, f"better than brute force, seed {seed}"
            assert broken_limit(problem, state.selection) is None
            assert state.value == pytest.approx(
                float(evaluate(problem.objective, vectors_of(problem, state.selection))), abs=slack
            )
        assert state.proved, f"not proved, seed {seed}"
        assert state.value == pytest.approx(optimum, abs=slack), f"not the optimum, seed {seed}"


@pytest.mark.parametrize("kind", KINDS)
def test_a_limit_on_all_pieces_together_equals_brute_force(kind: str) -> None:
    for seed in range(12):
        problem = random_problem(kind, 1000 + seed)
        free = solve_exact(problem)
        assert free.pieces is not None
        most = max(sum(len(p) for p in free.pieces) - 1, 0)
        limited = solve_exact(problem, most_pieces=most)
        assert limited.pieces is not None
        assert sum(len(p) for p in limited.pieces) <= most
        judge = solve_exhaustive(problem, most_pieces=most)
        assert limited.value == pytest.approx(judge.value, abs=CLOSE * max(1.0, judge.value)), f"seed {seed}"


def rich() -> SelectionProblem:
    """Two planes of 24 positions, twelve masses three times in the box, four pieces a plane."""
    masses = (10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 75.0, 100.0, 120.0, 150.0, 200.0, 300.0)
    objective = field_experiment(1).objective
    return SelectionProblem(objective, (plane(even_positions(24), 4, capacity=1),) * 2, stock(masses, counts=3))


def test_a_large_problem_is_proved_and_keeps_the_box() -> None:
    found = solve_exact(rich())
    assert found.status == "optimal"
    assert found.gap == pytest.approx(0.0, abs=1e-9)
    assert found.pieces is not None
    assert broken_limit(rich(), found.pieces) is None
    assert found.value / 330.0 < 0.2


def test_the_same_answer_every_time_and_whatever_it_starts_from() -> None:
    first = solve_exact(rich())
    again = solve_exact(rich(), start=((), ()))
    assert first.pieces == again.pieces
    better_start = solve_exact(rich(), start=first.pieces)
    assert better_start.value == pytest.approx(first.value, rel=CLOSE)


def test_turning_everything_turns_the_answer() -> None:
    whole = thesis_rotor("dynamic", 2)
    step = np.exp(1j * np.deg2rad(30.0))
    turned = replace(whole, objective=replace(whole.objective, offset=whole.objective.offset * step))
    plain, moved = solve_exact(whole), solve_exact(turned)
    assert moved.value == pytest.approx(plain.value, rel=1e-9)
    assert moved.vectors == pytest.approx(plain.vectors * step, rel=1e-9, abs=1e-6)


def test_bounds_only_rise_and_values_only_fall() -> None:
    states = list(search_exact(rich()))
    bounds, values = [s.lower_bound for s in states], [s.value for s in states]
    assert bounds == sorted(bounds)
    assert values == sorted(values, reverse=True)
    assert states[-1].proved


def test_a_stop_leaves_a_selection_a_bound_and_the_gap() -> None:
    found = solve_exact(rich(), stop=lambda: True)
    assert found.status == "limit_reached"
    assert found.pieces == ((), ())
    assert 0.0 <= found.lower_bound < found.value
    assert "not excluded" in found.message


def test_what_cannot_be_measured_is_not_searched() -> None:
    proved = solve_exact(rich())
    early = solve_exact(rich(), uncertainty=20.0 * 330.0)
    assert early.status == "within_uncertainty"
    assert early.evaluations <= proved.evaluations
    assert early.value - proved.value <= 20.0 * 330.0
    assert early.lower_bound <= proved.value


def test_more_masses_never_make_it_worse() -> None:
    values = [solve_exact(field_experiment(n)).value for n in range(5)]
    assert values == sorted(values, reverse=True)


def test_dependent_planes_are_bounded_by_what_they_reach() -> None:
    """Two planes that no sensor can tell apart: the continuous optimum is a line."""
    whole = thesis_rotor("static", 2)
    same = np.repeat(whole.objective.matrix[:, :1], 2, axis=1)
    problem = replace(
        whole,
        objective=replace(whole.objective, matrix=same),
        planes=(plane(even_positions(6), 2, capacity=1),) * 2,
        stock=stock((50.0, 200.0), counts=2),
    )
    found, judge = solve_exact(problem), solve_exhaustive(problem)
    assert found.status == "optimal"
    assert found.value == pytest.approx(judge.value, rel=CLOSE)


def test_a_catalogue_of_ten_thousand_masses_gets_an_honest_answer() -> None:
    whole = field_experiment(4)
    masses = tuple(np.linspace(1.0, 300.0, 10_000).tolist())
    problem = replace(whole, stock=stock(masses))
    found = solve_exact(problem, uncertainty=0.01 * 330.0)
    assert found.status in ("optimal", "within_uncertainty", "limit_reached")
    assert found.lower_bound <= found.value
    assert found.value / 330.0 < 0.01
