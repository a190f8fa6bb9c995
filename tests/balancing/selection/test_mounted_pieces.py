"""Pieces on the rotor: staying, moving, coming off, each against the same problem stated by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.jaya import solve_jaya
from service.balancing.selection.mounted_pieces import (
    May,
    MountedPiece,
    placement_uncertainty,
    position_at,
    with_fitted,
)
from service.balancing.selection.objectives import components, evaluate
from service.balancing.selection.placements import broken_limit
from service.balancing.selection.problem import Piece, SelectionPlane, SelectionProblem
from service.errors import NumericsError
from tests.support.numerics.problems import even_positions, field_experiment, plane, stock
from tests.support.numerics.random_problems import KINDS, random_problem

TOLERANCE = np.deg2rad(2.0)
FOUR = even_positions(4)  # 90, 180, 270, 360 degrees


def problem(target: complex, counts: int = 1) -> SelectionProblem:
    objective = components(np.array([target]), np.array([100.0]))
    return SelectionProblem(objective, (plane(FOUR, 2, capacity=1),), stock((10.0, 30.0), counts=counts))


def at(position: int, mass: float, may: May) -> MountedPiece:
    return MountedPiece(0, float(FOUR[position]), mass, may)


def test_a_piece_that_must_stay_takes_its_position_and_counts() -> None:
    """As found, its effect is in the readings already: the target is what is missing besides it."""
    stated = with_fitted(problem(10j), [at(0, 30.0, "stay")], in_offset=True, tolerance=TOLERANCE)
    assert stated.problem.planes[0].capacity.tolist() == [0, 1, 1, 1]
    assert stated.problem.planes[0].max_pieces == 1
    assert stated.problem.planes[0].fixed == 0j
    planned = with_fitted(problem(10j), [at(0, 30.0, "stay")], in_offset=False, tolerance=TOLERANCE)
    assert planned.problem.planes[0].fixed == pytest.approx(30j)


def test_a_removable_piece_comes_off_where_that_is_better_and_goes_nowhere_else() -> None:
    """The rotor wants -30 g at 90 degrees; the piece welded there weighs 30 g."""
    stated = with_fitted(problem(-30j, 1), [at(0, 30.0, "remove")], in_offset=True, tolerance=TOLERANCE)
    found = solve_exact(stated.problem)
    assert found.value == pytest.approx(0.0, abs=1e-6)
    assert found.pieces is not None
    fates, new = stated.fates(found.pieces)
    assert fates[0].does == "comes_off"
    assert new == ((),)
    wanted_elsewhere = with_fitted(problem(-60j), [at(0, 30.0, "remove")], in_offset=True, tolerance=TOLERANCE)
    better = solve_exact(wanted_elsewhere.problem)
    assert better.pieces is not None
    assert wanted_elsewhere.fates(better.pieces)[1] == ((Piece(2, 1),),)


def test_a_piece_that_may_stay_stays_where_that_is_best() -> None:
    stated = with_fitted(
        problem(10j), [at(1, 30.0, "move"), at(2, 10.0, "remove")], in_offset=True, tolerance=TOLERANCE
    )
    found = solve_exact(stated.problem)
    assert found.value == pytest.approx(0.0, abs=1e-6)
    assert found.pieces is not None
    fates, new = stated.fates(found.pieces)
    assert [f.does for f in fates] == ["stays", "comes_off"]
    assert new == ((),)


def test_a_movable_piece_moves() -> None:
    """20 g from 180 to 360 degrees is worth 40 g; nothing in the box weighs that."""
    stated = with_fitted(problem(40.0), [at(1, 20.0, "move")], in_offset=True, tolerance=TOLERANCE)
    found = solve_exact(stated.problem)
    assert found.pieces is not None
    fates, new = stated.fates(found.pieces)
    assert fates[0].does == "moves"
    assert fates[0].to == (0, 3)
    assert new == ((),)


def test_a_movable_piece_joins_the_stock_of_its_mass() -> None:
    stated = with_fitted(problem(10j), [at(1, 30.0, "move")], in_offset=True, tolerance=TOLERANCE)
    assert stated.problem.stock.counts.tolist() == [1, 2]
    assert stated.items == (1,)


@pytest.mark.parametrize("kind", KINDS)
def test_solvers_agree_with_pieces_on_the_rotor(kind: str) -> None:
    rng = np.random.default_rng(7)
    for seed in range(6):
        bare = random_problem(kind, 700 + seed)
        first: SelectionPlane = bare.planes[0]
        choices: tuple[tuple[int, float, May], ...] = ((0, 25.0, "remove"), (1, 35.0, "move"))
        fitted = [MountedPiece(0, float(first.angles[h]), mass, may) for h, mass, may in choices]
        stated = with_fitted(bare, fitted, in_offset=bool(rng.integers(2)), tolerance=TOLERANCE)
        judge = solve_exhaustive(stated.problem, most=10**7)
        found = solve_exact(stated.problem)
        assert found.value == pytest.approx(judge.value, rel=1e-8, abs=1e-8)
        guess = solve_jaya(stated.problem, seed, generations=20)
        assert guess.pieces is not None
        assert broken_limit(stated.problem, guess.pieces) is None
        assert guess.value >= judge.value * (1.0 - 1e-8)


def test_angles_that_are_no_position_are_refused() -> None:
    one = problem(10j).planes[0]
    assert position_at(one, float(np.deg2rad(-0.5)), TOLERANCE) == 3
    with pytest.raises(
        NumericsError, match="a mounted piece must be within 2 degrees of a position, got 45 degrees at an angle"
    ):
        position_at(one, float(np.deg2rad(45.0)), TOLERANCE)
    with pytest.raises(NumericsError, match="a mounted piece must be in one of 1 planes, got plane 3"):
        with_fitted(problem(1j), [MountedPiece(3, 0.0, 1.0, "stay")], in_offset=True, tolerance=TOLERANCE)
    with pytest.raises(NumericsError, match="a mounted piece must have a mass above 0, got 0 g"):
        with_fitted(problem(1j), [MountedPiece(0, 0.0, 0.0, "stay")], in_offset=True, tolerance=TOLERANCE)


@pytest.mark.parametrize("kind", KINDS)
def test_pieces_off_their_positions_change_the_objective_by_no_more_than_stated(kind: str) -> None:
    rng = np.random.default_rng(11)
    for seed in range(10):
        whole = random_problem(kind, 900 + seed)
        found = solve_exact(whole)
        assert found.pieces is not None
        most = placement_uncertainty(whole, found.pieces, TOLERANCE)
        for _ in range(20):
            planes = tuple(
                replace(p, angles=p.angles + rng.choice([-1.0, 1.0], len(p.angles)) * TOLERANCE) for p in whole.planes
            )
            mass = whole.stock.masses_g + whole.stock.fasteners_g
            u = [
                p.fixed + sum(mass[q.item] * np.exp(1j * p.angles[q.position]) for q in chosen)
                for p, chosen in zip(planes, found.pieces, strict=True)
            ]
            assert abs(float(evaluate(whole.objective, np.array(u))) - found.value) <= most * (1.0 + 1e-9) + 1e-9


def test_no_piece_no_uncertainty() -> None:
    assert placement_uncertainty(field_experiment(2), ((), ()), TOLERANCE) == 0.0
