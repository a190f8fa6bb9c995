"""Meet in the middle: every selection of a plane whose sum lies in an ellipse, each of them once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import _choices
from service.balancing.selection.exact.meet_in_middle import Split, cost_of, depth_of, near, split_of
from service.balancing.selection.exact.plane_table import Ellipse
from service.balancing.selection.exact.subsets import placements_of
from service.balancing.selection.problem import SelectionProblem
from tests.support.numerics.problems import even_positions, field_experiment, plane, stock
from tests.support.numerics.steps import finished


def split(problem: SelectionProblem, most: int) -> Split:
    made = finished(split_of(placements_of(problem.planes[0], problem.stock), most))
    assert made is not None
    return made


def few(pieces: int, capacity: int) -> SelectionProblem:
    """One plane of six holes and three kinds of mass, two of each in the box."""
    whole = field_experiment(pieces)
    return replace(
        whole,
        planes=(plane(even_positions(6), pieces, capacity),) * 2,
        stock=stock((10.0, 35.0, 60.0), 2),
    )


@pytest.mark.parametrize("pieces", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("capacity", [1, 2, 9])
def test_finds_every_selection_in_the_ellipse_once(pieces: int, capacity: int) -> None:
    problem = few(pieces, capacity)
    made = split(problem, pieces)
    wanted = _choices(problem, 0).vectors
    for centre, radius in ((0j, 1e3), (40 + 20j, 30.0), (-60j, 5.0), (35 + 0j, 1e-6)):
        ellipse = Ellipse(centre, np.array([[1.0, 0.4], [0.0, 1.5]]), radius)
        parts = list(near(made, ellipse))
        rows = [tuple(row) for part in parts for row in part.index.tolist()]
        assert len(rows) == len(set(rows)) == int((ellipse.distance(wanted) <= radius).sum())
        for part in parts:
            assert made.placements.allowed(part.index).all()
            np.testing.assert_allclose(made.placements.vector[part.index].sum(axis=1), part.vector, atol=1e-9)


def test_a_table_of_fewer_pieces_serves_more() -> None:
    """Rungs climb: the table that was made for 3 pieces is handed on."""
    problem = few(4, 2)
    placements = placements_of(problem.planes[0], problem.stock)
    lower = split(problem, 3)
    again = finished(split_of(placements, 4, lower.table))
    assert again is not None
    everything = Ellipse(0j, np.eye(2), 1e3)
    assert sum(map(len, near(again, everything))) == len(_choices(problem, 0).vectors)


def test_the_depth_is_about_half_of_the_pieces() -> None:
    placements = placements_of(plane(even_positions(18), 6), stock())
    assert [depth_of(placements, most) for most in (1, 2, 3, 4)] == [1, 1, 2, 2]


def test_what_is_too_long_to_list_is_refused_before_it_is_made() -> None:
    """200 holes, 6 kinds: halves of 4 pieces are 10^11; cost is infinite and there is no split."""
    placements = placements_of(plane(even_positions(200), 8), stock())
    assert cost_of(placements, 8) == np.inf
    assert finished(split_of(placements, 8)) is None
    assert cost_of(placements, 2) < cost_of(placements, 3) < np.inf


def test_moments_are_about_those_of_the_sums() -> None:
    """Any of 18 holes with one piece of up to 300 g: the sums are centred, and spread as the pieces are."""
    made = split(field_experiment(2), 2)
    sums = _choices(field_experiment(2), 0).vectors
    mean, variance = made.moments()
    assert abs(mean) < 30.0
    assert variance == pytest.approx(0.5 * float(np.mean(np.abs(sums) ** 2)), rel=0.5)
    assert made.selections == pytest.approx(len(sums), rel=0.5)
