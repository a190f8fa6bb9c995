"""The simulated drum as an instrument: repeatable, scattering as stated, and each fault visible."""

from __future__ import annotations

import cmath
import math
import statistics
from collections.abc import Callable
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from drivers.clock import ManualClock
from drivers.errors import DriverClosed, InvalidSetting
from drivers.reading import Reading
from drivers.simulator.drum_driver import (
    DrumSpec,
    Faults,
    FittedMass,
    LooseMass,
    Scatter,
    SimulatedDrum,
    threshing_drum_example,
)
from drivers.simulator.spec import true_readings
from tests.support.drivers.drums import drums

QUIET = replace(
    threshing_drum_example(),
    scatter=Scatter(),
    sensors=tuple(replace(one, noise=0.0) for one in threshing_drum_example().sensors),
)
TRIAL = (FittedMass("1", 200.0, 40.0),)


def opened(spec: DrumSpec = QUIET, seed: int = 1, **options: object) -> SimulatedDrum:
    drum = SimulatedDrum(spec, seed=seed, clock=ManualClock(), **options)  # type: ignore[arg-type]
    drum.open()
    return drum


def vector(reading: Reading) -> complex:
    assert reading.phase_deg is not None
    return cmath.rect(reading.amplitude, math.radians(reading.phase_deg))


def one_round(drum: SimulatedDrum) -> dict[str, complex]:
    return {reading.sensor: vector(reading) for reading in drum.measure(1)}


class TestReadings:
    @given(drums())
    @settings(max_examples=30)
    def test_without_scatter_they_are_the_truth(self, spec: DrumSpec) -> None:
        for reading in opened(spec).measure(2):
            assert (reading.amplitude, reading.phase_deg) == pytest.approx(
                true_readings(spec)[reading.sensor], rel=1e-12
            )
            assert reading.speed_rpm == spec.speed_rpm

    def test_rounds_take_each_sensor_once_and_the_clock_moves_between_rounds_only(self) -> None:
        readings = list(islice(opened(interval_s=0.5, sequence_start=7, session_id="s1"), 6))
        assert [one.sensor for one in readings] == ["P", "Q"] * 3
        assert [one.sequence for one in readings] == [7, 8, 9, 10, 11, 12]
        assert [(one.taken_at - readings[0].taken_at).total_seconds() for one in readings] == [0, 0, 0.5, 0.5, 1, 1]
        assert {one.session_id for one in readings} == {"s1"}

    def test_measure_takes_so_many_of_each_sensor_and_needs_an_open_drum(self) -> None:
        drum = opened()
        assert [one.sensor for one in drum.measure(3)] == ["P", "Q"] * 3
        with pytest.raises(InvalidSetting, match="readings_per_sensor 0"):
            drum.measure(0)
        drum.close()
        with pytest.raises(DriverClosed):
            drum.measure(1)

    def test_measuring_in_the_middle_of_a_round_keeps_the_promises(self) -> None:
        drum = opened()
        readings = [next(iter(drum)), *drum.measure(1), *islice(drum, 2)]
        assert [one.sequence for one in readings] == [1, 3, 4, 5, 6]
        assert drum.health().missed == 1

    def test_masses_replace_those_before_and_start_a_run(self) -> None:
        drum = opened()
        bare = one_round(drum)
        drum.fit_masses(TRIAL)
        assert drum.run == 2
        with_trial = one_round(drum)
        drum.fit_masses(TRIAL)
        assert one_round(drum) == with_trial != bare
        drum.fit_masses([])
        assert one_round(drum) == bare

    def test_a_refused_change_changes_nothing(self) -> None:
        drum = opened()
        drum.fit_masses(TRIAL)
        refusals: tuple[Callable[[], None], ...] = (
            lambda: drum.fit_masses([FittedMass("9", 10.0, 0.0)]),
            lambda: drum.set_speed(math.nan),
            lambda: drum.set_faults(Faults(stuck=("R",))),
            lambda: drum.set_faults(Faults(loose_trial_mass=LooseMass("9"))),
            lambda: drum.set_faults(Faults(swapped=("P", "P"))),
        )
        for refused in refusals:
            with pytest.raises(InvalidSetting):
                refused()
        assert (drum.masses, drum.speed_rpm, drum.faults, drum.run) == (TRIAL, 460.0, Faults(), 2)

    def test_speed_is_what_the_drum_turns_at(self) -> None:
        drum = opened()
        drum.set_speed(900.0)
        for reading in drum.measure(1):
            assert reading.speed_rpm == 900.0
            assert (reading.amplitude, reading.phase_deg) == pytest.approx(
                true_readings(QUIET, speed_rpm=900.0)[reading.sensor], rel=1e-12
            )


