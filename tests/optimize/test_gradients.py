"""Gradients from many starts, residuals, proved bounds, and fronts of two objectives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.errors import NumericsError
from service.optimize.epsilon import EpsilonConstraint, TwoObjectives
from service.optimize.front import crowding, front_ranks, hypervolume, undominated
from service.optimize.kkt import residuals
from service.optimize.problem import FloatArray
from service.optimize.search import run
from service.optimize.smooth import SmoothProblem
from service.optimize.sqp import MultiStart

seeds = st.integers(0, 10**6)


def quadratic(rng: np.random.Generator, d: int) -> SmoothProblem:
    """A convex quadratic under a ball and a half plane, in a box."""
    root = rng.normal(size=(d, d))
    hessian, linear = root @ root.T + 0.1 * np.eye(d), 3.0 * rng.normal(size=d)
    normal, centre = rng.normal(size=d), 0.3 * rng.normal(size=d)

    def objective(x: FloatArray) -> tuple[float, FloatArray]:
        return float(0.5 * x @ hessian @ x + linear @ x), hessian @ x + linear

    def constraints(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        away = x - centre
        return np.array([away @ away - 1.0, normal @ x - 0.5]), np.stack([2.0 * away, normal])

    return SmoothProblem(np.full(d, -1.5), np.full(d, 1.5), objective, constraints, convex=True)


@given(seeds, st.integers(2, 8))
@settings(max_examples=40)
def test_a_convex_problem_is_solved_and_proved(seed: int, d: int) -> None:
    problem = quadratic(np.random.default_rng(seed), d)
    search = MultiStart((problem,), np.random.default_rng(seed))
    found = run(search, 2, seed)
    assert found.feasible
    evidence = search.evidence()
    assert evidence.kind == "proved_bound"
    assert evidence.bound is not None
    scale = max(abs(found.value), 1.0)
    assert -1e-7 * scale <= found.value - evidence.bound <= 1e-5 * scale


@given(seeds, st.integers(2, 6))
@settings(max_examples=40)
def test_the_proved_bound_is_below_every_feasible_point(seed: int, d: int) -> None:
    """At any point at all the multipliers give a bound; it must not be above what a feasible point has."""
    rng = np.random.default_rng(seed)
    problem = quadratic(rng, d)
    at = rng.uniform(problem.lower, problem.upper)
    bound = residuals(problem, at).bound
    points = rng.uniform(-1.5, 1.5, (300, d))
    for x in points:
        if problem.violation(x) <= 0.0:
            assert problem.objective(x)[0] >= bound - 1e-9 * max(1.0, abs(bound))


def test_an_infeasible_problem_is_told() -> None:
    problem = SmoothProblem(
        np.zeros(2),
        np.ones(2),
        lambda x: (float(x.sum()), np.ones(2)),
        lambda x: (3.0 - x[:1], np.array([[-1.0, 0.0]])),
    )
    search = MultiStart((problem,), np.random.default_rng(1))
    found = run(search, 3, 1)
    assert found.status == "infeasible"
    assert found.violation == pytest.approx(2.0)
    assert search.evidence().kind == "none"


def test_bounds_that_are_crossed_are_refused() -> None:
    problem = SmoothProblem(np.ones(2), np.zeros(2), lambda x: (0.0 * x[0], np.zeros(2)))
    with pytest.raises(NumericsError, match="the lower first") as refused:
        MultiStart((problem,), np.random.default_rng(1))
    assert refused.value.code == "bounds_crossed"


def two_bowls(points: int) -> EpsilonConstraint:
    """Squares of the distances to (0, 0) and (1, 0): the front is sqrt(f2) = 1 - sqrt(f1)."""
    here, there = np.zeros(2), np.array([1.0, 0.0])
    first = SmoothProblem(
        np.full(2, -2.0), np.full(2, 2.0), lambda x: (float((x - here) @ (x - here)), 2.0 * (x - here)), convex=True
    )
    problem = TwoObjectives((first,), lambda x: (float((x - there) @ (x - there)), 2.0 * (x - there)), power=2)
    return EpsilonConstraint(problem, points, np.random.default_rng(1))


def test_a_front_of_two_objectives() -> None:
    search = two_bowls(21)
    for _ in search:
        pass
    objectives, designs = search.front()
    assert len(objectives) >= 20
    np.testing.assert_allclose(objectives.sum(axis=1), 1.0, atol=1e-5)
    np.testing.assert_allclose(designs[:, 1], 0.0, atol=1e-4)
    assert hypervolume(objectives, (1.0, 1.0)) == pytest.approx(0.5 * (1.0 - 1.0 / 20.0), abs=1e-3)


def test_a_front_of_one_point_is_refused() -> None:
    with pytest.raises(NumericsError, match="at least 2 points, got 1"):
        two_bowls(1)


points = st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8)), min_size=1, max_size=15)


@given(points)
def test_hypervolume_counts_the_cells_below_the_reference(found: list[tuple[int, int]]) -> None:
    cells = sum(any(a <= i and b <= j for a, b in found) for i in range(8) for j in range(8))
    assert hypervolume(np.array(found, dtype=np.float64), (8.0, 8.0)) == cells


@given(points)
def test_ranks_and_undominated_agree_with_their_definition(found: list[tuple[int, int]]) -> None:
    values = np.array(found, dtype=np.float64)
    ranks = front_ranks(values)
    for i, one in enumerate(values):
        beaten = [j for j, other in enumerate(values) if (other <= one).all() and (other < one).any()]
        assert (ranks[i] == 0) == (not beaten)
        assert not beaten or ranks[i] == 1 + max(ranks[j] for j in beaten)
    kept = {tuple(values[i]) for i in undominated(values)}
    assert kept == {tuple(one) for one, rank in zip(values, ranks, strict=True) if rank == 0}


def test_crowding_and_feasibility_before_rank() -> None:
    np.testing.assert_allclose(crowding(np.array([[0.0, 4.0], [1.0, 2.0], [4.0, 0.0]])), [np.inf, 2.0, np.inf])
    ranks = front_ranks(np.array([[0.0, 0.0], [5.0, 5.0], [1.0, 1.0]]), np.array([0.1, 0.0, 0.2]))
    np.testing.assert_array_equal(ranks, [1, 0, 2])
    assert hypervolume(np.array([[2.0, 2.0]]), (1.0, 1.0)) == 0.0
