"""Conventions as physics: what turning, mirroring and restating a drum does to what its instruments read."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.errors import InvalidSetting
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.rotor import Unbalance
from drivers.simulator.sensors import Sensor, overall_rms, sense
from drivers.simulator.spec import (
    DrumSpec,
    FittedMass,
    Plane,
    Scatter,
    geometric_degrees,
    motion_of,
    stated_degrees,
    true_readings,
    unbalance_of,
)
from tests.support.drivers.drums import angles, drums, mirrored, pieces, rotations, turned

CLOSE_DEG = 1e-6


def apart(one_deg: float, other_deg: float) -> float:
    """Degrees between two directions, 0 to 180."""
    return abs((one_deg - other_deg + 180.0) % 360.0 - 180.0)


def restated(piece: FittedMass) -> FittedMass:
    """The same hole, its angle counted the other way round."""
    return replace(piece, angle_deg=-piece.angle_deg)


class TestSenses:
    @given(drums(), pieces)
    def test_lag_and_lead_are_negatives_and_amplitudes_do_not_care(
        self, spec: DrumSpec, masses: list[FittedMass]
    ) -> None:
        lag, lead = (true_readings(replace(spec, phase_sense=sense), masses) for sense in ("lag", "lead"))
        for name in lag:
            assert lag[name][0] == lead[name][0]
            assert apart(lag[name][1], -lead[name][1]) <= CLOSE_DEG
            assert 0.0 <= lead[name][1] < 360.0

    @given(drums(), pieces)
    def test_against_and_with_rotation_name_the_same_hole_by_mirrored_angles(
        self, spec: DrumSpec, masses: list[FittedMass]
    ) -> None:
        against = true_readings(replace(spec, angle_sense="against_rotation"), masses)
        along = true_readings(replace(spec, angle_sense="with_rotation"), [restated(one) for one in masses])
        assert against == along

    @given(rotations, st.sampled_from(["against_rotation", "with_rotation"]), angles)
    def test_stated_and_geometric_angles_are_inverse(self, rotation: str, sense: str, angle: float) -> None:
        spin = 1 if rotation == "ccw" else -1
        there = stated_degrees(angle, sense, spin)  # type: ignore[arg-type]
        assert 0.0 <= there < 360.0
        assert apart(geometric_degrees(there, sense, spin), angle) <= CLOSE_DEG  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("rotation", "sense", "expected"),
        [("ccw", "with_rotation", 30.0), ("cw", "with_rotation", -30.0),
         ("ccw", "against_rotation", -30.0), ("cw", "against_rotation", 30.0)],
    )  # fmt: skip
    def test_with_rotation_is_the_way_the_mark_runs(self, rotation: str, sense: str, expected: float) -> None:
        spec = replace(threshing_drum_example(), rotation=rotation, angle_sense=sense)  # type: ignore[arg-type]
        assert unbalance_of(spec, FittedMass("1", 10.0, 30.0)).angle_deg == expected


class TestTurning:
    @given(drums(), angles)
    def test_the_whole_unbalance_moved_against_the_rotation_peaks_later_by_as_much(
        self, spec: DrumSpec, angle: float
    ) -> None:
        before = true_readings(spec)
        after = true_readings(turned(spec, geometric_degrees(angle, "against_rotation", spec.spin)))
        for name, (amplitude, lag) in before.items():
            assert after[name][0] == pytest.approx(amplitude, rel=1e-9, abs=1e-12)
            assert amplitude < 1e-9 or apart(after[name][1], lag + angle) <= CLOSE_DEG

    @given(drums(), angles)
    def test_a_pickup_moved_with_the_rotation_is_passed_later_so_the_lag_shrinks(
        self, spec: DrumSpec, angle: float
    ) -> None:
        moved = replace(spec, pickup_deg=spec.pickup_deg + spec.spin * angle)
        for name, (_, lag) in true_readings(spec).items():
            assert apart(true_readings(moved)[name][1], lag - angle) <= CLOSE_DEG

    @given(drums())
    def test_a_mirror_changes_no_reading(self, spec: DrumSpec) -> None:
        seen = true_readings(mirrored(spec))
        for name, (amplitude, lag) in true_readings(spec).items():
            assert seen[name][0] == pytest.approx(amplitude, rel=1e-9, abs=1e-12)
            assert amplitude < 1e-9 or apart(seen[name][1], lag) <= CLOSE_DEG

    def test_below_resonance_the_displacement_peaks_when_the_mass_points_at_the_sensor(self) -> None:
        """By hand: ccw drum, pick-up at 90 degrees, sensor at 0, mass 100 degrees against the rotation from the mark.

        At the mark's passing the mass stands at 90 - 100 = -10 degrees and reaches the sensor 10 degrees later.
        """
        example = threshing_drum_example()
        p, q = (
            replace(one, stiffness_x=1e9, stiffness_y=1e9, damping_x=1.0, damping_y=1.0)
            for one in example.rotor.bearings
        )
        spec = replace(
            example,
            rotor=replace(example.rotor, bearings=(p, q)),
            sensors=(Sensor("P", -480.0, quantity="displacement", unit="um"),),
            unbalances=(),
            rotation="ccw",
        )
        assert true_readings(spec, [FittedMass("1", 100.0, 100.0)])["P"][1] == pytest.approx(10.0, abs=0.01)
        assert true_readings(replace(spec, rotation="cw"), [FittedMass("1", 100.0, 100.0)])["P"][1] == pytest.approx(
            190.0, abs=0.01
        )


class TestLinearity:
    @given(drums(), pieces, pieces)
    def test_vibrations_of_pieces_add_up(
        self, spec: DrumSpec, some: list[FittedMass], others: list[FittedMass]
    ) -> None:
        bare = motion_of(spec).phasors
        together = motion_of(spec, [*some, *others]).phasors - bare
        apart_ = (motion_of(spec, some).phasors - bare) + (motion_of(spec, others).phasors - bare)
        scale = np.abs(bare) + np.abs(together) + np.abs(motion_of(spec, some).phasors)
        assert np.all(np.abs(together - apart_) <= 1e-9 * scale.max())

    @given(drums(), st.floats(0.01, 100.0))
    def test_twice_the_unbalance_shakes_twice_as_much(self, spec: DrumSpec, factor: float) -> None:
        more = replace(
            spec, unbalances=tuple(replace(one, amount_g_mm=factor * one.amount_g_mm) for one in spec.unbalances)
        )
        for name, (amplitude, _) in true_readings(spec).items():
            assert true_readings(more)[name][0] == pytest.approx(factor * amplitude, rel=1e-9)

    @given(drums(), st.sampled_from(["1", "2"]), st.floats(1.0, 500.0), angles)
    def test_a_piece_opposite_an_equal_one_takes_it_off_again(
        self, spec: DrumSpec, plane: str, grams: float, angle: float
    ) -> None:
        both = [FittedMass(plane, grams, angle), FittedMass(plane, grams, angle + 180.0)]
        assert motion_of(spec, both).phasors == pytest.approx(motion_of(spec).phasors, rel=1e-6, abs=1e-15)


class TestSensors:
    @pytest.mark.parametrize(
        ("quantity", "unit", "per_si", "order"),
        [("displacement", "um", 1e6, 0), ("displacement", "mm", 1e3, 0), ("displacement", "mil", 1 / 25.4e-6, 0),
         ("velocity", "mm/s", 1e3, 1), ("velocity", "in/s", 1 / 25.4e-3, 1),
         ("acceleration", "m/s2", 1.0, 2), ("acceleration", "g", 1 / 9.80665, 2)],
    )  # fmt: skip
    @pytest.mark.parametrize(("detection", "factor"), [("peak", 1.0), ("rms", 2**-0.5), ("peak_to_peak", 2.0)])
    def test_units_and_detections(
        self, quantity: str, unit: str, per_si: float, order: int, detection: str, factor: float
    ) -> None:
        motion = motion_of(threshing_drum_example())
        metres = motion.displacement(-480.0, 0.0)
        sensor = Sensor("P", -480.0, 0.0, quantity, unit, detection)  # type: ignore[arg-type]
        assert abs(sense(sensor, motion)) == pytest.approx(
            abs(metres) * motion.omega**order * per_si * factor, rel=1e-12
        )

    @given(drums())
    def test_velocity_peaks_90_degrees_before_displacement_and_acceleration_180(self, spec: DrumSpec) -> None:
        first = spec.sensors[0]
        trio = tuple(
            replace(first, name=quantity, quantity=quantity, unit=unit)  # type: ignore[arg-type]
            for quantity, unit in (("displacement", "um"), ("velocity", "mm/s"), ("acceleration", "m/s2"))
        )
        lags = {name: lag for name, (_, lag) in true_readings(replace(spec, sensors=trio)).items()}
        assert apart(lags["velocity"], lags["displacement"] - 90.0) <= CLOSE_DEG
        assert apart(lags["acceleration"], lags["displacement"] - 180.0) <= CLOSE_DEG

    @given(drums())
    def test_a_sensor_turned_round_reads_half_a_turn_later(self, spec: DrumSpec) -> None:
        behind = tuple(replace(one, direction_deg=one.direction_deg + 180.0) for one in spec.sensors)
        for name, (amplitude, lag) in true_readings(replace(spec, sensors=behind)).items():
            assert amplitude == pytest.approx(true_readings(spec)[name][0], rel=1e-9, abs=1e-12)
            assert amplitude < 1e-9 or apart(lag, true_readings(spec)[name][1] + 180.0) <= CLOSE_DEG

    def test_the_overall_value_is_rms_whatever_the_detection(self) -> None:
        for detection, one_x in (("rms", 3.0), ("peak", 3.0 * math.sqrt(2.0)), ("peak_to_peak", 6.0 * math.sqrt(2.0))):
            sensor = Sensor("P", 0.0, detection=detection, broadband_rms=4.0)  # type: ignore[arg-type]
            assert overall_rms(sensor, one_x) == pytest.approx(5.0)


class TestRefusals:
    @pytest.mark.parametrize(
        ("make", "says"),
        [
            (lambda: FittedMass("1", 0.0, 0.0), r"mass_g 0\.0 in plane '1' must be > 0"),
            (lambda: FittedMass("1", math.nan, 0.0), "mass_g nan of FittedMass must be a finite number"),
            (lambda: Plane("1", 0.0, 0.0), r"radius_mm 0\.0 of plane '1' must be > 0"),
            (lambda: Unbalance(0.0, math.inf, 0.0), "amount_g_mm inf"),
            (lambda: Sensor("P", 0.0, unit="furlong"), "unit 'furlong' of velocity must be one of mm/s, in/s"),
            (lambda: Sensor("P", 0.0, quantity="heat"), "quantity 'heat'"),  # type: ignore[arg-type]
            (lambda: Sensor("P", 0.0, detection="mean"), "detection 'mean'"),  # type: ignore[arg-type]
            (lambda: Sensor("P", 0.0, noise=-1.0), r"noise -1\.0 of sensor 'P'"),
            (lambda: Scatter(amplitude=0.5), r"scatter amplitude 0\.5 must be within 0 and 0\.2"),
            (lambda: Scatter(phase_deg=-1.0), r"scatter phase_deg -1\.0"),
            (lambda: replace(threshing_drum_example(), speed_rpm=0.0), r"speed_rpm 0\.0 must be > 0"),
            (lambda: replace(threshing_drum_example(), sensors=()), "number of sensors 0"),
            (lambda: replace(threshing_drum_example(), rotation="left"), "rotation 'left' must be one of cw, ccw"),  # type: ignore[arg-type]
            (lambda: replace(threshing_drum_example(), planes=(Plane("1", 1.0, 0.0),) * 2), "name '1' of two planes"),
            (lambda: threshing_drum_example().plane("3"), "plane '3' is not on this drum: use one of 1, 2"),
        ],
    )
    def test_a_value_that_breaks_a_rule_is_named(self, make: object, says: str) -> None:
        with pytest.raises(InvalidSetting, match=says):
            make()  # type: ignore[operator]
