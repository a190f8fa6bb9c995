"""Units of the reader: shown and typed numbers mean what is stored."""

from __future__ import annotations

import math

import pytest

from service.model.machine import Sensor
from service.web import units
from service.web.display import Display
from service.web.forms import Form
from service.web.preferences import CHOICES, Preferences

INCHES = Preferences(mass="oz", length="in", velocity="in/s", detection="peak")


@pytest.mark.parametrize(
    ("sensor", "preferences", "sign", "size"),
    [
        (Sensor(name="P"), Preferences(), "mm/s rms", 1.0),
        (Sensor(name="P"), INCHES, "in/s pk", 25.4 / math.sqrt(2.0)),
        (Sensor(name="P", unit="in/s", detection="peak"), Preferences(), "mm/s pk", 1 / 25.4),
        (Sensor(name="P", quantity="displacement", unit="um", detection="peak_to_peak"), INCHES, "mil pk", 50.8),
        (Sensor(name="P", quantity="displacement", unit="mil"), Preferences(), "µm rms", 1 / 25.4),
        (Sensor(name="P", quantity="acceleration", unit="g"), INCHES, "g pk", 1 / math.sqrt(2.0)),
    ],
)
def test_amplitudes(sensor: Sensor, preferences: Preferences, sign: str, size: float) -> None:
    unit = units.amplitude(sensor, preferences)
    assert unit.sign == sign
    assert unit.size == pytest.approx(size)


def test_what_is_typed_is_stored_as_it_was_meant() -> None:
    for choice in ({"mass": m, "length": n} for m in CHOICES["mass"] for n in CHOICES["length"]):
        preferences = Preferences(**choice)
        for unit in (units.mass(preferences), units.length(preferences), units.unbalance(preferences)):
            assert unit.store(unit.show(12.5)) == pytest.approx(12.5)
    assert units.mass(INCHES).store(1.0) == pytest.approx(28.3495)
    assert units.unbalance(INCHES).store(1.0) == pytest.approx(720.08, rel=1e-4)


def test_numbers_carry_their_unit_in_the_language_of_the_reader() -> None:
    shown = Display(Preferences(language="de"))
    assert shown.mass(37.5) == "37,5\N{NARROW NO-BREAK SPACE}g"
    assert [shown.speed(rpm)[:-6] for rpm in (460.5, 1.5, 3000.0, 12345.25)] == ["460,5", "1,5", "3000", "12345,25"]
    assert shown.measured_speed(460.5).startswith("460\N{NARROW NO-BREAK SPACE}")
    assert shown.speed(460.0) == "460\N{NARROW NO-BREAK SPACE}U/min"
    assert shown.angle(-20.0) == "340°"
    assert shown.angle(359.9) == "0°"
    assert shown.mass(None) == "\N{EM DASH}"
    assert Display(INCHES).mass(28.349523125) == "1\N{NARROW NO-BREAK SPACE}oz"


P = Sensor(name="P")


@pytest.mark.parametrize(
    ("unit", "typed", "stored"),
    [
        (units.mass(Preferences()), "12 oz", 340.194),
        (units.mass(Preferences()), "12", 12.0),
        (units.mass(INCHES), "12", 340.194),
        (units.mass(INCHES), "12g", 12.0),
        (units.mass(INCHES), "0.5 KG", 500.0),
        (units.length(Preferences()), "0.5 in", 12.7),
        (units.length(Preferences()), '-0.5"', -12.7),
        (units.length(INCHES), "330 mm", 330.0),
        (units.amplitude(P, Preferences()), "0.1 in/s", 2.54),
        (units.amplitude(P, Preferences()), "0.1 in/s pk", 1.79605),
        (units.amplitude(P, INCHES), "2.54 mm/s\N{NARROW NO-BREAK SPACE}rms", 2.54),
        (units.amplitude(Sensor(name="P", quantity="displacement", unit="um"), Preferences()), "1 mil", 25.4),
        (units.amplitude(Sensor(name="P", quantity="displacement", unit="mil"), Preferences()), "25.4 µm", 1.0),
        (units.amplitude(Sensor(name="P", quantity="acceleration", unit="m/s2"), Preferences()), "1 m/s²", 1.0),
        (units.DEGREES, "40°", 40.0),
        (units.TURNS, "7.5 Hz", 450.0),
        (units.TURNS, "450 min-1", 450.0),
        (units.KILOGRAMS, "0.12 t", 120.0),
        (units.NEWTONS, "1.2 kN", 1200.0),
    ],
)
def test_a_unit_that_is_typed_is_meant(unit: units.Unit, typed: str, stored: float) -> None:
    form = Form({"x": typed})
    assert form.number("x", unit=unit) == pytest.approx(stored, rel=1e-5)
    assert form.ok


@pytest.mark.parametrize("typed", ["12 mm", "12 🙂", "12 oz g", "oz", "12 oz 3", "1e5", "12 <b>", "12" + " x" * 900])
def test_a_unit_of_another_kind_is_refused_and_what_fits_is_told(typed: str) -> None:
    form = Form({"x": typed}, Preferences(language="de"))
    assert form.number("x", unit=units.mass(Preferences())) is None
    assert ("g, kg, oz, lb" in (form.error("x") or "")) == (typed in ("12 mm", "12 🙂", "12 oz g", "12 <b>"))
