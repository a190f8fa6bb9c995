"""Counting turns over a key-phasor that misses, bounces and jitters."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.errors import InvalidSetting, SignalRefused
from drivers.signal.block import Floats
from drivers.signal.revolutions import turns_of
from tests.support.drivers.analytic import Tone, apart, measured

STEADY = 0.3 + np.arange(41) / 7.7


def code_of(edges: Floats) -> str:
    with pytest.raises(SignalRefused) as refusal:
        turns_of(edges)
    return refusal.value.code


class TestCounting:
    def test_clean_edges_are_counted(self) -> None:
        turns = turns_of(STEADY)
        assert (turns.count, turns.missed, turns.extra) == (40, 0, 0)

    @given(st.sets(st.integers(1, 39), min_size=1, max_size=3))
    @settings(max_examples=40, deadline=None)
    def test_missed_edges_are_counted_over(self, lost: set[int]) -> None:
        turns = turns_of(np.delete(STEADY, sorted(lost)))
        assert (turns.count, turns.missed, turns.extra) == (40, len(lost), 0)

    @given(st.sets(st.integers(0, 39), min_size=1, max_size=3), st.floats(0.02, 0.86))
    @settings(max_examples=40, deadline=None)
    def test_extra_edges_are_left_out(self, turn: set[int], after: float) -> None:
        """Bounces just after the mark, sparks anywhere within the turn."""
        more = STEADY[sorted(turn)] + after / 7.7
        turns = turns_of(np.sort(np.concatenate([STEADY, more])))
        assert (turns.count, turns.missed, turns.extra) == (40, 0, len(turn))
        assert np.array_equal(turns.times, STEADY)

    def test_an_edge_before_the_first_true_one_is_left_out(self) -> None:
        turns = turns_of(np.concatenate([[STEADY[0] - 0.3 / 7.7], STEADY]))
        assert (turns.count, turns.extra) == (40, 1)

    def test_an_edge_out_of_place_is_left_out(self) -> None:
        moved = STEADY.copy()
        moved[17] += 0.06 / 7.7
        turns = turns_of(moved)
        assert (turns.count, turns.missed, turns.extra) == (40, 1, 1)
        assert moved[17] not in turns.times

    def test_jitter_is_no_fault(self) -> None:
        jitter = 0.004 / 7.7 * np.random.default_rng(3).standard_normal(41)
        assert turns_of(STEADY + jitter).extra == 0

    def test_a_fast_run_up_is_followed(self) -> None:
        tone = Tone(turns=40.0, drift=0.5)
        turns = turns_of(np.delete(tone.edges(), [5, 20]))
        assert (turns.missed, turns.extra) == (2, 0)


class TestRefusals:
    def test_too_few(self) -> None:
        assert code_of(STEADY[:4]) == "too_short"
        assert code_of(np.array([])) == "too_short"

    def test_more_than_a_tenth_missed(self) -> None:
        assert code_of(np.delete(STEADY, np.arange(3, 40, 6))) == "tacho"

    def test_a_long_gap(self) -> None:
        assert turns_of(np.delete(STEADY, [9, 10, 11])).missed == 3
        assert code_of(np.delete(STEADY, [9, 10, 11, 12])) == "tacho"

    def test_two_marks_unevenly_spaced(self) -> None:
        assert code_of(np.sort(np.concatenate([STEADY, STEADY + 0.4 / 7.7]))) == "tacho"

    def test_noise_instead_of_edges(self) -> None:
        assert code_of(np.cumsum(np.random.default_rng(1).exponential(0.1, 60))) == "tacho"

    @pytest.mark.parametrize("times", [[0.0, 1.0, 1.0, 2.0], [0.0, 2.0, 1.0], [0.0, math.nan, 1.0]])
    def test_times_that_do_not_increase(self, times: list[float]) -> None:
        with pytest.raises(InvalidSetting, match="edge time"):
            turns_of(np.array(times))

    @given(st.lists(st.floats(0.0, 10.0), max_size=40))
    @settings(max_examples=100, deadline=None)
    def test_any_times_are_counted_or_refused(self, times: list[float]) -> None:
        try:
            turns = turns_of(np.array(times))
        except (SignalRefused, InvalidSetting):
            return
        assert (np.diff(turns.numbers) >= 1.0).all()


class TestAngle:
    @given(st.floats(-0.2, 0.2), st.sets(st.integers(1, 18), max_size=2))
    @settings(max_examples=40, deadline=None)
    def test_an_even_acceleration_is_followed_exactly_even_over_missed_edges(
        self, drift: float, lost: set[int]
    ) -> None:
        tone = Tone(turns=20.5, drift=drift)
        edges = tone.edges()
        turns = turns_of(np.delete(edges, sorted(lost)))
        times = np.linspace(edges[0], edges[-1], 500)
        angle, speed = turns.angle_and_speed(times)
        assert np.abs(angle - (tone.angle(times) - tone.angle(edges[:1]))).max() <= 1e-7
        assert np.abs(speed / tone.speed(times) - 1.0).max() <= 1e-7


class TestThroughTheChain:
    """What a poor key-phasor costs: nothing, or little, or a refusal; never a wrong answer without a word."""

    def test_missed_and_extra_edges_are_repaired_and_flagged(self) -> None:
        tone = Tone(turns=40.0, drift=0.03)
        block = tone.block()
        edges = np.sort(np.append(np.delete(block.edges_s, [7, 30]), block.edges_s[15] + 0.01))
        found = measured(type(block)(block.channels, block.samples, block.sample_rate_hz, edges))
        assert found.flags == ("edges_repaired",)
        assert found.amplitude == pytest.approx(tone.rms, rel=1e-6)
        assert apart(found.phase_deg, tone.lag_deg) <= 1e-4

    def test_jitter_of_half_a_degree_costs_less_than_half_a_degree(self) -> None:
        tone = Tone(turns=40.0, drift=0.03, snr_db=40.0)
        for seed in range(12):
            block = tone.block(seed)
            jitter = 0.5 / 360.0 / tone.hz * np.random.default_rng(seed).standard_normal(len(block.edges_s))
            found = measured(type(block)(block.channels, block.samples, block.sample_rate_hz, block.edges_s + jitter))
            assert found.amplitude == pytest.approx(tone.rms, rel=0.005)
            assert apart(found.phase_deg, tone.lag_deg) <= 0.5
