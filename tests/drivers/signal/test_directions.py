"""Horizontal, vertical and axial: the signs of unbalance."""

from __future__ import annotations

import pytest

from drivers.errors import InvalidSetting
from drivers.signal.block import Channel
from drivers.signal.chain import Measured
from drivers.signal.directions import compare
from tests.support.drivers.analytic import Tone, measured


def feel(rms: float, lag_deg: float, **more: object) -> Measured:
    return measured(Tone(rms=rms, lag_deg=lag_deg, **more).block())  # type: ignore[arg-type]


class TestCompare:
    def test_plain_unbalance_raises_no_doubt(self) -> None:
        found = compare(feel(3.0, 100.0), feel(2.0, 10.0), feel(1.0, 45.0))
        assert found.h_to_v == pytest.approx(1.5)
        assert found.h_minus_v_deg == pytest.approx(90.0)
        assert found.axial_to_radial == pytest.approx(1.0 / 3.0)
        assert found.doubts == ()

    def test_the_difference_of_phases_is_turned_into_plus_minus_180(self) -> None:
        assert compare(feel(3.0, 350.0), feel(2.0, 80.0)).h_minus_v_deg == pytest.approx(-90.0)
        assert compare(feel(3.0, 80.0), feel(2.0, 350.0)).h_minus_v_deg == pytest.approx(90.0)

    def test_each_sign_by_itself(self) -> None:
        upright = feel(2.0, 10.0)
        assert compare(feel(7.0, 100.0), upright).doubts == ("h_to_v_beyond_3",)
        assert compare(feel(0.5, 100.0), upright).doubts == ("h_to_v_beyond_3",)
        assert compare(feel(2.0, 15.0), upright).doubts == ("h_to_v_not_90_deg",)
        assert compare(feel(2.0, 100.0), upright, feel(2.5, 0.0)).doubts == ("axial_above_radial",)
        bent = feel(2.0, 100.0, harmonics=((2, 1.0, 0.0),))
        assert compare(bent, upright).doubts == ("one_x_not_dominant",)

    def test_the_detection_does_not_matter_as_long_as_it_is_the_same(self) -> None:
        peak = Channel("P", detection="peak")
        found = [measured(Tone(lag_deg=lag).block(channel=peak)) for lag in (100.0, 10.0)]
        assert compare(*found).doubts == ()
        with pytest.raises(InvalidSetting, match="be the same"):
            compare(found[0], feel(2.0, 10.0))
