"""The interval of an amplitude covers the truth as often as it says."""

from __future__ import annotations

import numpy as np
import pytest

from service.balancing.influence.fit import KNOWN_SCATTER, amplitude_interval
from tests.support.numerics.runs import normal

N = 10_000
"""Draws: 95 % of them come out to 0.22 %, the bounds leave 1 %."""


@pytest.mark.parametrize("true", [0.0, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0])
def test_covers_95_percent_with_known_scatter(true: float) -> None:
    v = true + normal(np.random.default_rng(1), N)
    low, high = amplitude_interval(v, np.ones(N), np.full(N, KNOWN_SCATTER))
    assert 0.94 < ((low <= true) & (true <= high)).mean() < (0.985 if true < 3.0 else 0.96)


@pytest.mark.parametrize("dof", [2, 4, 10])
@pytest.mark.parametrize("true", [0.0, 1.0, 3.0, 50.0])
def test_covers_95_percent_with_estimated_scatter(true: float, dof: int) -> None:
    rng = np.random.default_rng(2)
    v, s = true + normal(rng, N), np.sqrt(rng.chisquare(dof, N) / dof)
    low, high = amplitude_interval(v, s, np.full(N, dof))
    assert 0.935 < ((low <= true) & (true <= high)).mean() < 0.985


def test_a_vanishing_prediction_is_bounded_by_its_error() -> None:
    low, high = amplitude_interval(np.zeros(1, complex), np.ones(1), np.array([KNOWN_SCATTER]))
    assert low[0] == pytest.approx(0.0, abs=1e-9)
    assert high[0] == pytest.approx(2.4477, abs=1e-4)


def test_unknown_scatter_gives_no_interval_and_the_formulas_meet() -> None:
    dof = np.full(3, KNOWN_SCATTER)
    low, high = amplitude_interval(np.array([5.0, 29.999, 30.001]) + 0j, np.array([np.nan, 1.0, 1.0]), dof)
    assert np.isnan(low[0])
    assert np.isnan(high[0])
    assert low[2] - low[1] == pytest.approx(0.002, abs=1e-3)
    assert high[2] - high[1] == pytest.approx(0.002, abs=1e-3)
    low, high = amplitude_interval(np.array([5.0 + 0j]), np.array([1.0]), np.array([0]))
    assert np.isnan([low, high]).all()
