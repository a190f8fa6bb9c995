"""Units of the reader: stored numbers in g, mm and each sensor's own unit are shown, and typed, in others."""

from __future__ import annotations

from dataclasses import dataclass

from db.documents.machine import Sensor
from service.balancing.units import Detection, Scale, convert_amplitude
from service.web.preferences import Preferences

G_PER_OZ = 28.349523125
MM_PER_IN = 25.4
DETECTIONS = {"rms": "rms", "peak": "pk", "peak_to_peak": "pk-pk"}


@dataclass(frozen=True)
class Unit:
    """A unit of the reader: its sign, and how many of the stored unit one of it is."""

    sign: str
    size: float

    def show(self, stored: float) -> float:
        """A stored number in this unit."""
        return stored / self.size

    def store(self, typed: float) -> float:
        """A typed number in the stored unit."""
        return typed * self.size


def mass(preferences: Preferences) -> Unit:
    """Masses, stored in g."""
    return Unit("oz", G_PER_OZ) if preferences.mass == "oz" else Unit("g", 1.0)


def length(preferences: Preferences) -> Unit:
    """Radii and axial positions, stored in mm."""
    return Unit("in", MM_PER_IN) if preferences.length == "in" else Unit("mm", 1.0)


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
    return Unit(f"{unit.replace('um', 'µm')} {DETECTIONS[detection]}", convert_amplitude(1.0, shown, own))
