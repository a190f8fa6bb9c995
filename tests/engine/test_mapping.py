"""Documents to arrays and back: degrees and senses outside, one complex convention inside."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from service.engine import mapping
from service.engine.mapping import Channel
from service.errors import InvalidInput
from service.model.plan import Placement
from service.model.run import MassOnRotor, RunOut
from tests.support.numerics.drum_log import INITIAL, session

LOG = session()
MACHINE = LOG.machine
ROWS = mapping.channels(MACHINE, LOG.runs)


def test_a_row_is_a_sensor_at_a_speed_the_service_speed_first() -> None:
    slow = replace(LOG.runs[0], nominal_speed_rpm=300.0)
    rows = mapping.channels(MACHINE, (slow, *LOG.runs))
    assert [(row.sensor.name, row.speed_rpm) for row in rows] == [
        ("P", 460.0),
        ("Q", 460.0),
        ("P", 300.0),
        ("Q", 300.0),
    ]


def test_masses_of_a_plane_add_up_as_vectors() -> None:
    masses = [
        MassOnRotor(plane="1", mass_g=30.0, angle_deg=0.0),
        MassOnRotor(plane="1", mass_g=40.0, angle_deg=90.0),
        MassOnRotor(plane="2", mass_g=-10.0, angle_deg=180.0),
    ]
    np.testing.assert_allclose(mapping.mass_vectors(MACHINE, masses), [30 + 40j, 10.0], atol=1e-12)


def test_angles_with_the_rotation_are_mirrored() -> None:
    with_rotation = replace(MACHINE, angle_sense="with_rotation")
    mass = [MassOnRotor(plane="1", mass_g=10.0, angle_deg=90.0)]
    np.testing.assert_allclose(mapping.mass_vectors(with_rotation, mass)[0], -10j, atol=1e-12)


def test_a_piece_counts_with_its_fastener_and_as_it_was_weighed() -> None:
    piece = Placement(plane="1", position_deg=0.0, hole="1", mass_g=100.0, fastener_g=12.0)
    weighed = replace(piece, weighed_g=101.0)
    assert [one.mass_g for one in mapping.as_masses((piece, weighed))] == [112.0, 113.0]
    np.testing.assert_allclose(mapping.placement_vectors(MACHINE, (piece,)), [112.0, 0.0])


def test_readings_become_vectors_less_their_run_out() -> None:
    runs = mapping.run_set(MACHINE, LOG.runs, (), ROWS)
    np.testing.assert_allclose(runs.vibration[0], [INITIAL["P"], INITIAL["Q"]], rtol=1e-12)
    np.testing.assert_allclose(runs.masses[1], [200.0, 0.0], atol=1e-9)
    out = RunOut(sensor="P", amplitude=1.0, phase_deg=0.0)
    np.testing.assert_allclose(mapping.run_set(MACHINE, LOG.runs, (out,), ROWS).vibration[0, 0], INITIAL["P"] - 1.0)
    assert mapping.vectors_with_phase(MACHINE, LOG.runs[0], (out,))["P"] == pytest.approx(INITIAL["P"] - 1.0)
    assert mapping.amplitudes_of(MACHINE, LOG.runs[0], (out,))["P"] == pytest.approx(abs(INITIAL["P"] - 1.0))


def test_a_reading_without_phase_is_an_amplitude_and_no_vector() -> None:
    first = LOG.runs[0]
    blind = replace(first, readings=tuple(replace(one, phase_deg=None) for one in first.readings))
    assert np.isnan(mapping.run_set(MACHINE, (blind,), (), ROWS).vibration).all()
    assert mapping.vectors_with_phase(MACHINE, blind, ()) == {}
    np.testing.assert_allclose(mapping.amplitudes((blind,), ROWS)[0], [3.0, 5.0])


def test_a_limit_is_the_sensor_s_own_else_the_machine_s_in_its_unit() -> None:
    """0.7 mm/s rms at 460 r/min (48.2 rad/s) is 14.5 um rms."""
    own = replace(MACHINE.sensors[0], limit=0.2)
    moves = replace(MACHINE.sensors[0], quantity="displacement", unit="um")
    assert mapping.limit_of(MACHINE, Channel(own, 460.0)) == 0.2
    assert mapping.limit_of(MACHINE, Channel(MACHINE.sensors[0], 460.0)) == pytest.approx(0.7)
    assert mapping.limit_of(MACHINE, Channel(moves, 460.0)) == pytest.approx(0.7e3 / (460.0 * math.pi / 30.0))
    none = replace(MACHINE, vibration_limit_mm_s=None)
    assert mapping.limit_of(none, ROWS[0]) is None
    np.testing.assert_allclose(mapping.limits(none, ROWS), [1.0, 1.0])


def test_masses_come_back_in_the_machine_s_sense() -> None:
    (first, second) = mapping.plane_masses(MACHINE, np.array([100j, cmath.rect(50.0, -1.0)]))
    assert first.plane == "1"
    assert (first.mass_g, first.angle_deg) == pytest.approx((100.0, 90.0))
    assert first.unbalance_gmm == pytest.approx(33_000.0)
    assert second.angle_deg == pytest.approx(math.degrees(2.0 * math.pi - 1.0))
    assert first.interval is None


def test_what_cannot_be_known_is_null() -> None:
    assert (mapping.known(float("nan")), mapping.known(1.5)) == (None, 1.5)
    assert mapping.interval(float("nan"), 2.0) is None
    found = mapping.interval(1.0, 2.0)
    assert found is not None
    assert (found.low, found.high, found.confidence) == (1.0, 2.0, 0.95)


def test_bearings_are_stated_or_where_the_sensors_are() -> None:
    names, places, planes = mapping.require_geometry(MACHINE)
    assert names == ("P", "Q")
    np.testing.assert_allclose(places, [-480.0, 440.0])
    np.testing.assert_allclose(planes, [-330.0, 330.0])
    nowhere = replace(MACHINE, sensors=tuple(replace(sensor, axial_mm=None) for sensor in MACHINE.sensors))
    assert mapping.bearing_places(nowhere) is None
    with pytest.raises(InvalidInput):
        mapping.require_geometry(nowhere)
