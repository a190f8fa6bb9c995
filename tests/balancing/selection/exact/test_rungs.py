"""Rungs: all selections of at most so many pieces a plane, level by level, to a proof."""

from __future__ import annotations

from collections.abc import Generator, Iterator

import pytest

from service.balancing.selection.exact.bounds import bounds_of
from service.balancing.selection.exact.presolve import opened
from service.balancing.selection.exact.rungs import ExactState, Search, improve, levels, meanwhile
from service.balancing.selection.placements import broken_limit, slots
from service.balancing.selection.problem import SelectionProblem
from tests.support.numerics.against_brute_force import Every
from tests.support.numerics.problems import field_experiment
from tests.support.numerics.random_problems import KINDS, random_problem


def search_of(problem: SelectionProblem, most: int | None = None) -> Search:
    whole = opened(problem)
    return Search(whole, bounds_of(whole.problem).unit, None, most, 1, 0.0)


def climbed(problem: SelectionProblem, rung: int, most: int | None = None) -> tuple[Search, bool]:
    """The search after one rung, and whether the rung could be finished; every state on the way holds."""
    search = search_of(problem, most)
    bounds = bounds_of(search.problem)
    search.floor = bounds.floor
    steps = levels(search, bounds, rung, last=True)
    floor, best = 0.0, float("inf")
    while True:
        try:
            state = next(steps)
        except StopIteration as done:
            return search, bool(done.value)
        assert state.lower_bound >= floor - 1e-12
        assert state.value <= best
        floor, best = state.lower_bound, state.value


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_the_last_rung_finds_the_best_there_is(kind: str, seed: int) -> None:
    problem = random_problem(kind, seed)
    whole = opened(problem).problem
    if not whole.planes:
        return
    every = Every.of(problem)
    most = max(slots(plane, whole.stock) for plane in whole.planes)
    search, complete = climbed(problem, most)
    assert complete
    assert abs(search.state().value - every.best) <= every.close
    assert broken_limit(problem, search.state().selection) is None


def test_a_lower_rung_finds_the_best_of_so_few_pieces() -> None:
    problem = field_experiment(1)
    every = Every.of(problem)
    search, complete = climbed(field_experiment(2), 1)
    assert complete
    assert search.state().value == pytest.approx(every.best)


def test_pieces_in_all_planes_together_are_limited() -> None:
    search, _complete = climbed(field_experiment(2), 2, most=1)
    assert sum(len(pieces) for pieces in search.state().selection) == 1


def test_a_proof_raises_the_bound_to_the_value() -> None:
    search, _complete = climbed(field_experiment(2), 2)
    state = search.state(proved=True)
    assert state.proved
    assert state.lower_bound <= state.value
    search.raise_floor(0.5 * state.value)
    search.raise_floor(0.1 * state.value)  # a bound that is lower tells nothing new
    assert search.state().lower_bound >= 0.5 * state.value


def test_a_start_is_kept_until_something_is_better() -> None:
    problem = field_experiment(2)
    found = climbed(problem, 2)[0].state().selection
    whole = opened(problem)
    begun = Search(whole, bounds_of(whole.problem).unit, found, None, 1, 0.0)
    assert begun.state().selection == found
    begun.offer(((), ()))
    assert begun.state().selection == found


def test_single_changes_never_make_it_worse() -> None:
    search = search_of(field_experiment(2))
    before = search.state().value
    for _state in improve(search):
        pass
    assert search.state().value < before


def test_steps_that_find_nothing_pass_the_state_on() -> None:
    search = search_of(field_experiment(1))

    def steps() -> Generator[None, None, int]:
        yield
        yield
        return 7

    seen: list[ExactState] = []

    def watched() -> Iterator[ExactState]:
        assert (yield from meanwhile(search.state, steps())) == 7

    seen += watched()
    assert [state.value for state in seen] == [search.state().value] * 2
