"""The stated scatter is what the vector really does from block to block."""

from __future__ import annotations

import math

import numpy as np
import pytest

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


def test_too_few_turns_leave_none() -> None:
    assert measured(Tone(turns=7.5).block()).scatter is None