class TestSeed:
    def test_the_same_seed_and_steps_give_the_same_readings_and_another_seed_others(self) -> None:
        def story(seed: int) -> list[Reading]:
            drum = opened(threshing_drum_example(), seed)
            first = drum.measure(5)
            drum.fit_masses(TRIAL)
            drum.set_faults(Faults(dropout=0.2))
            return first + drum.measure(5)

        assert story(4) == story(4)
        assert story(4) != story(5)

    def test_a_fault_leaves_the_scatter_of_everything_else_as_it_was(self) -> None:
        healthy, faulty = opened(threshing_drum_example()), opened(threshing_drum_example())
        faulty.set_faults(Faults(dropout=0.5, stuck=("P",)))
        wanted = {one.sequence: one for one in healthy.measure(50)}
        arrived = [one for one in faulty.measure(50) if one.sensor == "Q"]
        assert 10 < len(arrived) < 40
        assert all(one == wanted[one.sequence] for one in arrived)


class TestScatter:
    """Bounds of four standard errors around the stated values; the seeds are fixed."""

    COUNT = 4000

    def measured(self, scatter: Scatter, noise: float = 0.0) -> list[complex]:
        sensors = tuple(replace(one, noise=noise) for one in QUIET.sensors[:1])
        drum = opened(replace(QUIET, sensors=sensors, scatter=scatter), seed=11)
        amplitude, phase = true_readings(QUIET)["P"]
        return [vector(one) / cmath.rect(amplitude, math.radians(phase)) for one in drum.measure(self.COUNT)]

    def test_amplitude_and_phase_of_single_readings(self) -> None:
        relative = self.measured(Scatter(amplitude=0.03, phase_deg=2.0))
        error = 4.0 / math.sqrt(2.0 * self.COUNT)
        assert statistics.stdev(abs(one) for one in relative) == pytest.approx(0.03, rel=error)
        assert statistics.stdev(math.degrees(cmath.phase(one)) for one in relative) == pytest.approx(2.0, rel=error)
        assert statistics.fmean(abs(one) for one in relative) == pytest.approx(1.0, abs=4 * 0.03 / self.COUNT**0.5)
        assert statistics.fmean(cmath.phase(one) for one in relative) == pytest.approx(
            0.0, abs=4 * math.radians(2.0) / self.COUNT**0.5
        )

    def test_sensor_noise_is_per_real_component_in_the_unit(self) -> None:
        amplitude = true_readings(QUIET)["P"][0]
        relative = self.measured(Scatter(), noise=0.05)
        error = 4.0 / math.sqrt(2.0 * self.COUNT)
        assert statistics.stdev(one.real for one in relative) * amplitude == pytest.approx(0.05, rel=error)
        assert statistics.stdev(one.imag for one in relative) * amplitude == pytest.approx(0.05, rel=error)

    def test_run_to_run_scatter_and_drift_are_drawn_for_a_run_and_kept_in_it(self) -> None:
        drum = opened(replace(QUIET, scatter=Scatter(run_amplitude=0.02, run_phase_deg=1.5)), seed=12)
        drifting = opened(replace(QUIET, scatter=Scatter(run_speed=0.005)), seed=13)
        amplitude, phase = true_readings(QUIET)["P"]
        relative, speeds, runs = [], [], 400
        for _ in range(runs):
            first, second = (vector(one) for one in drum.measure(2) if one.sensor == "P")
            assert first == second
            relative.append(first / cmath.rect(amplitude, math.radians(phase)))
            drum.new_run()
            speeds.append({one.speed_rpm for one in drifting.measure(2)})
            drifting.new_run()
        error = 4.0 / math.sqrt(2.0 * runs)
        assert statistics.stdev(abs(one) for one in relative) == pytest.approx(0.02, rel=error)
        assert statistics.stdev(math.degrees(cmath.phase(one)) for one in relative) == pytest.approx(1.5, rel=error)
        assert all(len(one) == 1 for one in speeds)
        assert statistics.stdev(one.pop() or 0.0 for one in speeds) == pytest.approx(0.005 * 460.0, rel=error)

    def test_drift_shows_in_the_vibration_as_the_speed_it_is(self) -> None:
        drum = opened(replace(QUIET, scatter=Scatter(run_speed=0.01)), seed=14)
        for reading in drum.measure(1):
            expected = true_readings(QUIET, speed_rpm=reading.speed_rpm)[reading.sensor]
            assert (reading.amplitude, reading.phase_deg) == pytest.approx(expected, rel=1e-12)
            assert reading.speed_rpm != 460.0


