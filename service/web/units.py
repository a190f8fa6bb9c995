"""Units of the reader: stored numbers in g, mm and each sensor's own unit are shown, and typed, in others.

A number that is typed with a unit of its own, such as 12 oz, is meant in that unit, whatever the field's is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from service.balancing.rotor.units import Detection, Scale, convert_amplitude
from service.model.machine import Sensor
from service.model.machine import Unit as SensorUnit
from service.web.preferences import Preferences

G_PER_OZ = 28.349523125
MM_PER_IN = 25.4
DETECTIONS = {"rms": "rms", "peak": "pk", "peak_to_peak": "pk-pk"}


@dataclass(frozen=True)
class Unit:
    """A unit of the reader: its sign, and how many of the stored unit one of it is.

    others: signs that may be typed behind a number instead, each with its size, so too.
    """

    sign: str
    size: float
    others: tuple[tuple[str, float], ...] = field(default=(), compare=False, repr=False)

    def show(self, stored: float) -> float:
        """A stored number in this unit."""
        return stored / self.size

    def store(self, typed: float) -> float:
        """A typed number in the stored unit."""
        return typed * self.size

    def size_of(self, sign: str) -> float | None:
        """Size of a unit that was typed behind a number; None where it is not of this kind."""
        known = {_plain(one): size for one, size in (*self.others, (self.sign, self.size))}
        return known.get(_plain(sign))


def _plain(sign: str) -> str:
    """A sign as it may be typed: small letters, u for micro, 2 for square, one space."""
    return " ".join(sign.casefold().translate(_AS_TYPED).split())


_AS_TYPED = str.maketrans({"\N{GREEK SMALL LETTER MU}": "u", "\N{MICRO SIGN}": "u", "²": "2", "″": '"'})
_MASSES = (("g", 1.0), ("kg", 1000.0), ("oz", G_PER_OZ), ("lb", 16.0 * G_PER_OZ))
_LENGTHS = (("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", MM_PER_IN), ('"', MM_PER_IN), ("ft", 12.0 * MM_PER_IN))
_OF_QUANTITY: dict[str, tuple[SensorUnit, ...]] = {
    "velocity": ("mm/s", "in/s"),
    "displacement": ("um", "mm", "mil"),
    "acceleration": ("m/s2", "g"),
}
DEGREES = Unit("°", 1.0, (("deg", 1.0), ("grad", 1.0)))
TURNS = Unit("r/min", 1.0, (("rpm", 1.0), ("1/min", 1.0), ("U/min", 1.0), ("min-1", 1.0), ("Hz", 60.0)))
"""Speeds, stored in r/min."""
KILOGRAMS = Unit("kg", 1.0, (("t", 1000.0), ("g", 0.001), ("lb", 16e-3 * G_PER_OZ)))
"""The mass of a rotor."""
NEWTONS = Unit("N", 1.0, (("kN", 1000.0), ("lbf", 16e-3 * G_PER_OZ * 9.80665)))


def mass(preferences: Preferences) -> Unit:
    """Masses, stored in g."""
    return Unit("oz", G_PER_OZ, _MASSES) if preferences.mass == "oz" else Unit("g", 1.0, _MASSES)


def length(preferences: Preferences) -> Unit:
    """Radii and axial positions, stored in mm."""
    return Unit("in", MM_PER_IN, _LENGTHS) if preferences.length == "in" else Unit("mm", 1.0, _LENGTHS)


def unbalance(preferences: Preferences) -> Unit:
    """Mass times radius, stored in g.mm."""
    grams, along = mass(preferences), length(preferences)
    return Unit(f"{grams.sign}\N{MIDDLE DOT}{along.sign}", grams.size * along.size)


def amplitude(sensor: Sensor, preferences: Preferences) -> Unit:
    """Amplitudes of a sensor, stored in its own unit and detection.

    The quantity stays the sensor's: only a speed would tell what else a number is.
    """
    own = Scale(sensor.quantity, sensor.unit, sensor.detection)
    unit = sensor.unit
    if sensor.quantity == "velocity":
        unit = preferences.velocity  # type: ignore[assignment]
    elif sensor.quantity == "displacement" and preferences.length == "in":
        unit = "mil"
    elif sensor.quantity == "displacement" and unit == "mil":
        unit = "um"
    detection: Detection = sensor.detection if preferences.detection == "sensor" else preferences.detection  # type: ignore[assignment]
    shown = Scale(sensor.quantity, unit, detection)
    sign, size = f"{unit.replace('um', 'µm')} {DETECTIONS[detection]}", convert_amplitude(1.0, shown, own)
    return Unit(sign, size, tuple(_amplitudes(own, detection)))


def _amplitudes(own: Scale, detection: Detection) -> Iterator[tuple[str, float]]:
    """Units in which an amplitude may be typed: without a detection the shown one is meant."""
    for unit in _OF_QUANTITY[own.quantity]:
        yield unit, convert_amplitude(1.0, Scale(own.quantity, unit, detection), own)
        for name, sign in DETECTIONS.items():
            yield f"{unit} {sign}", convert_amplitude(1.0, Scale(own.quantity, unit, name), own)  # type: ignore[arg-type]
