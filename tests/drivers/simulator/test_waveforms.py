"""The drum's waveforms: through the whole signal chain they read what the mechanics say."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings

from drivers.block_driver import TimedBlock
from drivers.clock import ManualClock
from drivers.errors import InvalidSetting
from drivers.signal.block import Block
from drivers.signal.chain import Measured, Settings, measure
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.sensors import Sensor
from drivers.simulator.spec import DrumSpec, FittedMass, true_readings
from drivers.simulator.waveform_driver import SimulatedWaveforms
from drivers.simulator.waveforms import Disturbance, simulate_block
from tests.support.drivers.analytic import apart
from tests.support.drivers.drums import drums, pieces

ROUGH = Disturbance(speed_drift=0.03, electronics=0.005, jitter_s=5e-5, missed=0.01, doubled=0.01)


def simulated(
    spec: DrumSpec,
    masses: list[FittedMass] | None = None,
    seed: int = 1,
    seconds: float = 8.0,
    rate: float = 2560.0,
    disturbance: Disturbance | None = None,
) -> Block:
    rng = np.random.default_rng(seed)
    return simulate_block(spec, masses or (), seconds=seconds, sample_rate_hz=rate, rng=rng, disturbance=disturbance)


def check(spec: DrumSpec, block: Block, masses: list[FittedMass] | None = None, *, rel: float, deg: float) -> None:
    """Every channel reads what the mechanics say at the speed it states."""
    for found in measure(block, Settings(phase_sense=spec.phase_sense)):
        assert isinstance(found, Measured), found
        amplitude, phase_deg = true_readings(spec, masses or (), speed_rpm=found.speed_rpm)[found.channel.sensor]
        assert found.amplitude == pytest.approx(amplitude, rel=rel)
        assert apart(found.phase_deg, phase_deg) <= deg


class TestEndToEnd:
    @pytest.mark.parametrize(
        ("rotation", "phase_sense", "pickup_deg"),
        list(itertools.product(["cw", "ccw"], ["lag", "lead"], [0.0, 90.0, -160.0])),
    )
    def test_simulated_waveforms_read_true_in_every_sense_and_rotation(
        self, rotation: str, phase_sense: str, pickup_deg: float
    ) -> None:
        spec = replace(threshing_drum_example(), rotation=rotation, phase_sense=phase_sense, pickup_deg=pickup_deg)  # type: ignore[arg-type]
        pieces_on = [FittedMass("1", 200.0, 40.0), FittedMass("2", 100.0, 260.0)]
        for masses in ([], pieces_on):
            check(spec, simulated(spec, masses), masses, rel=1e-4, deg=0.01)
            check(spec, simulated(spec, masses, disturbance=ROUGH), masses, rel=0.005, deg=0.5)

    @pytest.mark.parametrize(
        ("quantity", "unit", "detection"),
        [("displacement", "um", "peak_to_peak"), ("velocity", "in/s", "peak"), ("acceleration", "g", "rms")],
    )
    def test_every_sensor_states_it_in_its_own_way(self, quantity: str, unit: str, detection: str) -> None:
        sensor = Sensor("P", -480.0, 30.0, quantity, unit, detection)  # type: ignore[arg-type]
        spec = replace(threshing_drum_example(), sensors=(sensor,))
        check(spec, simulated(spec), rel=1e-6, deg=1e-3)

    @given(drums(), pieces)
    @settings(max_examples=20, deadline=None)
    def test_any_drum_anywhere_near_resonance_or_not(self, spec: DrumSpec, masses: list[FittedMass]) -> None:
        still = true_readings(spec, masses)
        assume(all(amplitude > 1e-6 for amplitude, _ in still.values()))
        hz = spec.speed_rpm / 60.0
        check(spec, simulated(spec, masses, seconds=20.5 / hz, rate=64.0 * hz), masses, rel=1e-6, deg=1e-4)

    def test_the_overall_value_is_the_one_of_the_instruments(self) -> None:
        spec = threshing_drum_example()
        for found in measure(simulated(spec)):
            assert isinstance(found, Measured)
            one_x, _ = true_readings(spec)[found.channel.sensor]
            assert found.overall_rms == pytest.approx(math.hypot(one_x, 0.3), rel=0.002)

    def test_what_lies_beside_adds_up_to_the_broadband_value(self) -> None:
        """Without unbalance the overall value is the sensor's broadband_rms, in whichever parts."""
        for sensor in (
            Sensor("P", -480.0, broadband_rms=0.3),
            Sensor("P", 0.0, 0.0, "displacement", "um", "peak", 0.0, 40.0),
        ):
            spec = replace(threshing_drum_example(), unbalances=(), sensors=(sensor,))
            for shares in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.2, 0.3, 0.5)):
                (found,) = measure(simulated(spec, disturbance=Disturbance(0.0, *shares)))
                assert isinstance(found, Measured)
                assert found.overall_rms == pytest.approx(sensor.broadband_rms, rel=0.03), shares

    def test_the_stated_scatter_covers_what_rough_surroundings_do(self) -> None:
        spec = threshing_drum_example()
        ratios = []
        for seed in range(12):
            block = simulated(spec, seed=seed, disturbance=replace(ROUGH, electronics=0.05))
            for found in measure(block):
                assert isinstance(found, Measured)
                assert found.scatter is not None
                amplitude, phase = true_readings(spec, speed_rpm=found.speed_rpm)[found.channel.sensor]
                off = found.amplitude * np.exp(1j * math.radians(found.phase_deg)) - amplitude * np.exp(
                    1j * math.radians(phase)
                )
                ratios.append(abs(off) / math.sqrt(2.0) / found.scatter)
        assert 0.5 <= math.sqrt(float(np.mean(np.square(ratios)))) <= 1.3

    def test_clipping_at_the_input_is_noticed(self) -> None:
        spec = threshing_drum_example()
        outcomes = measure(simulated(spec, disturbance=Disturbance(full_scale=0.2)))
        assert [getattr(one, "code", None) for one in outcomes] == ["clipped", "clipped"]


