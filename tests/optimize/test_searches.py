"""The published searches against measured rates and values; the contract that all of them keep."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from service.errors import NumericsError
from service.optimize.differential_evolution import VARIANTS, DifferentialEvolution, Variant
from service.optimize.differential_search import DifferentialSearch, Directions
from service.optimize.evolving_front import FrontSearchProblem
from service.optimize.front import hypervolume
from service.optimize.nsga2 import Nsga2
from service.optimize.nsjaya import Nsjaya
from service.optimize.problem import Continuous, FloatArray, Integer, MixedProblem
from service.optimize.search import Search, run


def camel(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    a, b = x.T
    return (4.0 - 2.1 * a**2 + a**4 / 3.0) * a**2 + a * b + (-4.0 + 4.0 * b**2) * b**2, np.zeros((len(x), 1))


CAMEL = MixedProblem((Continuous(-5.0, 5.0),) * 2, camel)
LEAST = -1.0316284535
HALF_FAILS = MixedProblem(
    (Continuous(-5.0, 5.0), Integer(-5, 5)),
    lambda x: (np.where(x[:, 0] < 0.0, np.nan, x[:, 0] + x[:, 1]), 1.0 - x.sum(axis=1, keepdims=True)),
)
SEARCHES: dict[str, Callable[[MixedProblem, int, np.random.Generator], Search]] = {
    **{variant: partial(DifferentialEvolution, variant=variant) for variant in VARIANTS},
    "differential_search": DifferentialSearch,
}


@pytest.mark.parametrize("directions", ["bijective", "surjective", "elitist_1", "elitist_2"])
def test_differential_search_finds_the_six_hump_camel(directions: Directions) -> None:
    successes = 0
    for seed in range(12):
        found = run(DifferentialSearch(CAMEL, 100, np.random.default_rng(seed), directions), 100, seed)
        successes += found.value < LEAST + 1e-5
    assert successes >= 11


@pytest.mark.parametrize("variant", VARIANTS)
def test_differential_evolution_finds_the_six_hump_camel(variant: Variant) -> None:
    for seed in range(5):
        found = run(DifferentialEvolution(CAMEL, 30, np.random.default_rng(seed), variant), 120, seed)
        assert found.value == pytest.approx(LEAST, abs=1e-6)
        assert found.evaluations == 30 * 120
        np.testing.assert_allclose(np.abs(found.x), [0.0898, 0.7126], atol=1e-3)


@pytest.mark.parametrize("name", SEARCHES)
def test_the_same_seed_gives_the_same_answer(name: str) -> None:
    first, again, other = (run(SEARCHES[name](CAMEL, 20, np.random.default_rng(seed)), 20, seed) for seed in (3, 3, 4))
    assert first.value == again.value
    np.testing.assert_array_equal(first.x, again.x)
    assert not np.array_equal(first.x, other.x)
    assert (np.diff(first.history[:, 1]) <= 0.0).all()


@pytest.mark.parametrize("name", SEARCHES)
def test_what_is_no_number_is_infeasible(name: str) -> None:
    found = run(SEARCHES[name](HALF_FAILS, 20, np.random.default_rng(1)), 80, 1)
    assert found.feasible
    assert found.x[0] >= 0.0
    assert float(found.x[1]).is_integer()
    assert found.value == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("name", SEARCHES)
def test_an_infeasible_problem_is_told_with_its_violation(name: str) -> None:
    never = MixedProblem((Continuous(0.0, 1.0),), lambda x: (x[:, 0], 3.0 - x))
    found = run(SEARCHES[name](never, 10, np.random.default_rng(1)), 60, 1)
    assert found.status == "infeasible"
    assert found.violation == pytest.approx(2.0, abs=1e-3)


@pytest.mark.parametrize("name", SEARCHES)
def test_a_fixed_variable_is_accepted(name: str) -> None:
    fixed = MixedProblem(
        (Continuous(1.0, 1.0), Continuous(-2.0, 2.0)), lambda x: ((x**2).sum(axis=1), np.zeros((len(x), 1)))
    )
    found = run(SEARCHES[name](fixed, 12, np.random.default_rng(1)), 80, 1)
    assert found.value == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("name", SEARCHES)
def test_a_population_below_four_is_refused(name: str) -> None:
    with pytest.raises(NumericsError, match="at least 4 members, got 3") as refused:
        next(SEARCHES[name](CAMEL, 3, np.random.default_rng(1)))
    assert refused.value.code == "population_too_small"


def test_a_search_ends_at_its_deadline_its_stop_and_its_budget() -> None:
    ticks = iter(range(1000))
    ended = run(
        DifferentialSearch(CAMEL, 8, np.random.default_rng(1)), 500, 1, clock=lambda: next(ticks), deadline_s=5.0
    )
    assert (ended.status, ended.steps) == ("limit_reached", 5)
    stopped = run(DifferentialSearch(CAMEL, 8, np.random.default_rng(1)), 500, 1, stop=lambda: True)
    assert (stopped.status, stopped.steps) == ("stopped", 1)
    with pytest.raises(NumericsError, match="at least 1 step, got 0"):
        run(DifferentialSearch(CAMEL, 8, np.random.default_rng(1)), 0, 1)


def zdt1(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    g = 1.0 + 9.0 * x[:, 1:].mean(axis=1)
    return np.stack([x[:, 0], g * (1.0 - np.sqrt(x[:, 0] / g))], axis=1), np.zeros((len(x), 1))


ZDT1 = FrontSearchProblem(np.zeros(30), np.ones(30), zdt1)


@pytest.mark.parametrize(
    ("search", "generations", "least"),
    [
        (Nsga2(ZDT1, 60, np.random.default_rng(1)), 160, 0.84),
        (Nsjaya(ZDT1, 100, np.random.default_rng(1)), 200, 0.869),
        (Nsjaya(ZDT1, 100, np.random.default_rng(1), "published"), 100, 0.868),
    ],
    ids=["nsga2", "nsjaya", "nsjaya as published"],
)
def test_searches_for_fronts_reach_the_measured_volume(search: Nsga2 | Nsjaya, generations: int, least: float) -> None:
    """The limit of the converged front is 0.8767; 20,000 evaluations of NSJAYA measured 0.870."""
    for _ in range(generations):
        state = next(search)
    assert least <= hypervolume(state.objectives, (1.1, 1.1)) <= 0.8767


def test_published_nsjaya_is_drawn_to_the_centre_of_the_box() -> None:
    """ZDT4 is easy for it only while the optimum lies there (spec of the optimisers, section 4)."""

    def shifted(centre: float) -> FrontSearchProblem:
        def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            y = x[:, 1:] - centre
            g = 1.0 + 10.0 * y.shape[1] + (y**2 - 10.0 * np.cos(4.0 * np.pi * y)).sum(axis=1)
            return np.stack([x[:, 0], g * (1.0 - np.sqrt(x[:, 0] / g))], axis=1), np.zeros((len(x), 1))

        return FrontSearchProblem(np.array([0.0, *[-5.0] * 9]), np.array([1.0, *[5.0] * 9]), evaluate)

    volumes = []
    for centre in (0.0, 2.0):
        search = Nsjaya(shifted(centre), 60, np.random.default_rng(1), "published")
        for _ in range(60):
            state = next(search)
        volumes.append(hypervolume(state.objectives, (1.1, 1.1)))
    assert volumes[0] > 0.8
    assert volumes[1] == 0.0
