"""Sensor model: amplitude in the sensor's unit, phase as the rotor turns.

A sensor's signal is x(t) = Re(p exp(j w t)) in its quantity; its positive peak comes when w t = -arg p. The mark passes
the pick-up, which stands at its own angle k in the frame, when s w t = k. The lag is what the rotor turns from the one
to the other; the lead is its negative.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from drivers.checks import require, require_finite
from drivers.quantities import PER_PEAK, PER_UNIT, Detection, Quantity
from drivers.simulator.rotor import Motion


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor fixed in space at axial_mm from the mass centre, sensing towards direction_deg (ccw from x).

    axial_arm_mm: of a sensor that senses along the axis instead, its distance from it towards direction_deg. noise:
    standard deviation of the reported 1x vector per real component, in the reported unit and detection.
    broadband_rms: what the sensor sees besides the 1x component, rms in the unit; part of the overall value only.
    """

    name: str
    axial_mm: float
    direction_deg: float = 0.0
    quantity: Quantity = "velocity"
    unit: str = "mm/s"
    detection: Detection = "rms"
    noise: float = 0.0
    broadband_rms: float = 0.0
    axial_arm_mm: float | None = None

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.quantity in PER_UNIT, f"quantity {self.quantity!r}", f"be one of {', '.join(PER_UNIT)}")
        units = PER_UNIT[self.quantity]
        require(self.unit in units, f"unit {self.unit!r} of {self.quantity}", f"be one of {', '.join(units)}")
        require(self.detection in PER_PEAK, f"detection {self.detection!r}", f"be one of {', '.join(PER_PEAK)}")
        require(self.noise >= 0.0, f"noise {self.noise} of sensor {self.name!r}", "be >= 0")
        require(self.broadband_rms >= 0.0, f"broadband_rms {self.broadband_rms} of {self.name!r}", "be >= 0")


def displacement(sensor: Sensor, motion: Motion) -> complex:
    """Phasor of the displacement that the sensor feels, m, peak."""
    if sensor.axial_arm_mm is None:
        return motion.displacement(sensor.axial_mm, sensor.direction_deg)
    return motion.along_axis(sensor.axial_arm_mm, sensor.direction_deg)


def sense(sensor: Sensor, motion: Motion) -> complex:
    """Phasor of the sensor's 1x signal: its modulus is the amplitude in the sensor's unit and detection."""
    order = {"displacement": 0, "velocity": 1, "acceleration": 2}[sensor.quantity]
    derivative = (1j * motion.omega) ** order
    si = derivative * displacement(sensor, motion)
    return si / PER_UNIT[sensor.quantity][sensor.unit] * PER_PEAK[sensor.detection]


def lag_degrees(phasor: complex, spin: int, pickup_deg: float) -> float:
    """Degrees the rotor turns from the mark passing the pick-up to the next positive peak, 0 <= lag < 360."""
    turned_at_peak = -math.degrees(cmath.phase(phasor))
    turned_at_mark = spin * pickup_deg
    lag = (turned_at_peak - turned_at_mark) % 360.0
    return 0.0 if lag >= 360.0 else lag


def overall_rms(sensor: Sensor, amplitude: float) -> float:
    """Broadband rms of the quantity in the sensor's unit: the 1x component of this amplitude and all else beside it."""
    one_x = amplitude / PER_PEAK[sensor.detection] * PER_PEAK["rms"]
    return math.hypot(one_x, sensor.broadband_rms)
