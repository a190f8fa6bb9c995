"""The level ellipsoid: holds everything that is better than the level, and shrinks with it."""

from __future__ import annotations

import numpy as np
import pytest

from service.balancing.rotor.phasors import FloatArray
from service.balancing.selection.brute_force import _choices
from service.balancing.selection.exact.bounds import bounds_of, real_of
from service.balancing.selection.exact.level_ellipsoid import Ellipsoid, ellipsoid
from service.balancing.selection.exact.presolve import opened
from service.balancing.selection.objectives import evaluate
from tests.support.numerics.problems import FIELD_TARGET, field_experiment
from tests.support.numerics.random_problems import KINDS, random_problem


def distance(region: Ellipsoid, x: FloatArray) -> float:
    return float((x - region.centre) @ region.form @ (x - region.centre))


def volume(region: Ellipsoid) -> float:
    return float(np.linalg.det(region.form) ** -0.5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(5))
def test_holds_every_better_selection(kind: str, seed: int) -> None:
    problem = opened(random_problem(kind, seed)).problem  # as the search does: planes that take nothing are left out
    bounds = bounds_of(problem)
    rng = np.random.default_rng(seed)
    choices = [_choices(problem, p) for p in range(len(problem.planes))]
    rows = [rng.integers(len(of.vectors), size=1000) for of in choices]
    in_the_box = sum(of.usage[row] for of, row in zip(choices, rows, strict=True)) <= problem.stock.counts
    tried = np.stack([of.vectors[row] for of, row in zip(choices, rows, strict=True)], axis=1)[in_the_box.all(axis=1)]
    values = evaluate(problem.objective, tried)
    for share in (0.05, 0.3, 0.7, 1.1):
        z = bounds.floor + share * (float(values.max()) - bounds.floor)
        region = ellipsoid(bounds, z)
        better = tried[values <= z]
        if region is None:
            assert not len(better)
            continue
        assert all(distance(region, real_of(u)) <= 1.0 + 1e-6 for u in better)


def test_there_is_none_below_the_bound() -> None:
    bounds = bounds_of(random_problem("sum", 3))
    assert ellipsoid(bounds, 0.0) is None
    assert ellipsoid(bounds, 0.5 * bounds.floor) is None


def test_shrinks_with_the_level_about_the_continuous_optimum() -> None:
    bounds = bounds_of(field_experiment(3))
    low, high = (ellipsoid(bounds, z * bounds.unit) for z in (1e-3, 1e-2))
    assert low is not None
    assert high is not None
    np.testing.assert_allclose(low.centre, real_of(FIELD_TARGET), rtol=1e-9)
    # Four coordinates, each ten times nearer.
    assert volume(high) / volume(low) == pytest.approx(1e4, rel=1e-6)


def test_a_level_that_everything_keeps_is_what_the_planes_reach() -> None:
    bounds = bounds_of(field_experiment(3))
    region = ellipsoid(bounds, 2.0 * bounds.unit)
    assert region is not None
    np.testing.assert_allclose(region.centre, real_of(bounds.reach.centre))
    np.testing.assert_allclose(np.diag(region.form), np.repeat(1.0 / (2.0 * bounds.reach.radius**2), 2))
