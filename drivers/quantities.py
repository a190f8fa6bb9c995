"""Quantities of vibration, their units and detections."""

from __future__ import annotations

import math
from typing import Literal

Quantity = Literal["displacement", "velocity", "acceleration"]
Detection = Literal["rms", "peak", "peak_to_peak"]

STANDARD_GRAVITY = 9.80665
PER_UNIT: dict[str, dict[str, float]] = {
    "displacement": {"um": 1e-6, "mm": 1e-3, "mil": 25.4e-6},
    "velocity": {"mm/s": 1e-3, "in/s": 25.4e-3},
    "acceleration": {"m/s2": 1.0, "g": STANDARD_GRAVITY},
}
"""One unit of each quantity in m, m/s, m/s2."""
PER_PEAK: dict[str, float] = {"rms": math.sqrt(0.5), "peak": 1.0, "peak_to_peak": 2.0}
"""What a sine of peak 1 reads under each detection."""
