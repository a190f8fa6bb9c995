"""Robust selections: allowed, never worse than what they begin with, and the best there is where all can be listed."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement, product

import numpy as np
import pytest

from service.balancing.rotor.phasors import FloatArray
from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.robust import Aim, Uncertain, robust_aims, search_robust
from service.balancing.selection.batch.tables import shared_rows
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.placements import Selection, broken_limit, vectors_of
from service.balancing.selection.problem import Norm, Piece, SelectionPlane, SelectionProblem, Stock
from service.errors import NumericsError
from tests.balancing.selection.batch.test_solver import drawn, workshop
from tests.support.numerics.problems import even_positions

AIMS: tuple[Aim, Aim] = ("quantile_95", "probability_within_limits")


def uncertain_of(problem: SelectionProblem, seed: int, scatter: float) -> Uncertain:
    """Draws about the problem, with limits that some selections keep in most of them."""
    objectives = drawn(problem, 400, seed, scatter)
    limit = 3.0 * scatter * float(np.abs(problem.objective.offset).mean())
    rows = objectives.matrix.shape[1]
    return Uncertain(objectives, Objectives(objectives.matrix, objectives.offset, np.full(rows, 1.0 / limit), "max"))


def small(seed: int, norm: Norm) -> SelectionProblem:
    """One plane of eight holes, three masses, two pieces: 325 selections."""
    rng = np.random.default_rng(seed)
    matrix = (rng.normal(size=(2, 1)) + 1j * rng.normal(size=(2, 1))).astype(np.complex128)
    target = 60.0 * np.exp(2j * np.pi * rng.random(1))
    plane = SelectionPlane(even_positions(8), np.ones(8, int), np.full(8, np.inf), 2)
    box = Stock(np.array([10.0, 25.0, 60.0]), np.array([1, 2, 2]), np.zeros(3))
    problem = workshop(1, 2, norm, 8)
    return replace(
        problem,
        objective=replace(problem.objective, matrix=matrix, offset=-matrix @ target),
        planes=(plane,),
        stock=box,
    )


def everything(problem: SelectionProblem) -> list[Selection]:
    """All allowed selections of one plane."""
    holes, items = len(problem.planes[0].angles), len(problem.stock.masses_g)
    pieces = [Piece(hole, item) for hole, item in product(range(holes), range(items))]
    found: list[Selection] = [((),), *(((one,),) for one in pieces)]
    found += [(tuple(sorted(pair)),) for pair in combinations_with_replacement(pieces, 2)]
    return [one for one in found if broken_limit(problem, one) is None]


def best_aim(problem: SelectionProblem, uncertain: Uncertain, aim: Aim) -> FloatArray:
    vectors = np.array([vectors_of(problem, one) for one in everything(problem)])
    aims = robust_aims(uncertain, aim, vectors)
    return np.asarray(aims[np.lexsort((aims[:, 1], aims[:, 0]))[0]])


@pytest.mark.parametrize("aim", AIMS)
@pytest.mark.parametrize("norm", ["sum", "max", "rms"])
def test_the_best_there_is_where_all_selections_can_be_rated(norm: Norm, aim: Aim) -> None:
    for seed in range(4):
        problem = small(seed, norm)
        uncertain = uncertain_of(problem, seed, 0.1)
        start = solve_exact(problem).pieces
        assert start is not None
        shared = shared_rows(problem.planes, problem.stock)
        *_, last = search_robust(problem, uncertain, aim, [start], shared=shared)
        assert last.aims[0] == pytest.approx(best_aim(problem, uncertain, aim)[0], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("aim", AIMS)
@pytest.mark.parametrize("listed", [True, False])
def test_every_selection_is_allowed_and_none_worse_than_the_start(aim: Aim, listed: bool) -> None:
    problem = workshop(2, 3, "sum", 1)
    uncertain = uncertain_of(problem, 5, 0.05)
    start = solve_exact(problem).pieces
    assert start is not None
    shared = shared_rows(problem.planes, problem.stock) if listed else None
    before = robust_aims(uncertain, aim, vectors_of(problem, start)[None])[0, 0]
    states = list(search_robust(problem, uncertain, aim, [start], shared=shared, keep=4))
    assert states[0].aims[0] == before
    values = [state.aims[0] for state in states]
    assert values == sorted(values, reverse=True)
    assert values[-1] <= before
    assert len(set(states[-1].selections)) == 4
    for selection in states[-1].selections:
        assert broken_limit(problem, selection) is None


def test_an_aim_within_limits_needs_limits() -> None:
    problem = workshop(1, 2, "sum", 8)
    uncertain = Uncertain(drawn(problem, 10, 1), None)
    with pytest.raises(NumericsError, match="must have limits"):
        robust_aims(uncertain, "probability_within_limits", np.zeros((1, 1), dtype=np.complex128))