class TestSettings:
    @pytest.mark.parametrize(
        "wrong",
        [
            {"harmonics": 0.5},
            {"harmonics": -0.4, "bearing": 1.1},
            {"speed_drift": 0.6},
            {"neighbour_order": 0.0},
            {"electronics": -1.0},
            {"full_scale": 0.0},
            {"jitter_s": -1.0},
            {"missed": 1.5},
            {"doubled": math.nan},
        ],
    )
    def test_disturbances(self, wrong: dict[str, float]) -> None:
        with pytest.raises(InvalidSetting):
            Disturbance(**wrong)

    def test_blocks(self) -> None:
        for wrong in ({"seconds": 0.0}, {"rate": math.inf}):
            with pytest.raises(InvalidSetting):
                simulated(threshing_drum_example(), **wrong)  # type: ignore[arg-type]


class TestSimulatedWaveforms:
    def test_the_same_seed_gives_the_same_readings(self) -> None:
        def first_four(seed: int) -> list[object]:
            drum = SimulatedWaveforms(threshing_drum_example(), seed=seed, clock=ManualClock(), disturbance=ROUGH)
            with drum:
                return list(itertools.islice(drum, 4))

        assert first_four(3) == first_four(3)
        assert first_four(3) != first_four(4)

    def test_fitted_masses_are_felt_from_the_next_block_on(self) -> None:
        spec = replace(threshing_drum_example(), phase_sense="lead")
        masses = [FittedMass("1", 300.0, 120.0)]
        drum = SimulatedWaveforms(spec, seed=1, clock=ManualClock())
        with drum:
            before = list(itertools.islice(drum, 2))
            drum.fit_masses(masses)
            after = list(itertools.islice(drum, 2))
        for readings, pieces_on in ((before, ()), (after, masses)):
            for reading in readings:
                amplitude, phase_deg = true_readings(spec, pieces_on)[reading.sensor]
                assert reading.amplitude == pytest.approx(amplitude, rel=1e-3)
                assert reading.phase_deg is not None
                assert apart(reading.phase_deg, phase_deg) <= 0.1
        with pytest.raises(InvalidSetting):
            drum.fit_masses([FittedMass("9", 300.0, 120.0)])

    def test_refused_blocks_are_counted_and_their_numbers_used(self) -> None:
        clipped = Disturbance(full_scale=0.2)
        drum = SimulatedWaveforms(threshing_drum_example(), seed=1, clock=ManualClock(), disturbance=clipped)
        drum.open()
        drum._take(_next(drum))
        assert drum.health().refused == 2
        assert drum.last_refusal is not None
        assert "clipped" in drum.last_refusal
        drum._disturbance = Disturbance()
        assert next(iter(drum)).sequence == 3
        drum._disturbance = Disturbance(missed=1.0)
        drum._take(_next(drum))
        assert drum.health().refused == 4
        assert "record for longer" in drum.last_refusal


def _next(drum: SimulatedWaveforms) -> TimedBlock:
    timed = drum._next_block()
    assert timed is not None
    return timed
