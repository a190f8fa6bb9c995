"""Overall rms of a quantity in a band."""

from __future__ import annotations

import math

import numpy as np

from drivers.signal.block import Floats, dot

SLOW_RPM = 600.0
LOW_HZ, SLOW_LOW_HZ, HIGH_HZ = 10.0, 2.0, 1000.0
"""Band of machine vibration, 10 Hz to 1000 Hz, from 2 Hz for speeds below 600 r/min (ISO 20816-1, ISO 20816-3)."""


def usual_band(speed_rpm: float, sample_rate_hz: float) -> tuple[float, float]:
    """Band, Hz, of the standards; its lower end at most half the speed, its upper end within what was sampled."""
    low = SLOW_LOW_HZ if speed_rpm < SLOW_RPM else LOW_HZ
    return min(low, speed_rpm / 120.0), min(HIGH_HZ, 0.45 * sample_rate_hz)


def band_rms(samples: Floats, sample_rate_hz: float, band_hz: tuple[float, float], power: int) -> float:
    """Rms within band_hz of samples (n,) differentiated `power` times (negative: integrated), in SI per second^power.

    By Parseval's theorem on the Hann-tapered spectrum, the mean and the straight trend taken out first. The taper gives
    the middle of the block more say than its ends.
    """
    n = len(samples)
    place = np.linspace(-1.0, 1.0, n)
    level = samples - samples.mean()
    level = level - place * dot(place, level) / dot(place, place)
    window = 0.5 - 0.5 * np.cos(math.tau * (np.arange(n) + 0.5) / n)
    length = _quick_length(n)
    spectrum = np.fft.rfft(level * window, length)
    frequency = np.fft.rfftfreq(length, 1.0 / sample_rate_hz)
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    sizes = np.abs(spectrum[inside]) * (math.tau * frequency[inside]) ** power
    return math.sqrt(2.0 * dot(sizes, sizes) / length / dot(window, window))


def _quick_length(n: int) -> int:
    """Shortest length of the form (1, 3, 5, 9 or 15) 2^k that is not below n: the transform of a prime one is slow."""
    return min(odd << max(0, math.ceil(math.log2(n / odd))) for odd in (1, 3, 5, 9, 15))