class TestFaults:
    """Each fault against the healthy drum, without scatter."""

    def pair(self, faults: Faults) -> tuple[dict[str, complex], dict[str, complex]]:
        """Readings with the trial mass on: healthy, faulty."""
        healthy, faulty = opened(), opened()
        faulty.set_faults(faults)
        for drum in (healthy, faulty):
            drum.fit_masses(TRIAL)
        return one_round(healthy), one_round(faulty)

    def test_dropout_loses_readings_with_their_numbers_and_counts_them(self) -> None:
        drum = opened()
        drum.set_faults(Faults(dropout=0.25))
        readings = drum.measure(1000)
        assert 2000 - len(readings) == pytest.approx(500, abs=4 * math.sqrt(2000 * 0.25 * 0.75))
        assert drum.health().missed == 2000 - len(readings)
        assert readings[-1].sequence > len(readings)

    def test_a_silent_sensor_gives_nothing_and_the_other_all(self) -> None:
        drum = opened()
        drum.set_faults(Faults(silent=("P",)))
        assert [one.sensor for one in drum.measure(3)] == ["Q"] * 3
        assert drum.health().missed == 3

    def test_a_stuck_sensor_repeats_itself_whatever_is_bolted_on(self) -> None:
        drum = opened(threshing_drum_example())
        before = drum.measure(1)
        drum.set_faults(Faults(stuck=("P",)))
        drum.fit_masses(TRIAL)
        after = drum.measure(1)
        assert (after[0].amplitude, after[0].phase_deg) == (before[0].amplitude, before[0].phase_deg)
        assert after[1].amplitude != before[1].amplitude
        assert after[0].sequence > before[0].sequence
        drum.set_faults(Faults())
        assert drum.measure(1)[0].amplitude != before[0].amplitude

    def test_swapped_cables_exchange_the_places(self) -> None:
        healthy, faulty = self.pair(Faults(swapped=("P", "Q")))
        assert faulty == {"P": healthy["Q"], "Q": healthy["P"]}

    def test_a_wrong_phase_sense_turns_the_sign_of_the_phase(self) -> None:
        healthy, faulty = self.pair(Faults(wrong_phase_sense=True))
        for name in healthy:
            assert faulty[name] == pytest.approx(healthy[name].conjugate())

    def test_a_wrong_angle_sense_puts_the_trial_mass_into_the_mirrored_hole(self) -> None:
        _, faulty = self.pair(Faults(wrong_angle_sense=True))
        mirrored = opened()
        mirrored.fit_masses([replace(TRIAL[0], angle_deg=-TRIAL[0].angle_deg)])
        assert faulty == one_round(mirrored)

    def test_a_knocked_pickup_turns_all_phases_alike(self) -> None:
        healthy, faulty = self.pair(Faults(pickup_shift_deg=25.0))
        turns = [math.degrees(cmath.phase(faulty[name] / healthy[name])) for name in healthy]
        assert turns == pytest.approx([25.0, 25.0])  # the drum turns cw: a pick-up moved ccw is passed earlier

    def test_without_a_key_phasor_there_is_neither_phase_nor_speed(self) -> None:
        drum = opened()
        drum.set_faults(Faults(no_key_phasor=True))
        for reading in drum.measure(1):
            assert reading.phase_deg is None
            assert reading.speed_rpm is None
            assert reading.amplitude == pytest.approx(true_readings(QUIET)[reading.sensor][0], rel=1e-12)

    @pytest.mark.parametrize(
        ("loose", "really"),
        [
            (LooseMass("1", slip_deg=35.0), [FittedMass("1", 200.0, 75.0)]),
            (LooseMass("1", lost=True), []),
            (LooseMass("2", slip_deg=35.0, lost=True), list(TRIAL)),
        ],
        ids=["slipped", "lost", "other plane"],
    )
    def test_a_loose_mass_sits_elsewhere_than_stated(self, loose: LooseMass, really: list[FittedMass]) -> None:
        _, faulty = self.pair(Faults(loose_trial_mass=loose))
        honest = opened()
        honest.fit_masses(really)
        assert faulty == one_round(honest)

    def test_a_wandering_mass_shakes_the_readings_of_one_run(self) -> None:
        drum = opened()
        drum.fit_masses(TRIAL)
        drum.set_faults(Faults(loose_trial_mass=LooseMass("1", wander_deg=10.0)))
        found = np.array([vector(one) for one in drum.measure(50) if one.sensor == "P"])
        effect = abs(one_round(opened())["P"] - self.pair(Faults())[0]["P"])
        assert np.std(found) == pytest.approx(effect * math.radians(10.0), rel=0.4)

    @pytest.mark.parametrize("faults", [lambda: Faults(dropout=1.5), lambda: Faults(dropout=math.nan),
                                        lambda: LooseMass("1", wander_deg=-1.0)])  # fmt: skip
    def test_impossible_faults_are_refused(self, faults: Callable[[], object]) -> None:
        with pytest.raises(InvalidSetting):
            faults()


@given(drums(), st.integers(0, 2**32))
@settings(max_examples=30)
def test_any_drum_is_balanced_by_what_its_own_trial_runs_teach(spec: DrumSpec, seed: int) -> None:
    """Readings alone, in lag and against the rotation, suffice to find the masses that still the drum.

    The few lines below are the textbook's trial-run method for two planes, on purpose not the product's.
    """
    drum = opened(spec, seed)
    trial_g = 100.0

    def read(*masses: FittedMass) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
        drum.fit_masses(masses)
        return np.array(list(one_round(drum).values()))

    bare = read()
    effect = np.stack([read(FittedMass(plane, trial_g, 0.0)) - bare for plane in ("1", "2")], axis=1) / trial_g
    assume(np.linalg.cond(effect) < 1e6)  # two sensors at one place teach nothing
    needed = np.linalg.solve(effect, -bare)
    stilled = read(
        *(FittedMass(plane, abs(u), math.degrees(cmath.phase(u))) for plane, u in zip("12", needed, strict=True))
    )
    assert np.all(np.abs(stilled) <= 1e-6 * np.abs(bare).max())
