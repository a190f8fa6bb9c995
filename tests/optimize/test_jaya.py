"""The rules of modified Jaya, one by one."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from service.errors import NumericsError
from service.optimize.jaya import Jaya, solve
from service.optimize.problem import Circular, Continuous, FloatArray, Integer, MixedProblem


def sphere(centre: float, d: int = 4) -> MixedProblem:
    return MixedProblem(
        (Continuous(-10.0, 10.0),) * d, lambda x: (((x - centre) ** 2).sum(axis=1), np.zeros((len(x), 1)))
    )


def test_improved_rules_find_a_negative_optimum_where_the_printed_form_does_not() -> None:
    assert (solve(sphere(-3.0), 20, 400, seed=1, runs=10).values < 1e-12).all()
    assert (solve(sphere(-3.0), 20, 400, seed=1, runs=10, rules="published").values > 0.01).all()
    assert (solve(sphere(3.0), 20, 400, seed=1, runs=10, rules="published").values < 1e-12).all()


def test_runs_advance_together_and_each_succeeds() -> None:
    result = solve(sphere(2.0), 20, 300, seed=4, runs=6)
    assert result.values.shape == (6,)
    assert (result.values < 1e-9).all()
    assert result.value == result.values.min()
    assert result.evaluations == 6 * 20 * 300


def test_feasible_goes_before_infeasible() -> None:
    """Minimum of x + y under x + y >= 3: without the rule everybody runs to the infeasible corner."""
    problem = MixedProblem(
        (Continuous(0.0, 10.0), Integer(0, 10)), lambda x: (x.sum(axis=1), 1.0 - x.sum(axis=1)[:, None] / 3.0)
    )
    for rules in ("improved", "published"):
        result = solve(problem, 20, 300, seed=2, rules=rules)
        assert result.violation == 0.0
        assert result.value == pytest.approx(3.0, abs=1e-6)


def test_an_infeasible_problem_is_reported_with_its_violation() -> None:
    problem = MixedProblem((Continuous(0.0, 1.0),), lambda x: (x[:, 0], 2.0 - x))
    result = solve(problem, 10, 50, seed=2)
    assert result.violation == pytest.approx(1.0, abs=1e-6)
    assert np.isinf(result.values).all()


def test_a_circle_is_crossed_the_short_way() -> None:
    values = tuple(np.deg2rad(np.arange(0.0, 360.0, 5.0)))

    def away(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.abs(np.exp(1j * x) - 1.0).sum(axis=1), np.zeros((len(x), 1))

    result = solve(MixedProblem((Circular(values),) * 6, away), 20, 200, seed=0, runs=5)
    assert (result.values < 1e-9).all()


def test_a_collapsed_population_is_drawn_anew_except_the_best() -> None:
    search = Jaya(sphere(1.0), 8, np.random.default_rng(0))
    next(search)
    search.x[:] = 1.5
    search.value[:], search.violation[:] = 1.0, 0.0
    next(search)
    assert len(np.unique(search.x[0, 1:], axis=0)) == 7
    assert search.value[0].min() <= 1.0


def test_same_seed_same_path_and_the_best_never_gets_worse() -> None:
    paths = [[g.value for g in islice(Jaya(sphere(3.0), 10, np.random.default_rng(7)), 60)] for _ in range(2)]
    assert paths[0] == paths[1]
    assert paths[0] == sorted(paths[0], reverse=True)


def test_start_members_are_used() -> None:
    search = Jaya(sphere(3.0), 10, np.random.default_rng(7), start=np.full((1, 4), 3.0))
    assert next(search).value == 0.0


def test_stop_is_honoured_and_said() -> None:
    result = solve(sphere(3.0), 10, 1000, seed=1, stop=lambda: True)
    assert result.status == "stopped"
    assert result.generations == 1


def test_nan_from_the_problem_never_wins() -> None:
    problem = MixedProblem((Continuous(-1.0, 1.0),), lambda x: (np.sqrt(x[:, 0]), np.zeros((len(x), 1))))
    with np.errstate(invalid="ignore"):
        result = solve(problem, 20, 100, seed=3)
    assert result.value == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("members", "generations"), [(1, 10), (10, 0)])
def test_a_budget_that_cannot_work_is_refused(members: int, generations: int) -> None:
    with pytest.raises(NumericsError, match="at least"):
        solve(sphere(1.0), members, generations, seed=1)
