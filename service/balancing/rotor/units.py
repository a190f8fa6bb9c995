"""Quantities, units and detections of vibration, and the turn of phase between them.

In lag notation the vector X = a exp(j phi) stands for a cos(w t - phi) = Re(conj(X) exp(j w t)), so differentiating
multiplies it by -j w: velocity leads displacement by 90 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.errors import NumericsError
from service.messages import Message, Word

Quantity = Literal["displacement", "velocity", "acceleration"]
Detection = Literal["rms", "peak", "peak_to_peak"]

_ORDER: dict[str, int] = {"displacement": 0, "velocity": 1, "acceleration": 2}
_SI: dict[str, dict[str, float]] = {
    "displacement": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "in": 0.0254, "mil": 0.0254e-3},
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "in/s": 0.0254, "ips": 0.0254},
    "acceleration": {"m/s2": 1.0, "mm/s2": 1e-3, "g": 9.80665},
}
_PER_PEAK: dict[str, float] = {"peak": 1.0, "rms": 1.0 / math.sqrt(2.0), "peak_to_peak": 2.0}

T = TypeVar("T", float, FloatArray)


@dataclass(frozen=True)
class Scale:
    """What the number of a vibration means. Raises NumericsError for a unit that does not belong to the quantity."""

    quantity: Quantity = "velocity"
    unit: str = "mm/s"
    detection: Detection = "rms"

    def __post_init__(self) -> None:
        if self.quantity not in _SI:
            raise _unknown("quantity", self.quantity, _SI)
        if self.unit not in _SI[self.quantity]:
            raise NumericsError(
                Message(
                    "numerics.unit_of_quantity", quantity=Word(self.quantity), value=self.unit, known=_SI[self.quantity]
                ),
                field="unit",
                value=self.unit,
            )
        if self.detection not in _PER_PEAK:
            raise _unknown("detection", self.detection, _PER_PEAK)

    @property
    def in_si_peak(self) -> float:
        """SI peak value of an amplitude of 1."""
        return _SI[self.quantity][self.unit] / _PER_PEAK[self.detection]


def is_unit_of(quantity: Quantity, unit: str) -> bool:
    """Whether a vibration of this quantity may be stated in this unit."""
    return unit in _SI[quantity]


def angular_speed(speed_rpm: float) -> float:
    """Radians per second of a speed in r/min; raises NumericsError unless it is finite and positive."""
    if not (math.isfinite(speed_rpm) and speed_rpm > 0.0):
        raise NumericsError(Message("numerics.speed_of_run", speed=speed_rpm), field="speed_rpm", value=str(speed_rpm))
    return speed_rpm * math.pi / 30.0


def factor(source: Scale, target: Scale, speed_rpm: float | None = None) -> complex:
    """Compute the number by which an internal (lag) 1x vector of `source` is multiplied to read in `target`.

    speed_rpm is needed, and used, only where the quantity changes.
    """
    real = source.in_si_peak / target.in_si_peak
    steps = _ORDER[target.quantity] - _ORDER[source.quantity]
    if steps == 0:
        return complex(real)
    if speed_rpm is None:
        raise NumericsError(
            Message("numerics.speed_missing", quantity=source.quantity, wanted=target.quantity), field="speed_rpm"
        )
    # Powers of -j are written out: the quarter turns stay exact.
    turn = (1.0 + 0j, -1j, -1.0 + 0j, 1j)[steps % 4]
    return turn * (real * angular_speed(speed_rpm) ** steps)


def convert(vector: ComplexArray, source: Scale, target: Scale, speed_rpm: float | None = None) -> ComplexArray:
    """Convert internal (lag) 1x vectors of any shape, from `source` to `target`; the phase turns with the quantity."""
    return np.asarray(vector * factor(source, target, speed_rpm))


def convert_amplitude(amplitude: T, source: Scale, target: Scale, speed_rpm: float | None = None) -> T:
    """Amplitudes, limits or scatters, from `source` to `target`: for example 2.8 mm/s rms to a sensor's own scale."""
    return amplitude * abs(factor(source, target, speed_rpm))


def _unknown(
    what: str, value: str, known: dict[str, object] | dict[str, float] | dict[str, dict[str, float]]
) -> NumericsError:
    return NumericsError(
        Message("numerics.unit_unknown", what=Word(what), value=value, known=known), field=what, value=value
    )
