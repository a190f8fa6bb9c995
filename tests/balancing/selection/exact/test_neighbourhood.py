"""Smaller problems around a selection: what is found in one, with the pieces that stay, is one of the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.exact.neighbourhood import Neighbourhood, neighbourhood, thinned
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, broken_limit, vectors_of
from service.balancing.selection.problem import Piece, SelectionProblem, Stock
from tests.support.numerics.problems import field_experiment

CHOSEN: Selection = (
    (Piece(0, 3), Piece(4, 1), Piece(9, 5)),
    (Piece(2, 0), Piece(2, 4)),
)


def value(problem: SelectionProblem, selection: Selection) -> float:
    return float(evaluate(problem.objective, vectors_of(problem, selection)))


def same(whole: SelectionProblem, part: Neighbourhood) -> None:
    """The part's own start is the whole's selection, worth the same in both."""
    assert part.widen(part.start) == tuple(tuple(sorted(pieces)) for pieces in CHOSEN)
    assert value(part.problem, part.start) == pytest.approx(value(whole, CHOSEN), rel=1e-9)
    assert broken_limit(part.problem, part.start) is None


@pytest.mark.parametrize("seed", range(8))
def test_the_selection_is_one_of_the_smaller_problem(seed: int) -> None:
    whole = field_experiment(3)
    part = neighbourhood(whole, CHOSEN, 1e9, np.random.default_rng(seed))
    same(whole, part)
    kept = [sorted(pieces) for pieces in part.kept]
    assert all(piece in CHOSEN[p] for p, pieces in enumerate(kept) for piece in pieces)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_found_keeps_the_limits_of_the_whole(seed: int) -> None:
    """One piece a hole, three of each mass: pieces that stay use up their hole and their part of the box."""
    bare = field_experiment(3)
    one_a_hole = tuple(replace(plane, capacity=np.ones(18, np.int64)) for plane in bare.planes)
    whole = replace(bare, planes=one_a_hole, stock=replace(bare.stock, counts=np.ones(6, np.int64)))
    chosen: Selection = ((Piece(0, 3), Piece(4, 1)), (Piece(2, 0),))
    part = neighbourhood(whole, chosen, 1e9, np.random.default_rng(seed))
    alone = replace(
        part.problem, planes=tuple(replace(p, max_pieces=min(p.max_pieces, 1)) for p in part.problem.planes)
    )
    found = solve_exhaustive(alone, most=10**8).pieces
    assert found is not None
    assert broken_limit(whole, part.widen(found)) is None


def test_heavy_items_are_left_out() -> None:
    part = neighbourhood(field_experiment(3), ((), ()), 60.0, np.random.default_rng(0))
    assert part.problem.stock.masses_g.max() <= 60.0


def test_every_second_item_of_a_long_box() -> None:
    long = replace(field_experiment(2), stock=Stock(np.arange(1.0, 101.0), np.full(100, 2), np.zeros(100)))
    used: Selection = ((Piece(0, 40),), ())
    part = thinned(long, used, 80.0, 2)
    assert part is not None
    assert part.problem.stock.masses_g.max() <= 80.0
    assert 40 <= len(part.items) <= 41
    assert part.widen(part.start) == used


def test_few_items_or_all_of_them_are_no_smaller_problem() -> None:
    assert thinned(field_experiment(2), ((), ()), 1e9, 2) is None
    long = replace(field_experiment(2), stock=Stock(np.arange(1.0, 101.0), np.full(100, 2), np.zeros(100)))
    assert thinned(long, ((), ()), 1e9, 1) is None
