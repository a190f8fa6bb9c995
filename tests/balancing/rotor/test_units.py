"""Scales of vibration: factors, and the quarter turn between quantities."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.rotor.phasors import FloatArray
from service.balancing.rotor.units import Detection, Scale, angular_speed, convert, convert_amplitude, factor
from service.errors import NumericsError

SCALES = [Scale("displacement", unit, d) for unit in ("m", "mm", "um", "in", "mil") for d in get_args(Detection)] + [
    Scale("velocity", "ips", "peak"),
    Scale(),
    Scale("acceleration", "g", "rms"),
    Scale("acceleration", "m/s2", "peak"),
]
RPM = 3000.0


def peak_after_mark(waveform: FloatArray) -> float:
    """Degrees from the mark (start of the turn) to the positive peak."""
    return float(np.argmax(waveform)) * 360.0 / len(waveform)


def test_the_phase_of_a_differentiated_waveform_turns_as_the_vector_does() -> None:
    w = angular_speed(RPM)
    t = np.linspace(0.0, 2.0 * math.pi / w, 36_000, endpoint=False)
    lag = math.radians(200.0)
    velocity = np.gradient(30e-6 * np.cos(w * t - lag), t)
    vector = convert(
        np.array([30.0 * np.exp(1j * lag)]), Scale("displacement", "um", "peak"), Scale("velocity", "mm/s", "rms"), RPM
    )[0]
    assert math.degrees(np.angle(vector)) % 360.0 == pytest.approx(peak_after_mark(velocity), abs=0.05)
    assert abs(vector) == pytest.approx(1e3 * velocity.max() / math.sqrt(2.0), rel=1e-5)


def test_known_numbers() -> None:
    assert convert_amplitude(
        1.0, Scale("displacement", "mil", "peak_to_peak"), Scale("displacement", "um", "peak")
    ) == pytest.approx(12.7)
    assert convert_amplitude(1.0, Scale("velocity", "ips", "peak"), Scale()) == pytest.approx(25.4 / math.sqrt(2.0))
    # 1 g peak at 3000 r/min: 9.80665 / 314.159 m/s.
    assert convert_amplitude(
        1.0, Scale("acceleration", "g", "peak"), Scale("velocity", "mm/s", "peak"), RPM
    ) == pytest.approx(31.2155, rel=1e-5)


@given(st.sampled_from(SCALES), st.sampled_from(SCALES), st.floats(10.0, 50_000.0))
def test_round_trips_and_chains(source: Scale, target: Scale, rpm: float) -> None:
    assert factor(source, target, rpm) * factor(target, source, rpm) == pytest.approx(1.0)
    middle = Scale()
    assert factor(source, middle, rpm) * factor(middle, target, rpm) == pytest.approx(factor(source, target, rpm))


def test_a_quantity_changes_only_at_a_known_speed() -> None:
    assert factor(Scale(), Scale("velocity", "ips", "peak")).imag == 0.0
    with pytest.raises(NumericsError, match="known speed"):
        factor(Scale(), Scale("displacement", "um", "peak"))


@pytest.mark.parametrize("speed", [0.0, -5.0, math.nan, math.inf])
def test_a_speed_is_positive(speed: float) -> None:
    with pytest.raises(NumericsError, match="speed must be"):
        angular_speed(speed)


@pytest.mark.parametrize(
    ("quantity", "unit", "detection", "message"),
    [
        ("velocity", "um", "rms", 'the unit of velocity must be one of m/s, mm/s, in/s or ips, got "um"'),
        ("jerk", "um", "rms", 'the quantity must be one of displacement, velocity or acceleration, got "jerk"'),
        ("velocity", "mm/s", "mean", 'the detection must be one of peak, rms or peak_to_peak, got "mean"'),
    ],
)
def test_unknown_words_are_refused_with_the_known_ones(quantity: str, unit: str, detection: str, message: str) -> None:
    with pytest.raises(NumericsError, match=message) as caught:
        Scale(quantity, unit, detection)  # type: ignore[arg-type]
    assert "use one of" in str(caught.value.advice)
