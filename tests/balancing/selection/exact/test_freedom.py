"""More freedom or more time never makes the answer worse, also where a search cannot be completed."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from service.balancing.selection.exact import meet_in_middle, neighbourhood, search
from service.balancing.selection.exact.search import ExactState, last_state, search_exact, solve_exact
from service.balancing.selection.objectives import residual_vibration
from service.balancing.selection.placements import broken_limit
from service.balancing.selection.problem import SelectionPlane, SelectionProblem, Stock
from tests.support.numerics.problems import even_positions

STEPS = 300


def demanding(seed: int, pieces: int = 5, kinds: int = 5, holes: int = 12) -> SelectionProblem:
    """Two planes, two or three sensors, masses of no common measure, one in each hole."""
    rng = np.random.default_rng(seed)
    sensors = 2 + seed % 2
    influence = 0.01 * (rng.normal(size=(sensors, 2)) + 1j * rng.normal(size=(sensors, 2)))
    target = rng.uniform(50.0, 250.0, 2) * np.exp(2j * np.pi * rng.random(2))
    objective = residual_vibration(influence.astype(np.complex128), -influence @ target, np.full(sensors, 0.7))
    masses = np.sort(rng.uniform(5.0, 150.0, 40))[:: 40 // kinds][:kinds]
    plane = SelectionPlane(even_positions(holes), np.ones(holes, int), np.full(holes, np.inf), pieces)
    return SelectionProblem(objective, (plane, plane), Stock(masses, np.full(kinds, 3), np.zeros(kinds)))


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Little memory and patience: what is a frontier for large problems then is one for small ones."""
    monkeypatch.setattr(meet_in_middle, "LARGEST_TABLE", 80_000)
    monkeypatch.setattr(search, "MAX_ASKED", 20_000)
    monkeypatch.setattr(search, "MAX_ASKED_LAST", 20_000)
    monkeypatch.setattr(neighbourhood, "MAX_HALVES", 2_000)


def after(problem: SelectionProblem, steps: int) -> ExactState:
    """State after so many steps, or the last one."""
    return list(islice(search_exact(problem), steps))[-1]


@pytest.mark.usefixtures("narrow")
@pytest.mark.parametrize("pieces", [5, 6, 7])
@pytest.mark.parametrize("seed", range(3))
def test_more_pieces_kinds_holes_or_time_are_never_worse(seed: int, pieces: int) -> None:
    """Five pieces a plane can be proved here, more cannot."""
    base = demanding(seed, pieces=pieces)
    value = after(base, STEPS).value
    rich = replace(base.stock, masses_g=np.append(base.stock.masses_g, 171.3))
    rich = replace(rich, counts=np.full(6, 3), fasteners_g=np.zeros(6))
    hole = replace(base.planes[0], angles=np.append(base.planes[0].angles, 0.05))
    hole = replace(hole, capacity=np.ones(13, int), capacity_g=np.full(13, np.inf))
    freer = (demanding(seed, pieces + 1), replace(base, stock=rich), replace(base, planes=(hole, hole)))
    for problem, steps in ((base, 2 * STEPS), *((one, STEPS) for one in freer)):
        found = after(problem, steps)
        assert broken_limit(problem, found.selection) is None
        assert found.value <= value * (1.0 + 1e-9)


@pytest.mark.usefixtures("narrow")
def test_a_search_that_cannot_be_completed_goes_on_as_long_as_the_caller_has_time() -> None:
    states = list(islice(search_exact(demanding(1, pieces=9, holes=18)), 350))
    assert len(states) == 350
    assert not states[-1].proved
    values = [state.value for state in states]
    assert values == sorted(values, reverse=True)
    assert solve_exact(demanding(1, pieces=9, holes=18)).status == "limit_reached"


def test_the_bound_of_a_square_problem_tells_something_before_the_end() -> None:
    states = list(search_exact(demanding(2, pieces=6, kinds=6, holes=18)))
    best = states[-1].value
    assert states[-1].proved
    early = [state.lower_bound for state in states if not state.proved]
    assert 0.05 * best < max(early) <= best * (1.0 + 1e-9)


def test_a_rung_in_between_is_found_before_the_last_is_done() -> None:
    """Six pieces a plane: the best of five is there before."""
    five = solve_exact(demanding(4, pieces=5, holes=18)).value
    state = last_state(search_exact(demanding(4, pieces=7, holes=18)), lambda now: now.value <= five * (1.0 + 1e-9))
    assert not state.proved
