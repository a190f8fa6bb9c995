"""Units of the reader: shown and typed numbers mean what is stored."""

from __future__ import annotations

import math

import pytest

from db.documents.machine import Sensor
from service.web import units
from service.web.display import Display
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
    assert shown.speed(460.0) == "460\N{NARROW NO-BREAK SPACE}U/min"
    assert shown.angle(-20.0) == "340°"
    assert shown.angle(359.9) == "0°"
    assert shown.mass(None) == "\N{EM DASH}"
    assert Display(INCHES).mass(28.349523125) == "1\N{NARROW NO-BREAK SPACE}oz"
