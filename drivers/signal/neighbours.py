"""Detect a tone of another machine near the 1x component."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drivers.signal.block import Floats
from drivers.signal.orders import Course, normal_equations

FAR = 0.5
"""Orders to each side of 1x that are looked at."""
ABOVE_FLOOR = 5.0
"""Times the median of the spectrum that a tone must stand out."""
PER_PERIOD = 16
"""Samples in a period that are enough to see such a tone."""
PADDING = 4


@dataclass(frozen=True, slots=True)
class Neighbour:
    """The strongest tone within half an order of 1x: its order, and its amplitude, peak, in the unit of the values."""

    order: float
    amplitude: float


def neighbour_of(course: Course, rest: Floats, weights: Floats) -> tuple[Neighbour, Floats] | None:
    """Look for a tone of constant frequency in the rest (n,) that the orders leave; None where nothing stands out.

    The rest is averaged over pieces of a sixteenth of a turn and its Hann-tapered spectrum taken; between the lines the
    peak is that of a parabola through the logarithms of the three greatest. Returns the tone, its size fitted under
    weights (n,), and its samples (n,).
    """
    step = max(1, len(rest) // (PER_PERIOD * course.turns))
    count = len(rest) // step
    thin = rest[: count * step].reshape(count, step).mean(axis=1)
    window = 0.5 - 0.5 * np.cos(math.tau * (np.arange(count) + 0.5) / count)
    lines = np.abs(np.fft.rfft(thin * window, PADDING * count)) * 2.0 / window.sum()
    per_order = PADDING * course.turns * count * step / len(rest)  # lines from one order to the next
    first, last = math.ceil((1.0 - FAR) * per_order), math.floor((1.0 + FAR) * per_order)
    near = lines[first : last + 1]
    one_x = np.abs(np.arange(first, last + 1) - per_order) < PADDING  # the fit has taken its own line out
    floor = float(np.median(near[~one_x])) if near.size > 2 * PADDING else math.inf
    best = first + int(np.argmax(np.where(one_x, 0.0, near)))
    if not lines[best] > ABOVE_FLOOR * floor:
        return None
    order = _peak(lines, best) / per_order
    amplitude, samples = _fitted(course, rest, weights, order)
    return Neighbour(order, amplitude), samples


def _fitted(course: Course, rest: Floats, weights: Floats, order: float) -> tuple[float, Floats]:
    """Size and samples (n,) of the tone: cosine and sine of its frequency, each with a straight trend."""
    angle = math.tau * order * course.turns * np.linspace(0.0, 1.0, len(rest))
    even, odd = np.cos(angle), np.sin(angle)
    trend = 2.0 * course.place - 1.0
    columns = np.stack([even, odd, trend * even, trend * odd])
    found = np.linalg.solve(*normal_equations(columns, weights, rest))
    return math.hypot(found[0], found[1]), np.asarray(np.einsum("k,kn->n", found, columns), float)


def _peak(lines: Floats, best: int) -> float:
    """Place of the peak at line `best`."""
    if not 0 < best < len(lines) - 1 or lines[best - 1 : best + 2].min() <= 0.0:
        return float(best)
    left, middle, right = np.log(lines[best - 1 : best + 2])
    bend = left - 2.0 * middle + right
    shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0
    return best + float(shift)
