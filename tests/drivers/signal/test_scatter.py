"""The stated scatter is what the vector really does from block to block."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.signal.scatter import widened
from tests.support.drivers.analytic import Tone, measured, vector


def test_it_is_the_standard_deviation_of_the_reported_vector() -> None:
    """Over many blocks of the same drum, the stated scatter is what the vectors really do."""
    tone = Tone(turns=64.5, drift=0.02, snr_db=20.0)
    found = [measured(tone.block(seed)) for seed in range(60)]
    vectors = np.array([vector(one) for one in found])
    really = math.sqrt(float(np.mean(np.abs(vectors - vectors.mean()) ** 2)) / 2.0)
    stated = math.sqrt(float(np.mean([one.scatter**2 for one in found if one.scatter is not None])))
    assert stated == pytest.approx(really, rel=0.2)  # 60 blocks know it to 9 %, each from 16 sub-blocks


def test_it_does_not_count_a_response_that_follows_the_stated_speed() -> None:
    found = measured(Tone(turns=64.5, drift=0.03, growth=3.0).block())
    assert found.scatter is not None
    assert found.scatter <= 1e-3 * found.amplitude


@pytest.mark.parametrize("turns", [4.5, 5.5, 7.5])
def test_the_shortest_blocks_state_one_too(turns: float) -> None:
    assert measured(Tone(turns=turns, snr_db=30.0).block()).scatter is not None


@pytest.mark.parametrize("freedom", [2.0, 4.0, 12.0, 1e6])
def test_it_is_widened_so_that_the_region_of_a_known_one_holds(freedom: float) -> None:
    rng = np.random.default_rng(20260504)
    ratios = rng.chisquare(2.0, 40_000) / 2.0 / (rng.chisquare(freedom, 40_000) / freedom)
    assert float(np.mean(ratios <= widened(freedom) ** 2 * -math.log(0.05))) == pytest.approx(0.95, abs=0.004)
