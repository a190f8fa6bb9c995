"""The signal chain against signals whose answer is known, and against what turning, scaling and adding must do."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.errors import InvalidSetting, SignalRefused
from drivers.signal.block import Block, Channel
from drivers.signal.chain import Measured, Refusal, Settings, measure
from tests.support.drivers.analytic import DRIFTS, Tone, apart, measured, refused, vector, with_samples

few = settings(max_examples=15, deadline=None)
SIGNAL_TO_NOISE_DB = 40.0

tones = st.builds(
    Tone,
    rms=st.floats(0.1, 30.0),
    lag_deg=st.floats(0.0, 360.0),
    hz=st.floats(3.0, 60.0),
    turns=st.floats(9.0, 30.0),
    drift=st.floats(-0.03, 0.03),
    mark=st.floats(0.0, 0.99),
)


class TestAgainstFormulas:
    @pytest.mark.parametrize("drift", DRIFTS)
    @pytest.mark.parametrize("turns", [16.5, 40.2, 150.0])
    @pytest.mark.parametrize("lag_deg", [0.0, 70.0, 215.0])
    def test_noise_40_db_down_and_3_percent_drift_stay_within_half_a_percent_and_half_a_degree(
        self, drift: float, turns: float, lag_deg: float
    ) -> None:
        tone = Tone(turns=turns, drift=drift, lag_deg=lag_deg, snr_db=SIGNAL_TO_NOISE_DB)
        for seed in range(3):
            found = measured(tone.block(seed))
            assert found.amplitude == pytest.approx(tone.rms, rel=0.005)
            assert apart(found.phase_deg, lag_deg) <= 0.5

    @pytest.mark.parametrize("drift", DRIFTS)
    def test_the_same_holds_with_harmonics_a_neighbour_and_a_response_that_grows_with_the_cube_of_the_speed(
        self, drift: float
    ) -> None:
        tone = Tone(
            turns=60.0,
            drift=drift,
            growth=3.0,
            harmonics=((2, 1.0, 10.0), (3, 0.5, 100.0), (4, 0.4, 190.0)),
            neighbour=(1.15, 1.5),
            snr_db=SIGNAL_TO_NOISE_DB,
        )
        for seed in range(3):
            found = measured(tone.block(seed))
            expected = tone.rms * (found.speed_rpm / 60.0 / tone.hz) ** 3
            assert found.amplitude == pytest.approx(expected, rel=0.005)
            assert apart(found.phase_deg, tone.lag_deg) <= 0.5
            assert "neighbour_tone" in found.flags

    @given(tones)
    @few
    def test_without_noise_drift_alone_changes_nothing(self, tone: Tone) -> None:
        found = measured(tone.block())
        assert found.amplitude == pytest.approx(tone.rms, rel=1e-6)
        assert apart(found.phase_deg, tone.lag_deg) <= 1e-4
        assert found.speed_rpm == pytest.approx(60.0 * tone.hz, rel=0.016)

    @given(tones.map(lambda tone: replace(tone, growth=3.0, turns=max(16.0, tone.turns))))
    @few
    def test_the_stated_bound_of_drift_holds_where_the_response_grows_with_the_speed(self, tone: Tone) -> None:
        found = measured(tone.block())
        assert found.amplitude == pytest.approx(tone.rms * (found.speed_rpm / 60.0 / tone.hz) ** 3, rel=2e-4)
        assert apart(found.phase_deg, tone.lag_deg) <= 0.06

    def test_an_integration_in_time_agrees(self) -> None:
        """The velocity summed up sample by sample, its mean over whole turns taken out, and looked at in the clear."""
        tone = Tone(turns=20.0, rate=51_200.0, lag_deg=120.0)
        block = tone.block()
        edges = block.edges_s
        inside = slice(round(edges[0] * tone.rate), round(edges[-1] * tone.rate))
        velocity = np.cumsum(block.samples[0])[inside] / tone.rate * 1e3
        velocity = velocity - velocity.mean()
        peak_at = edges[0] + int(np.argmax(velocity[: int(tone.rate / tone.hz)])) / tone.rate
        found = measured(block)
        assert found.amplitude == pytest.approx(velocity.std(), rel=1e-3)
        assert apart(found.phase_deg, 360.0 * tone.hz * (peak_at - edges[0])) <= 0.2

    def test_an_fft_agrees_at_the_centre_of_a_bin(self) -> None:
        """Steady speed, whole turns: line 32 of the plain transform is the 1x component, in acceleration."""
        turns, per_turn = 32, 128
        rng = np.random.default_rng(5)
        n = turns * per_turn
        place = np.arange(n + 1) / per_turn
        samples = 2.0 * np.cos(math.tau * place - 1.0) + 0.2 * rng.standard_normal(n + 1)
        channel = Channel("P", quantity="acceleration", unit="m/s2", detection="peak")
        block = Block((channel,), samples[None], per_turn * 10.0, np.arange(turns + 1) / 10.0)
        line = np.fft.fft(samples[:-1])[turns] * 2.0 / n
        found = measured(block, Settings(window="rectangular", harmonics=1))
        # least squares takes a mean and a trend out beside the component; noise is not quite orthogonal to the trend
        assert found.amplitude == pytest.approx(abs(line), rel=2e-4)
        assert apart(found.phase_deg, math.degrees(-np.angle(line))) <= 0.01

    def test_harmonics_are_found_with_their_own_lag(self) -> None:
        tone = Tone(harmonics=((2, 1.0, 10.0), (3, 0.5, 100.0), (5, 0.25, 330.0)), drift=0.02)
        found = measured(tone.block())
        assert [one.order for one in found.components] == [1, 2, 3, 4, 5]
        for order, rms, lag_deg in tone.harmonics:
            component = found.components[order - 1]
            assert component.amplitude == pytest.approx(rms, rel=1e-6)
            assert apart(component.phase_deg, lag_deg) <= 1e-4
        assert found.components[3].amplitude <= 1e-6

    def test_the_overall_value_holds_all_components(self) -> None:
        tone = Tone(turns=60.0, harmonics=((2, 1.0, 10.0), (3, 2.0, 100.0)), neighbour=(1.3, 1.5))
        assert measured(tone.block()).overall_rms == pytest.approx(math.sqrt(9.0 + 1.0 + 4.0 + 2.25), rel=0.01)

    def test_the_overall_value_keeps_to_its_band(self) -> None:
        tone = Tone(turns=60.0, harmonics=((4, 2.0, 10.0),))
        assert measured(tone.block(), Settings(band_hz=(15.0, 500.0))).overall_rms == pytest.approx(2.0, rel=0.01)


class TestSensors:
    """Every quantity, unit and detection states the same vibration."""

    @pytest.mark.parametrize(
        ("quantity", "unit", "per_mm_s", "turn_deg"),
        [
            ("displacement", "um", 1e3 / (math.tau * 7.7), 90.0),
            ("displacement", "mil", 1e3 / 25.4 / (math.tau * 7.7), 90.0),
            ("velocity", "mm/s", 1.0, 0.0),
            ("velocity", "in/s", 1.0 / 25.4, 0.0),
            ("acceleration", "m/s2", 1e-3 * math.tau * 7.7, -90.0),
            ("acceleration", "g", 1e-3 * math.tau * 7.7 / 9.80665, -90.0),
        ],
    )  # fmt: skip
    @pytest.mark.parametrize(("detection", "per_rms"), [("rms", 1.0), ("peak", 2**0.5), ("peak_to_peak", 8**0.5)])
    def test_conversion(self, quantity: str, unit: str, per_mm_s: float, turn_deg: float, detection: str,
                        per_rms: float) -> None:  # fmt: skip
        channel = Channel("P", quantity=quantity, unit=unit, detection=detection)  # type: ignore[arg-type]
        tone = Tone()
        found = measured(tone.block(channel=channel))
        assert found.amplitude == pytest.approx(tone.rms * per_mm_s * per_rms, rel=1e-6)
        assert apart(found.phase_deg, tone.lag_deg + turn_deg) <= 1e-4
        assert found.overall_rms == pytest.approx(tone.rms * per_mm_s, rel=0.01)

    def test_a_velocity_pickup_needs_no_integration_and_raw_units_count(self) -> None:
        tone = Tone()
        velocity = math.sqrt(2.0) * tone.rms * np.cos(tone.angle(tone.times()) - math.radians(tone.lag_deg))
        in_inches = Channel("P", raw_quantity="velocity", raw_unit="in/s")
        found = measured(with_samples(tone.block(channel=in_inches), velocity / 25.4))
        assert found.amplitude == pytest.approx(tone.rms, rel=1e-6)
        assert apart(found.phase_deg, tone.lag_deg) <= 1e-4
        in_g = Channel("P", raw_unit="g")
        assert measured(with_samples(tone.block(channel=in_g), tone.acceleration() / 9.80665)).amplitude == (
            pytest.approx(tone.rms, rel=1e-6)
        )

    def test_lead_is_the_negative_of_lag(self) -> None:
        block = Tone(harmonics=((2, 1.0, 10.0),)).block()
        lag, lead = (measured(block, Settings(phase_sense=sense)) for sense in ("lag", "lead"))
        for one, other in zip(lag.components[:2], lead.components[:2], strict=True):
            assert one.amplitude == other.amplitude
            assert apart(one.phase_deg, -other.phase_deg) <= 1e-9

    def test_channels_of_a_block_do_not_touch_each_other(self) -> None:
        one, other = Tone(rms=3.0, lag_deg=10.0), Tone(rms=0.5, lag_deg=200.0)
        channels = (Channel("P"), Channel("dead"), Channel("Q", detection="peak"))
        samples = np.stack([one.acceleration(), np.full(len(one.times()), 0.7), other.acceleration()])
        first, dead, second = measure(Block(channels, samples, one.rate, one.edges()))
        assert isinstance(first, Measured)
        assert isinstance(second, Measured)
        assert first == measured(one.block())
        assert second == measured(other.block(channel=channels[2]))
        assert isinstance(dead, Refusal)
        assert (dead.channel, dead.code) == (channels[1], "dropout")


class TestProperties:
    @given(tones, tones, st.floats(-5.0, 5.0))
    @few
    def test_vectors_add_as_signals_do(self, one: Tone, other: Tone, factor: float) -> None:
        other = replace(other, hz=one.hz, turns=one.turns, drift=one.drift, mark=one.mark)
        both = one.acceleration() + factor * other.acceleration()
        expected = vector(measured(one.block())) + factor * vector(measured(other.block()))
        assert abs(vector(measured(with_samples(one.block(), both))) - expected) <= 1e-6 * (one.rms + other.rms)

    @given(tones, st.floats(-0.2, 0.2))
    @few
    def test_a_later_mark_lessens_the_lag(self, tone: Tone, later_turns: float) -> None:
        tone = replace(tone, drift=0.0)
        block = tone.block()
        moved = replace(block, edges_s=block.edges_s + later_turns / tone.hz)
        before, after = measured(block), measured(moved)
        assert apart(after.phase_deg, before.phase_deg - 360.0 * later_turns) <= 1e-3
        assert after.amplitude == pytest.approx(before.amplitude, rel=1e-5)

    @given(tones, st.floats(0.5, 2.0))
    @few
    def test_the_clock_sets_the_speed_and_only_the_integration_feels_it(self, tone: Tone, faster: float) -> None:
        """The same samples, said to be taken faster: the speed is greater, the velocity smaller by as much."""
        block = tone.block()
        hurried = replace(block, sample_rate_hz=block.sample_rate_hz * faster, edges_s=block.edges_s / faster)
        before, after = measured(block), measured(hurried)
        assert after.speed_rpm == pytest.approx(before.speed_rpm * faster, rel=1e-9)
        assert after.amplitude == pytest.approx(before.amplitude / faster, rel=1e-6)
        assert apart(after.phase_deg, before.phase_deg) <= 1e-4

    @given(tones, st.floats(-100.0, 100.0), st.floats(-10.0, 10.0))
    @few
    def test_an_offset_and_a_trend_are_nothing(self, tone: Tone, offset: float, trend: float) -> None:
        """What sensors add by themselves; it stays out of the 1x vector down to the side lobes of the taper."""
        block = tone.block()
        drift = offset + trend * np.linspace(0.0, 1.0, block.samples.shape[1])
        assert abs(vector(measured(with_samples(block, block.samples[0] + drift))) - vector(measured(block))) <= (
            1e-4 * (abs(offset) + abs(trend)) * 1e3 / (math.tau * tone.hz) + 1e-9
        )


class TestRefusals:
    def test_too_few_turns(self) -> None:
        with pytest.raises(SignalRefused, match="record for longer") as refusal:
            measure(Tone(turns=3.5).block())
        assert refusal.value.code == "too_short"

    def test_a_speed_that_runs_away(self) -> None:
        with pytest.raises(SignalRefused, match="within the block") as refusal:
            measure(Tone(turns=40.0, drift=0.3).block())
        assert refusal.value.code == "speed"

    def test_another_speed_than_named(self) -> None:
        block = Tone().block()
        assert measured(block, Settings(nominal_rpm=450.0)).flags == ()
        with pytest.raises(SignalRefused, match="one mark to a turn"):
            measure(block, Settings(nominal_rpm=231.0))

    def test_too_slow_sampling(self) -> None:
        with pytest.raises(SignalRefused, match="sample faster") as refusal:
            measure(Tone(rate=18.0).block())
        assert refusal.value.code == "sampling"

    def test_fewer_harmonics_where_the_rate_carries_fewer(self) -> None:
        assert len(measured(Tone(rate=64.0).block()).components) == 3

    def test_samples_beyond_all_bounds(self) -> None:
        block = Tone().block()
        assert refused(with_samples(block, block.samples[0] * 1e200)).code == "numbers"

    @pytest.mark.parametrize(
        "change",
        [
            {"phase_sense": "late"},
            {"window": "round"},
            {"harmonics": 0},
            {"band_hz": (0.0, 10.0)},
            {"band_hz": (20.0, 10.0)},
            {"nominal_rpm": math.nan},
        ],
    )
    def test_settings(self, change: dict[str, object]) -> None:
        with pytest.raises(InvalidSetting, match=next(iter(change))):
            Settings(**change)  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        "change",
        [{"quantity": "force"}, {"unit": "furlong"}, {"raw_unit": "mm/s"}, {"detection": "mean"}, {"full_scale": 0.0}],
    )
    def test_channels(self, change: dict[str, object]) -> None:
        with pytest.raises(InvalidSetting, match=next(iter(change))):
            Channel("P", **change)  # type: ignore[arg-type]

    def test_blocks(self) -> None:
        good = Tone().block()
        for change in (
            {"channels": ()},
            {"channels": (Channel("P"), Channel("P"))},
            {"samples": np.zeros((2, 100))},
            {"samples": np.full((1, 100), np.inf)},
            {"sample_rate_hz": 0.0},
            {"sample_rate_hz": math.nan},
            {"edges_s": np.zeros((2, 2))},
        ):
            with pytest.raises(InvalidSetting):
                replace(good, **change)
