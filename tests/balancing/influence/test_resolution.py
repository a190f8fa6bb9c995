"""The step of rounded values, and the least scatter that follows from it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.influence.resolution import known_scatter, quantisation_step, scatter_floor

NOISE = np.random.default_rng(1).normal(3.0, 0.1, 50)


@pytest.mark.parametrize("step", [1.0, 0.5, 0.1, 0.05, 0.01, 0.001, 2.0**-7, 25.4 / 1000.0 / 3.0])
def test_the_step_of_rounded_noise_is_found(step: float) -> None:
    values = np.round(NOISE * 20.0) * step
    assert quantisation_step(values) == pytest.approx(step, rel=1e-6)


@pytest.mark.parametrize("values", [[], [3.0] * 9, [0.0] * 9, list(NOISE), list(NOISE[:2]), [math.nan, 1.0]])
def test_values_that_show_no_step_have_none(values: list[float]) -> None:
    assert quantisation_step(np.array(values)) is None


@given(
    size=st.floats(1e-6, 1e6),
    moves=st.lists(st.integers(-3, 3), min_size=5, max_size=60),
    decimals=st.integers(0, 3),
)
def test_a_decimal_step_is_never_taken_for_a_finer_one(size: float, moves: list[int], decimals: int) -> None:
    values = np.array([round(size, decimals) + round(move * 10.0**-decimals, decimals) for move in moves])
    step = quantisation_step(np.round(values, decimals))
    assert step is None or step >= 10.0**-decimals * (1 - 1e-9) or size * 10.0**decimals > 1e8


def test_the_floor_is_that_of_the_coarser_direction() -> None:
    assert scatter_floor(3.0, 0.1, None) == pytest.approx(0.1 / math.sqrt(12.0))
    assert scatter_floor(3.0, 0.1, 2.0) == pytest.approx(3.0 * math.radians(2.0) / math.sqrt(12.0))
    assert scatter_floor(3.0, None, None) == 0.0


@pytest.mark.parametrize(
    ("scatter", "floor", "known"),
    [(None, 0.5, None), (0.0, 0.0, None), (1.3e-17, 0.0, None), (2e-13, 0.0, None), (0.1, 0.0, 0.1), (0.0, 0.5, 0.5)],
)
def test_rounding_error_is_no_scatter(scatter: float | None, floor: float, known: float | None) -> None:
    assert known_scatter(scatter, 3.0, floor) == known
