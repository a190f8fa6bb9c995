"""Joining planes: every combination within the ellipsoid, and the box asked of those alone."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from service.balancing.selection.exact.level_ellipsoid import Ellipsoid
from service.balancing.selection.exact.plane_join import Ceiling, Joint, PlaneList, combine, combine_up_to
from service.balancing.selection.exact.subsets import gathered, levels_of, placements_of
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import vectors_of
from service.balancing.selection.problem import Stock
from tests.support.numerics.problems import even_positions, field_experiment, plane
from tests.support.numerics.steps import finished

BOX = Stock(np.array([10.0, 40.0]), np.array([3, 1]), np.zeros(2))
ALL = Ellipsoid(np.zeros(4), np.eye(4) * 1e-9)
"""Holds everything."""
HIGH = Ceiling(np.eye(4).reshape(2, 2, 4), np.zeros((2, 2)), "sum", 1e9)
"""Is above everything."""


def lists() -> list[PlaneList]:
    """All selections of up to two pieces in each of two planes with three holes; 1 g is fixed in the second."""
    made = []
    for fixed in (0j, 1 + 0j):
        placements = placements_of(plane(even_positions(3), 2, 1), BOX)
        levels = finished(levels_of(placements, np.arange(placements.none), 2))
        made.append(PlaneList.of(finished(gathered(placements, levels, 2)), placements, fixed))
    return made


def rows(joints: list[Joint]) -> list[tuple[int, ...]]:
    return sorted(tuple(row) for joint in joints for row in joint.rows.tolist())


def test_a_list_knows_pieces_mass_and_how_rare_they_are() -> None:
    first = lists()[0]
    for row in range(len(first.pieces)):
        pieces = first.selection(row)
        assert first.pieces[row] == len(pieces)
        assert first.mass_g[row] == sum(BOX.masses_g[p.item] for p in pieces)
        assert first.scarcity[row] == pytest.approx(sum(1.0 / BOX.counts[p.item] for p in pieces))
    assert set(first.only(1).pieces.tolist()) == {1}


def test_without_limits_every_combination_comes_once() -> None:
    both = lists()
    wanted = sorted(itertools.product(range(len(both[0].vector)), range(len(both[1].vector))))
    assert rows(list(combine(both, ALL, HIGH))) == wanted


def test_the_ellipsoid_decides_which() -> None:
    both = lists()
    rng = np.random.default_rng(5)
    turn = rng.normal(size=(4, 4))
    region = Ellipsoid(np.array([20.0, 0.0, -10.0, 15.0]), turn.T @ turn / 40.0**2)
    inside = []
    for i, j in itertools.product(range(len(both[0].vector)), range(len(both[1].vector))):
        u, v = both[0].vector[i], both[1].vector[j]
        x = np.array([u.real, u.imag, v.real, v.imag]) - region.centre
        if x @ region.form @ x <= 1.0:
            inside.append((i, j))
    found = rows(list(combine(both, region, HIGH)))
    assert 0 < len(inside) < 100
    assert found == inside


@pytest.mark.parametrize("norm", ["sum", "max", "rms", "components"])
def test_a_ceiling_leaves_out_only_what_is_above_it(norm: str) -> None:
    """Groups are the two planes' own sums: for `sum` |u_1| + |u_2| must not be above the level."""
    both = lists()
    level = 45.0
    region = Ellipsoid(np.zeros(4), np.eye(4) / (2.0 * 80.0**2))
    grouped = np.eye(4).reshape(4, 1, 4) if norm == "components" else np.eye(4).reshape(2, 2, 4)
    ceiling = Ceiling(grouped, np.zeros(grouped.shape[:2]), norm, level)
    kept = set(rows(list(combine(both, region, ceiling))))
    for i, j in rows(list(combine(both, region, HIGH))):
        u, v = both[0].vector[i], both[1].vector[j]
        value = {
            "sum": abs(u) + abs(v),
            "max": max(abs(u), abs(v)),
            "rms": math.hypot(abs(u), abs(v)),
            "components": abs(u.real) + abs(u.imag) + abs(v.real) + abs(v.imag),
        }[norm]
        assert value > level or (i, j) in kept


def test_pieces_in_all_planes_together_are_limited() -> None:
    both = lists()
    for most in range(5):
        joints = list(combine_up_to(both, ALL, HIGH, most))
        found = sorted(joint.selection(row) for joint in joints for row in range(len(joint)))
        every = itertools.product(range(len(both[0].pieces)), range(len(both[1].pieces)))
        whole = [(both[0].selection(i), both[1].selection(j)) for i, j in every]
        assert found == sorted(one for one in whole if len(one[0]) + len(one[1]) <= most)


def test_the_box_is_asked_of_the_chosen() -> None:
    """Of the 40 g mass there is one: not in both planes."""
    both = lists()
    joint = next(one for one in combine(both, ALL, HIGH) if len(one))
    chosen = np.arange(len(joint))
    fits = joint.in_the_box(chosen, BOX.counts)
    for row in chosen.tolist():
        items = [piece.item for pieces in joint.selection(row) for piece in pieces]
        assert fits[row] == (items.count(0) <= 3 and items.count(1) <= 1)
        assert joint.total("pieces", np.array([row]))[0] == len(items)
    assert 0 < fits.sum() < len(joint)


def test_the_vectors_are_those_of_the_selection() -> None:
    both = lists()
    joint = next(one for one in combine(both, ALL, HIGH) if len(one))
    whole = field_experiment(2)
    planes = tuple(plane(even_positions(3), 2, 1) for _ in range(2))
    for row in range(0, len(joint), 7):
        placed = type(whole)(whole.objective, planes, BOX)
        own = vectors_of(placed, joint.selection(row)) + np.array([0j, 1 + 0j])
        np.testing.assert_allclose(joint.vectors[row], own, atol=1e-9)
        assert evaluate(whole.objective, joint.vectors[row]) == pytest.approx(float(evaluate(whole.objective, own)))
