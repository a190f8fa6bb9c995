"""A trial mass: its force before the drum turns with it, and what it did afterwards."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from service.engine import trial_check
from service.errors import InvalidInput
from service.model.run import MassOnRotor
from tests.support.numerics.drum_log import machine, run, session

LOG = session()
FORCE_PER_G = 1e-3 * 0.330 * (460.0 * 3.141592653589793 / 30.0) ** 2
"""N: 0.766 N for each gram at 330 mm and 460 r/min."""


def test_the_force_is_mass_times_radius_times_speed_squared() -> None:
    found = trial_check.force_of(LOG.machine, "1", 200.0)
    assert found.force_n == pytest.approx(200.0 * FORCE_PER_G)
    assert found.share is not None
    assert 0.2 < found.share < 0.3  # of about 60 kg, 590 N
    assert found.doubts == ("force_large",)
    assert found.bearable
    assert trial_check.force_of(LOG.machine, "1", -200.0).force_n == found.force_n


def test_a_mass_is_compared_with_the_suggested_one() -> None:
    small = trial_check.force_of(LOG.machine, "1", 31.0, suggested_g=10.0)
    assert small.doubts == ("mass_above_suggested",)
    assert trial_check.force_of(LOG.machine, "1", 29.0, suggested_g=10.0).doubts == ()
    assert trial_check.force_of(LOG.machine, "1", 3.0, suggested_g=10.0).doubts == ("mass_below_suggested",)


def test_masses_that_lift_the_drum_are_refused() -> None:
    trial_check.require_bearable(LOG.machine, (MassOnRotor(plane="1", mass_g=200.0, angle_deg=0.0),))
    with pytest.raises(InvalidInput):
        trial_check.require_bearable(LOG.machine, (MassOnRotor(plane="1", mass_g=2000.0, angle_deg=0.0),))


def test_without_a_rotor_mass_nothing_is_refused() -> None:
    unknown = session(rotor_mass_kg=None, balance_grade_mm_s=None).machine
    assert trial_check.force_of(unknown, "1", 2000.0).share is None
    assert "rotor_mass_kg" not in json.dumps(machine(rotor_mass_kg=None))


def test_thirty_percent_or_thirty_degrees_are_a_clear_answer() -> None:
    """200 g in plane 1 change P by 2.8 of 3.0 mm/s; Q by 0.6 of 5.0."""
    effects = trial_check.effect_of(LOG.machine, LOG.runs[0], LOG.runs[1], ())
    by_sensor = {one.sensor: one for one in effects}
    assert by_sensor["P"].change == pytest.approx(2.8 / 3.0)
    assert by_sensor["P"].clear
    assert not by_sensor["Q"].clear
    assert trial_check.answer_of(effects) == "clear"


def test_a_run_that_repeats_the_one_before_had_no_mass_on() -> None:
    same = trial_check.effect_of(LOG.machine, LOG.runs[0], LOG.runs[0], ())
    assert trial_check.answer_of(same) == "none"
    little = session([run("initial"), run("trial", ("1", 20.0, 0.0))])
    small = trial_check.effect_of(little.machine, little.runs[0], little.runs[1], ())
    assert trial_check.answer_of(small) == "small"


def test_sensors_that_are_missing_in_one_run_are_left_out() -> None:
    half = replace(LOG.runs[1], readings=LOG.runs[1].readings[:1])
    assert [one.sensor for one in trial_check.effect_of(LOG.machine, LOG.runs[0], half, ())] == ["P"]
