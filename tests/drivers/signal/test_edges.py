"""Edges between the samples of a tachometer signal."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.errors import InvalidSetting, SignalRefused
from drivers.signal.block import Floats
from drivers.signal.edges import find_edges

RATE = 1000.0


def pulses(times: Floats, width_s: float, seconds: float, rate: float = RATE, high: float = 5.0) -> Floats:
    """Ideal pulses, high for `width_s` from each time on."""
    t = np.arange(int(seconds * rate)) / rate
    since = t[:, None] - times[None, :]
    return np.where(((since >= 0.0) & (since < width_s)).any(axis=1), high, 0.0)


class TestFindEdges:
    @given(st.floats(3.0, 20.0), st.floats(0.0, 0.04), st.floats(0.1, 0.6))
    @settings(max_examples=30, deadline=None)
    def test_steps_are_found_within_half_a_sample(self, hz: float, first: float, duty: float) -> None:
        times = first + np.arange(1, int(3.0 * hz)) / hz
        times = times[times < 2.9]
        found = find_edges(pulses(times, duty / hz, 3.0), RATE)
        assert len(found) == len(times)
        assert np.abs(found - times).max() <= 0.5 / RATE + 1e-9

    def test_slanting_flanks_are_found_between_the_samples(self) -> None:
        t = np.arange(4000) / RATE
        found = find_edges(np.sin(math.tau * 7.3 * t - 0.9), RATE, threshold=0.0)
        expected = (0.9 / math.tau + np.arange(len(found))) / 7.3
        assert np.abs(found - expected).max() <= 1e-5

    def test_falling_flanks_of_a_mark_that_is_dark(self) -> None:
        times = np.arange(1, 20) / 7.7
        dark = 5.0 - pulses(times, 0.01, 2.6)
        assert np.abs(find_edges(dark, RATE, slope="falling") - times).max() <= 0.5 / RATE + 1e-9
        assert np.abs(find_edges(dark, RATE, slope="rising") - times).min() >= 0.009

    def test_pulses_shorter_than_a_thousandth_of_the_turn_are_seen(self) -> None:
        times = np.arange(1, 7) / 0.5
        found = find_edges(pulses(times, 0.0015, 14.0), RATE)
        assert np.abs(found - times).max() <= 0.5 / RATE + 1e-9

    def test_noise_near_the_threshold_makes_no_edges(self) -> None:
        times = np.arange(1, 20) / 7.7
        noisy = pulses(times, 0.05, 2.6) + 0.3 * np.random.default_rng(1).standard_normal(2600)
        slow = np.convolve(noisy, np.ones(15) / 15.0, mode="same") + 0.2 * np.random.default_rng(2).standard_normal(
            2600
        )
        assert len(find_edges(slow, RATE)) == len(times)

    def test_lost_samples_are_passed_over(self) -> None:
        times = np.arange(1, 20) / 7.7
        signal = pulses(times, 0.03, 2.6)
        signal[200:210] = np.nan
        signal[round(times[4] * RATE) + 1] = np.nan
        assert len(find_edges(signal, RATE)) == len(times)

    def test_a_signal_that_starts_high_has_no_edge_there(self) -> None:
        assert len(find_edges(np.array([5.0, 5.0, 0.0, 0.0, 5.0, 5.0]), RATE)) == 1

    @pytest.mark.parametrize("still", [np.zeros(10), np.full(10, np.nan), np.array([1.0])])
    def test_a_signal_that_never_moves_is_refused(self, still: Floats) -> None:
        with pytest.raises(SignalRefused, match="check the key-phasor") as refusal:
            find_edges(still, RATE)
        assert refusal.value.code == "tacho"

    @pytest.mark.parametrize(
        "wrong", [{"sample_rate_hz": 0.0}, {"sample_rate_hz": math.inf}, {"slope": "up"}, {"hysteresis": -1.0}]
    )
    def test_settings(self, wrong: dict[str, object]) -> None:
        with pytest.raises(InvalidSetting):
            find_edges(np.array([0.0, 1.0, 0.0]), **({"sample_rate_hz": RATE} | wrong))  # type: ignore[arg-type]

    @given(st.lists(st.floats(), max_size=60))
    @settings(max_examples=100, deadline=None)
    def test_any_signal_gives_increasing_edges_or_a_refusal(self, values: list[float]) -> None:
        try:
            found = find_edges(np.array(values, float), RATE)
        except (SignalRefused, InvalidSetting):
            return
        assert (np.diff(found) > 0.0).all()
        assert ((found >= 0.0) & (found <= len(values) / RATE)).all()
