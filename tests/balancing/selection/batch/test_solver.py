"""Many problems at once: every one equal to the exact search, also where the box binds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.solver import Answers, solve_batch
from service.balancing.selection.batch.tables import shared_rows
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.placements import broken_limit
from service.balancing.selection.problem import Norm, Objective, SelectionPlane, SelectionProblem, Stock
from tests.support.numerics.problems import even_positions
from tests.support.numerics.random_problems import KINDS, fitted_problem, random_problem


def drawn(problem: SelectionProblem, draws: int, seed: int, scatter: float = 0.03) -> Objectives:
    """Objectives about the problem's own, as repeated readings would give them."""
    rng = np.random.default_rng(seed)
    one = problem.objective

    def noise(shape: tuple[int, ...]) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
        return np.asarray(1.0 + scatter * (rng.normal(size=shape) + 1j * rng.normal(size=shape)), dtype=np.complex128)

    matrix = one.matrix * noise((draws, *one.matrix.shape))
    return Objectives(matrix, one.offset * noise((draws, len(one.offset))), one.weights, one.norm)


def workshop(planes: int, sensors: int, norm: Norm, count: int, pieces: int = 2) -> SelectionProblem:
    """Twelve holes a plane, six masses."""
    rng = np.random.default_rng([planes, sensors])
    matrix = 0.01 * (rng.normal(size=(sensors, planes)) + 1j * rng.normal(size=(sensors, planes)))
    target = 200.0 * np.exp(2j * np.pi * rng.random(planes))
    plane = SelectionPlane(even_positions(12), np.ones(12, int), np.full(12, np.inf), pieces)
    box = Stock(np.array([10.0, 20.0, 50.0, 100.0, 200.0, 300.0]), np.full(6, count), np.zeros(6))
    objective = Objective(matrix.astype(np.complex128), -matrix @ target, np.full(sensors, 1.4), norm)
    return SelectionProblem(objective, (plane,) * planes, box)


def check(problem: SelectionProblem, objectives: Objectives, answers: Answers) -> None:
    """Each answer is allowed, proved, and the one that the exact search gives."""
    assert answers.proved.all()
    for number in range(len(objectives)):
        one = Objective(objectives.matrix[number], objectives.offset[number], objectives.weights, objectives.norm)
        alone = solve_exact(replace(problem, objective=one))
        selection = answers.selection(number)
        assert broken_limit(problem, selection) is None
        assert answers.value[number] == pytest.approx(alone.value, rel=1e-9, abs=1e-300)
        assert tuple(tuple(sorted(pieces)) for pieces in selection) == alone.pieces


@pytest.mark.parametrize(
    ("planes", "sensors", "norm", "count"),
    [
        (2, 2, "sum", 8),
        (2, 2, "sum", 1),
        (2, 2, "components", 1),
        (2, 2, "max", 2),
        (2, 4, "sum", 1),
        (2, 4, "max", 8),
        (2, 3, "rms", 1),
        (2, 3, "components", 8),
        (1, 1, "sum", 8),
        (1, 2, "max", 1),
    ],
)
def test_every_draw_equals_the_exact_search(planes: int, sensors: int, norm: Norm, count: int) -> None:
    problem = workshop(planes, sensors, norm, count)
    shared = shared_rows(problem.planes, problem.stock)
    assert shared is not None
    objectives = drawn(problem, 25, 5)
    check(problem, objectives, solve_batch(shared, problem.planes, objectives))


def test_three_planes_that_share_a_small_box() -> None:
    problem = workshop(3, 3, "sum", 1)
    shared = shared_rows(problem.planes, problem.stock)
    assert shared is not None
    objectives = drawn(problem, 12, 6)
    check(problem, objectives, solve_batch(shared, problem.planes, objectives))


@pytest.mark.parametrize("kind", KINDS)
def test_random_problems_with_every_limit(kind: str) -> None:
    solved = 0
    for seed in range(14):
        problem = (random_problem if seed % 3 else fitted_problem)(kind, 40 + seed)
        shared = shared_rows(problem.planes, problem.stock)
        if shared is None:
            continue
        objectives = drawn(problem, 4, seed)
        answers = solve_batch(shared, problem.planes, objectives)
        for number in range(len(objectives)):
            one = Objective(objectives.matrix[number], objectives.offset[number], objectives.weights, objectives.norm)
            best = solve_exact(replace(problem, objective=one)).value
            scale = float(np.abs(one.offset).max())
            assert broken_limit(problem, answers.selection(number)) is None
            assert answers.value[number] == pytest.approx(best, rel=1e-8, abs=1e-8 * scale * float(one.weights.max()))
        solved += 1
    assert solved > 3


def test_too_much_to_list_is_left_to_others() -> None:
    problem = workshop(2, 2, "sum", 8, pieces=10)
    assert shared_rows(problem.planes, problem.stock) is None
