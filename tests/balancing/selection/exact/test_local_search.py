"""Local search: ends where no single change helps, never breaks a limit, never gets worse."""

from __future__ import annotations

import itertools

import pytest

from service.balancing.selection.exact.local_search import descend
from service.balancing.selection.exact.presolve import opened
from service.balancing.selection.exact.subsets import placements_of
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, broken_limit, vectors_of
from service.balancing.selection.problem import Piece, SelectionProblem
from tests.support.numerics.problems import field_experiment
from tests.support.numerics.random_problems import KINDS, random_problem


def ends(problem: SelectionProblem, start: Selection, most: int | None = None) -> list[Selection]:
    """Selections on the way down, the start first."""
    placements = [placements_of(plane, problem.stock) for plane in problem.planes]
    return [start, *(better for better in descend(problem, placements, start, most) if better is not None)]


def value(problem: SelectionProblem, selection: Selection) -> float:
    return float(evaluate(problem.objective, vectors_of(problem, selection)))


def neighbours(problem: SelectionProblem, selection: Selection) -> list[Selection]:
    """Everything that one piece more, less or elsewhere makes of it, within the limits."""
    every = [Piece(h, i) for h in range(18) for i in range(len(problem.stock.masses_g))]
    out: list[Selection] = []
    for p, pieces in enumerate(selection):
        open_holes = len(problem.planes[p].angles)
        less = [pieces[:k] + pieces[k + 1 :] for k in range(len(pieces))]
        more = [(*kept, one) for kept in (pieces, *less) for one in every if one.position < open_holes]
        out += [(*selection[:p], tuple(sorted(row)), *selection[p + 1 :]) for row in (*less, *more)]
    return [one for one in out if broken_limit(problem, one) is None]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_goes_down_to_where_no_single_change_helps(kind: str, seed: int) -> None:
    problem = opened(random_problem(kind, seed)).problem
    way = ends(problem, ((),) * len(problem.planes))
    worth = [value(problem, one) for one in way]
    assert all(after < before for before, after in itertools.pairwise(worth))
    assert all(broken_limit(problem, one) is None for one in way)
    assert all(value(problem, one) >= worth[-1] * (1.0 - 1e-8) - 1e-12 for one in neighbours(problem, way[-1]))


def test_begins_with_the_best_change() -> None:
    problem = field_experiment(2)
    empty: Selection = ((), ())
    first = ends(problem, empty)[1]
    assert value(problem, first) == pytest.approx(min(value(problem, one) for one in neighbours(problem, empty)))


def test_pieces_in_all_planes_together_are_limited() -> None:
    problem = field_experiment(3)
    assert sum(map(len, ends(problem, ((), ()), most=1)[-1])) == 1
    assert sum(map(len, ends(problem, ((), ()), most=None)[-1])) > 1
