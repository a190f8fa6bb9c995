"""The outer polygons: no sum of pieces lies outside, and they are no wider than the pieces reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import _choices
from service.balancing.selection.exact.reachable_set import reach_of
from service.balancing.selection.problem import SelectionProblem, Stock
from tests.support.numerics.problems import FIELD_TARGET, field_experiment, plane
from tests.support.numerics.random_problems import KINDS, random_problem


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_holds_every_sum_of_every_plane(kind: str, seed: int) -> None:
    problem = random_problem(kind, seed)
    reach = reach_of(problem)
    for p, where in enumerate(problem.planes):
        sums = _choices(problem, p).vectors  # with `fixed`
        along = (np.conj(reach.normals)[:, None] * sums[None, :]).real
        assert (along <= reach.support[p][:, None] + 1e-9).all()
        assert (np.abs(sums - reach.centre[p]) <= reach.radius[p] + 1e-9).all()
        # The least value over the polygon is below that of every sum, whatever the direction.
        for g in (1.0 + 0j, -0.3 + 2j, 1j):
            weights = np.zeros(len(problem.planes), dtype=np.complex128)
            weights[p] = g
            assert reach.least(weights)[p] <= (np.conj(g) * sums).real.min() + 1e-9
        assert where.fixed in sums


def one_hole(stock: Stock, pieces: int) -> SelectionProblem:
    """A plane with one hole at 0 degrees and one at 90."""
    alone = field_experiment(pieces)
    objective = replace(alone.objective, matrix=alone.objective.matrix[:1, :1], offset=alone.objective.offset[:1])
    objective = replace(objective, weights=objective.weights[:1])
    return SelectionProblem(objective, (plane(np.array([0.0, np.pi / 2.0]), pieces, 1),), stock)


def test_reaches_as_far_as_the_heaviest_pieces_in_the_best_holes() -> None:
    """One piece a hole: along a hole the heaviest, between two holes both together, backwards nothing."""
    reach = reach_of(one_hole(Stock(np.array([100.0, 60.0]), np.array([1, 1]), np.zeros(2)), 2))
    support = dict(
        zip(np.rint(np.degrees(np.angle(reach.normals))).astype(int).tolist(), reach.support[0], strict=True)
    )
    assert support[0] == pytest.approx(100.0)
    assert support[45] == pytest.approx((100.0 + 60.0) * np.cos(np.pi / 4.0))
    assert support[-135] == pytest.approx(0.0)


def test_a_limit_in_grams_counts() -> None:
    bare = one_hole(Stock(np.array([100.0, 60.0]), np.array([1, 1]), np.zeros(2)), 2)
    limited = replace(bare, planes=(replace(bare.planes[0], max_mass_g=70.0),))
    assert reach_of(limited).support[0].max() <= 70.0


def test_a_box_that_cannot_fill_both_planes_bounds_them_together() -> None:
    """One 300 g piece for two planes: together they reach 300 g and not twice that."""
    problem = replace(field_experiment(1), stock=Stock(np.array([300.0]), np.array([1]), np.zeros(1)))
    reach = reach_of(problem)
    g = np.array([1.0 + 0j, 1.0 + 0j])
    assert reach.shared is not None
    assert reach.least(g).sum() == pytest.approx(-600.0)
    assert reach.least_together(g) == pytest.approx(-300.0)
    assert reach.contains(np.array([150.0 + 0j, 0j]))
    assert not reach.contains(np.array([290.0 + 0j, 290.0 + 0j]))


def test_a_box_that_fills_every_plane_is_not_shared() -> None:
    reach = reach_of(field_experiment(2))
    assert reach.shared is None
    assert reach.contains(FIELD_TARGET)
    assert not reach.contains(FIELD_TARGET * (10.0 + 0j))
