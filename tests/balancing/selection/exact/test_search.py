"""The exact search: equal to brute force, its bound never violated, stoppable, repeatable."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.exact import rungs, search
from service.balancing.selection.exact.search import search_exact, solve_exact
from service.balancing.selection.exact.subsets import Placements, placements_of
from service.balancing.selection.objectives import components, evaluate
from service.balancing.selection.placements import broken_limit, vectors_of
from service.balancing.selection.problem import Piece, SelectionPlane, SelectionProblem, Stock
from service.messages import render
from tests.support.numerics.against_brute_force import Every, check_states
from tests.support.numerics.problems import even_positions, field_experiment, plane, stock, thesis_rotor
from tests.support.numerics.random_problems import AWKWARD, KINDS, awkward_problem, fitted_problem, random_problem

CLOSE = 1e-8


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("at_once", [0.0, rungs.AT_ONCE])
def test_equals_brute_force_and_no_bound_is_violated(
    kind: str, at_once: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With at_once 0 these small problems go through levels, as large ones do."""
    monkeypatch.setattr(rungs, "AT_ONCE", at_once)
    for seed in (*range(8), 5148):
        problem = random_problem(kind, seed)
        check_states(problem, Every.of(problem))


@pytest.mark.parametrize("kind", KINDS)
def test_problems_that_are_hard_on_the_numerics(kind: str) -> None:
    """Planes that act alike or not at all, nothing to correct, targets of 1e-300 g, tiny pieces, far targets."""
    for seed in range(len(AWKWARD)):
        problem = awkward_problem(kind, seed)
        check_states(problem, Every.of(problem))


@pytest.mark.parametrize("kind", KINDS)
def test_pieces_on_the_rotor(kind: str) -> None:
    for seed in range(6):
        problem = fitted_problem(kind, seed)
        check_states(problem, Every.of(problem))


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
    assert "not excluded" in render(found.message)


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


def test_planes_whose_masses_move_nothing_stay_empty() -> None:
    whole = field_experiment(2)
    dead = replace(whole.objective, matrix=whole.objective.matrix * np.array([1.0, 0.0]))
    found = solve_exact(replace(whole, objective=dead))
    assert found.status == "optimal"
    assert found.pieces is not None
    assert [len(pieces) > 0 for pieces in found.pieces] == [True, False]
    nothing = solve_exact(replace(whole, objective=replace(dead, matrix=0.0 * dead.matrix)))
    assert (nothing.status, nothing.pieces) == ("optimal", ((), ()))


def long_box() -> SelectionProblem:
    """A thousand items that may go into 36 holes of two planes."""
    masses = tuple((0.5 + 0.5 * np.arange(1000)).tolist())
    both = (plane(even_positions(36), 3, capacity=1), plane(even_positions(36), 3, capacity=1))
    return replace(field_experiment(1), planes=both, stock=stock(masses, counts=1))


def test_a_box_too_long_to_be_listed_is_answered_with_an_honest_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only some of its items are searched: whatever is found is allowed, nothing is called proved."""
    listed: list[int] = []
    of = placements_of

    def counted(where: SelectionPlane, box: Stock, most: int | None = None) -> Placements:
        placed = of(where, box, most)
        listed.append(placed.none)
        return placed

    monkeypatch.setattr(rungs, "placements_of", counted)
    monkeypatch.setattr(search, "MAX_PAIRS", 1500)
    start = ((Piece(5, 987),), (Piece(7, 432),))
    for state in islice(search_exact(long_box(), start=start), 200):
        assert broken_limit(long_box(), state.selection) is None
        assert state.value == pytest.approx(
            float(evaluate(long_box().objective, vectors_of(long_box(), state.selection))), rel=1e-9
        )
        assert state.lower_bound <= state.value
        assert not state.proved
    assert 0 < max(listed) <= 1500 + 2 * 36


def test_a_front_of_many_planes_goes_through_its_splits_one_by_one() -> None:
    """Six planes and four pieces: the first steps come at once, not after every way to share the pieces was listed."""
    objective = components(np.full(6, 60.0 - 30.0j), np.full(6, 330.0))
    six = SelectionProblem(objective, (plane(even_positions(6), 20),) * 6, stock(counts=4))
    states = list(islice(search_exact(six, most_pieces=4), 300))
    assert all(sum(map(len, state.selection)) <= 4 for state in states)
    assert states[-1].value < states[0].value
