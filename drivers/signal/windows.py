"""Tapers: what a tone at another frequency can leak into an estimate.

Rejection beyond the main lobe, by highest side lobe: rectangular -13 dB, hann -31 dB (falling by 18 dB an octave),
blackman_harris -92 dB. Half width of the main lobe in 1 / (turns of the block), as an order: 1, 2, 4.

F. J. Harris, On the use of windows for harmonic analysis with the discrete Fourier transform, Proc. IEEE 66 (1978)
51-83, table 1.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from drivers.checks import require
from drivers.signal.block import Floats

Window = Literal["rectangular", "hann", "blackman_harris"]
COSINES: dict[Window, tuple[float, ...]] = {
    "rectangular": (1.0,),
    "hann": (0.5, 0.5),
    "blackman_harris": (0.35875, 0.48829, 0.14128, 0.01168),
}
"""Coefficients of the cosines, with alternating signs."""


def taper(window: Window, place: Floats) -> Floats:
    """Weights (n,) at places (n,) within the block, from 0 at its start to 1 at its end."""
    require(window in COSINES, f"window {window!r}", f"be one of {', '.join(COSINES)}")
    cosine = -np.cos(math.tau * place)
    out = np.full_like(place, COSINES[window][0])
    before, now = np.ones_like(place), cosine
    for size in COSINES[window][1:]:  # (-1)^k cos(2 pi k u), each from the two before: Chebyshev's recurrence
        out += size * now
        before, now = now, 2.0 * cosine * now - before
    return out


def half_width(window: Window) -> int:
    """Half width of the main lobe, in orders times the turns of the block."""
    return len(COSINES[window])
