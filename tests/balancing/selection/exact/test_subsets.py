"""Selections of one plane: which pairs of position and piece there are, how they combine, what they add up to."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import _choices
from service.balancing.selection.exact import subsets
from service.balancing.selection.exact.subsets import gathered, levels_of, many_of, placements_of
from service.balancing.selection.problem import Piece, Stock
from tests.support.numerics.problems import even_positions, plane, stock
from tests.support.numerics.random_problems import KINDS, random_problem
from tests.support.numerics.steps import finished

TWO = Stock(np.array([10.0, 50.0]), np.array([2, 1]), np.array([1.0, 0.0]))


def test_lists_what_may_go_where_and_nothing_last() -> None:
    """Two holes, two kinds of mass: four pairs by hole, then by kind, fasteners counted, then "no piece"."""
    made = placements_of(plane(even_positions(2), 3), TWO)
    assert made.position.tolist() == [0, 0, 1, 1, 2]
    assert made.item.tolist() == [0, 1, 0, 1, 2]
    assert made.mass.tolist() == [11.0, 50.0, 11.0, 50.0, 0.0]
    np.testing.assert_allclose(made.vector, [-11.0, -50.0, 11.0, 50.0, 0.0], atol=1e-12)
    assert (made.none, made.most) == (4, 3)


def test_leaves_out_what_a_limit_forbids_by_itself() -> None:
    bare = plane(even_positions(2), 3)
    closed = replace(bare, capacity=np.array([0, 1]))
    light = replace(bare, capacity_g=np.array([20.0, np.inf]))
    forbidden = replace(bare, allowed=np.array([[True, False], [False, True]]))
    assert placements_of(closed, TWO).position[:-1].tolist() == [1, 1]
    assert placements_of(light, TWO).item[:-1].tolist() == [0, 0, 1]
    assert list(
        zip(placements_of(forbidden, TWO).position[:-1], placements_of(forbidden, TWO).item[:-1], strict=True)
    ) == [
        (0, 0),
        (1, 1),
    ]
    assert placements_of(replace(bare, max_mass_g=20.0), TWO).item[:-1].tolist() == [0, 0]
    assert placements_of(bare, replace(TWO, counts=np.array([0, 1]))).item[:-1].tolist() == [1, 1]
    assert placements_of(bare, TWO, most=1).most == 1


def test_rows_that_break_a_limit_are_told() -> None:
    """Pairs 0: 11 g, 1: 50 g in hole 0; 2, 3 the same in hole 1; 4 no piece."""
    made = placements_of(replace(plane(even_positions(2), 3, capacity=2), max_mass_g=75.0), TWO)
    rows = np.array([[0, 0, 4], [0, 0, 0], [1, 3, 4], [0, 1, 4], [0, 2, 3], [4, 4, 4]])
    #                two of two   three: no  two 50s    61 g       72 g       nothing
    assert made.allowed(rows).tolist() == [True, False, False, True, True, True]
    heavy = replace(made, max_mass_g=60.0)
    assert heavy.allowed(rows).tolist() == [True, False, False, False, False, True]
    grams = replace(made, capacity_g=np.array([55.0, 55.0, np.inf]))
    assert grams.allowed(rows).tolist() == [True, False, False, False, False, True]


def test_pieces_of_a_row() -> None:
    made = placements_of(plane(even_positions(2), 3), TWO)
    assert made.pieces(np.array([3, 0, 4])) == (Piece(0, 0), Piece(1, 1))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_levels_are_all_selections_once(kind: str, seed: int) -> None:
    problem = random_problem(kind, seed)
    for p, where in enumerate(problem.planes):
        made = placements_of(where, problem.stock)
        levels = finished(levels_of(made, np.arange(made.none), made.most))
        sums = finished(gathered(made, levels, max(made.most, 1)))
        wanted = _choices(problem, p)
        assert len(sums) == len(wanted.pairs)
        assert len({tuple(row) for row in sums.index.tolist()}) == len(sums)
        assert all(made.allowed(level).all() for level in levels)
        np.testing.assert_allclose(
            np.sort_complex(np.round(sums.vector + where.fixed, 6)),
            np.sort_complex(np.round(wanted.vectors, 6)),
            atol=2e-6,
        )


def test_levels_end_where_no_more_pieces_fit() -> None:
    made = placements_of(plane(even_positions(2), 9, capacity=1), TWO)
    assert [len(level) for level in finished(levels_of(made, np.arange(made.none), made.most))] == [1, 4, 3]


def test_counting_bounds_the_selections() -> None:
    """18 holes, 6 kinds, any number in a hole: multisets of up to 3 of 108 pairs; one in a hole: fewer."""
    free = placements_of(plane(even_positions(18), 3), stock())
    assert many_of(free, None, 3) == sum(math.comb(108 + k - 1, k) for k in range(4))
    assert many_of(free, 0, 2) == many_of(free, 1, 2) == sum(math.comb(54 + k - 1, k) for k in range(3))
    single = placements_of(plane(even_positions(18), 3, capacity=1), stock())
    assert many_of(single, None, 2) == 1 + 108 + math.comb(18, 2) * 36
    assert many_of(free, None, subsets.MAX_LISTED) < math.inf
    assert many_of(free, None, subsets.MAX_LISTED + 1) == math.inf
