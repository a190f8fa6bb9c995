"""A tone beside the one that is measured: named, kept out where the block is long enough, and called beating else."""

from __future__ import annotations

import cmath
import math

import pytest

from tests.support.drivers.analytic import DRIFTS, Tone, apart, measured, vector


@pytest.mark.parametrize("order", [0.7, 0.85, 1.12, 1.3, 1.45])
@pytest.mark.parametrize("drift", DRIFTS)
def test_a_tone_of_half_the_size_beside_it_leaks_nothing(order: float, drift: float) -> None:
    tone = Tone(turns=60.0, drift=drift, neighbour=(order, 1.5))
    found = measured(tone.block())
    assert found.amplitude == pytest.approx(tone.rms, rel=0.001)
    assert apart(found.phase_deg, tone.lag_deg) <= 0.05
    assert found.flags == ("neighbour_tone",)
    assert found.neighbour is not None
    assert found.neighbour.order == pytest.approx(order, abs=0.002)
    assert found.neighbour.amplitude == pytest.approx(1.5, rel=0.02)
    assert found.scatter is not None
    assert found.scatter <= 0.02


@pytest.mark.parametrize("order", [0.93, 0.96, 1.03, 1.05, 1.1])
@pytest.mark.parametrize("turns", [20.3, 60.0])
def test_one_too_close_for_the_taper_is_fitted_jointly_and_costs_less_than_a_hundredth(
    order: float, turns: float
) -> None:
    errors = []
    for seed in range(6):
        tone = Tone(turns=turns, neighbour=(order, 0.9), snr_db=34.0)
        found = measured(tone.block(seed))
        assert "neighbour_tone" in found.flags
        assert found.neighbour is not None
        assert found.neighbour.order == pytest.approx(order, abs=0.005)
        errors.append(abs(vector(found) - tone.rms * cmath.exp(1j * math.radians(tone.lag_deg))))
        assert found.scatter is not None
        assert errors[-1] <= 5.0 * math.sqrt(2.0) * found.scatter
    assert max(errors) <= 0.01 * tone.rms


@pytest.mark.parametrize("growth", [0.0, 3.0])
@pytest.mark.parametrize("drift", DRIFTS)
def test_a_speed_that_drifts_is_no_close_tone(drift: float, growth: float) -> None:
    for turns in (12.0, 40.0):
        assert measured(Tone(turns=turns, drift=drift, growth=growth, snr_db=40.0).block()).flags == ()


def test_a_longer_block_tells_them_apart() -> None:
    found = measured(Tone(turns=200.0, neighbour=(1.03, 1.5)).block())
    assert found.flags == ("neighbour_tone",)
    assert found.amplitude == pytest.approx(3.0, rel=1e-3)


def test_quiet_ones_are_no_flag() -> None:
    assert measured(Tone(turns=60.0, neighbour=(1.2, 0.1), snr_db=40.0).block()).flags == ()
