"""The tapers themselves, against their published form and side lobes (Harris 1978, table 1)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.signal.windows import Window, half_width, taper


@pytest.mark.parametrize(
    ("window", "side_lobe_db"), [("rectangular", -13.0), ("hann", -31.0), ("blackman_harris", -92.0)]
)
def test_side_lobes(window: Window, side_lobe_db: float) -> None:
    n = 1000
    weights = taper(window, (np.arange(n) + 0.5) / n)
    lines = np.abs(np.fft.rfft(weights, 16 * n)) / weights.sum()
    beyond = lines[16 * half_width(window) :]
    assert 20.0 * math.log10(float(beyond.max())) == pytest.approx(side_lobe_db, abs=0.6)


def test_the_cosines() -> None:
    place = np.linspace(0.0, 1.0, 101)
    angle = math.tau * place
    expected = 0.35875 - 0.48829 * np.cos(angle) + 0.14128 * np.cos(2.0 * angle) - 0.01168 * np.cos(3.0 * angle)
    assert np.abs(taper("blackman_harris", place) - expected).max() <= 1e-12
