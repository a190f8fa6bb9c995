"""A tone beside the one that is measured: named, kept out where the block is long enough, and called beating else."""

from __future__ import annotations

import pytest

from tests.support.drivers.analytic import DRIFTS, Tone, apart, measured


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


@pytest.mark.parametrize("order", [0.96, 1.03, 1.05])
def test_one_too_close_to_keep_out_is_called_beating_and_scatters(order: float) -> None:
    found = measured(Tone(turns=60.0, neighbour=(order, 1.5)).block())
    assert found.flags == ("beating",)
    assert found.scatter is not None
    assert found.scatter >= 0.1


def test_a_longer_block_tells_them_apart() -> None:
    found = measured(Tone(turns=200.0, neighbour=(1.03, 1.5)).block())
    assert found.flags == ("neighbour_tone",)
    assert found.amplitude == pytest.approx(3.0, rel=1e-3)


def test_quiet_ones_are_no_flag() -> None:
    assert measured(Tone(turns=60.0, neighbour=(1.2, 0.1), snr_db=40.0).block()).flags == ()
