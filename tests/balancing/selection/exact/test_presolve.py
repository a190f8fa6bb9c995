"""Presolve: planes that cannot matter are left out, long boxes are thinned, answers are mapped back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from service.balancing.selection.exact.presolve import opened
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import vectors_of
from service.balancing.selection.problem import Piece, Stock
from tests.support.numerics.problems import field_experiment


def test_a_plane_without_room_is_left_out_and_stays_empty() -> None:
    bare = field_experiment(2)
    first, second = bare.planes
    whole = replace(bare, planes=(replace(first, max_pieces=0, fixed=25j), second))
    found = opened(whole)
    assert (found.open, found.planes, len(found.problem.planes)) == ((1,), 2, 1)
    chosen = ((Piece(3, 2), Piece(5, 0)),)
    assert found.widen(chosen) == ((), chosen[0])
    assert found.narrow(((), chosen[0])) == chosen
    # What is fixed in the plane that was left out still counts.
    np.testing.assert_allclose(
        evaluate(found.problem.objective, vectors_of(found.problem, chosen)),
        evaluate(whole.objective, vectors_of(whole, ((), chosen[0]))),
    )


def test_a_plane_without_effect_is_left_out() -> None:
    bare = field_experiment(2)
    matrix = bare.objective.matrix * np.array([1.0, 1e-15])
    assert opened(replace(bare, objective=replace(bare.objective, matrix=matrix))).open == (0,)
    faint = bare.objective.matrix * np.array([1.0, 1e-13])
    assert opened(replace(bare, objective=replace(bare.objective, matrix=faint))).open == (0, 1)


def test_a_long_box_is_thinned_over_its_masses() -> None:
    """18 holes: 90 pairs are 5 items of 100, the lightest and the heaviest among them, and those in use."""
    masses = np.arange(1.0, 101.0)[::-1]
    whole = replace(field_experiment(2), stock=Stock(masses, np.full(100, 3), np.zeros(100)))
    used = ((Piece(0, 7),), ())
    found = opened(whole).thinned(90, used)
    assert found.items is not None
    assert len(found.items) == 6
    assert set(found.problem.stock.masses_g) >= {1.0, 100.0, masses[7]}
    inner = found.narrow(used)
    assert found.problem.stock.masses_g[inner[0][0].item] == masses[7]
    assert found.widen(inner) == used
    assert opened(whole).thinned(18 * 100, None).items is None


def test_a_restriction_follows_the_thinned_box() -> None:
    bare = replace(field_experiment(2), stock=Stock(np.arange(1.0, 101.0), np.full(100, 3), np.zeros(100)))
    allowed = np.zeros((18, 100), dtype=bool)
    allowed[:, 99] = True
    whole = replace(bare, planes=tuple(replace(p, allowed=allowed) for p in bare.planes))
    found = opened(whole).thinned(36, None)
    kept = found.problem.planes[0].allowed
    assert kept is not None
    assert kept.shape == (18, 2)
    assert kept[:, 1].all()
    assert not kept[:, 0].any()


def test_planes_are_alike_where_all_their_limits_are() -> None:
    bare = field_experiment(2)
    assert opened(bare).alike(0, 1)
    first, second = bare.planes
    for other in (
        replace(second, max_pieces=1),
        replace(second, max_mass_g=100.0),
        replace(second, capacity=np.full(18, 1)),
        replace(second, capacity_g=np.full(18, 50.0)),
        replace(second, angles=second.angles + 0.1),
        replace(second, allowed=np.ones((18, 6), dtype=bool)),
    ):
        assert not opened(replace(bare, planes=(first, other))).alike(0, 1)
