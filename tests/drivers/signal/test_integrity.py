"""Clipped tops and dropouts: found where they are, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.signal.block import Channel
from drivers.signal.chain import Settings
from drivers.signal.integrity import bridged, integrity_of
from tests.support.drivers.analytic import Tone, apart, measured, refused, with_samples

NOISY = Tone(turns=40.0, snr_db=40.0, drift=0.02)


class TestClipping:
    @pytest.mark.parametrize("share", [0.5, 0.8, 0.95])
    def test_flat_tops_are_refused(self, share: float) -> None:
        block = NOISY.block()
        limit = share * np.abs(block.samples).max()
        refusal = refused(with_samples(block, np.clip(block.samples[0], -limit, limit)))
        assert refusal.code == "clipped"
        assert "greater range" in refusal.reason

    def test_one_side_is_enough(self) -> None:
        block = NOISY.block()
        limit = 0.8 * block.samples.max()
        assert refused(with_samples(block, np.minimum(block.samples[0], limit))).code == "clipped"

    def test_measured_all_the_same_it_carries_the_flag_and_reads_low(self) -> None:
        block = NOISY.block()
        limit = 0.6 * np.abs(block.samples).max()
        found = measured(with_samples(block, np.clip(block.samples[0], -limit, limit)), Settings(accept_clipped=True))
        assert found.flags == ("clipped",)
        assert found.amplitude < 0.9 * NOISY.rms

    def test_the_full_scale_tells_where_the_samples_cannot(self) -> None:
        """A slow clean sine in coarse steps is level at its top as if it were clipped: only the range can tell."""
        block = Tone(rate=51_200.0).block()
        steps = np.round(block.samples[0] / np.abs(block.samples).max() * 100.0) / 100.0
        assert integrity_of(steps).clipped == 0
        assert integrity_of(steps, full_scale=2.0).clipped == 0
        assert integrity_of(steps, full_scale=1.0).clipped > 0
        channel = Channel("P", full_scale=1.0)
        assert refused(replace(with_samples(block, steps), channels=(channel,))).code == "clipped"

    @given(st.integers(8, 24), st.floats(0.01, 1.0), st.sampled_from([None, 60.0, 40.0, 20.0]))
    @settings(max_examples=40, deadline=None)
    def test_a_converter_of_any_fineness_is_not_taken_for_clipping(
        self, bits: int, share: float, snr_db: float | None
    ) -> None:
        block = Tone(turns=10.0, snr_db=snr_db).block()
        top = 2.0 ** (bits - 1)
        codes = np.round(block.samples[0] / np.abs(block.samples).max() * share * (top - 1.0))
        state = integrity_of(codes, full_scale=top)
        assert state.clipped == (int((np.abs(codes) >= 0.999 * top).sum()))
        if np.abs(codes).max() >= 8.0:  # fewer steps than these are no signal
            assert not state.lost.any()


class TestDropouts:
    @pytest.mark.parametrize("value", [0.0, np.nan, 0.0123])
    def test_short_ones_are_left_out_and_flagged(self, value: float) -> None:
        block = NOISY.block()
        samples = block.samples[0].copy()
        samples[3000:3200] = value
        samples[9000:9050] = value
        found = measured(with_samples(block, samples))
        assert found.flags == ("dropout",)
        assert found.amplitude == pytest.approx(NOISY.rms, rel=0.005)
        assert apart(found.phase_deg, NOISY.lag_deg) <= 0.5

    def test_exactly_the_lost_samples_are_named(self) -> None:
        samples = NOISY.acceleration(np.random.default_rng(0))
        samples[100:120] = 0.0
        samples[500] = np.nan
        lost = np.flatnonzero(integrity_of(samples).lost)
        assert lost.tolist() == [*range(100, 120), 500]

    def test_many_are_refused(self) -> None:
        block = NOISY.block()
        samples = block.samples[0].copy()
        samples[: len(samples) // 5] = 0.0
        assert refused(with_samples(block, samples)).code == "dropout"

    @pytest.mark.parametrize("value", [0.0, np.nan, 9.9])
    def test_a_dead_sensor_is_refused(self, value: float) -> None:
        block = NOISY.block()
        refusal = refused(with_samples(block, np.full(block.samples.shape[1], value)))
        assert refusal.code == "dropout"
        assert "cable" in refusal.reason

    def test_a_bridge_is_straight(self) -> None:
        samples = np.array([np.nan, 1.0, 0.0, 0.0, 4.0, np.nan])
        lost = np.array([True, False, True, True, False, True])
        assert bridged(samples, lost).tolist() == [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]
