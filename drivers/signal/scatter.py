"""Standard deviation of the 1x vector of a block, from sub-blocks.

The block is cut into sub-blocks of whole turns; each gives a vector of its own under a Hann taper. Their standard
deviation, times the root of the ratio of effective samples (sum w)^2 / sum w^2 of a sub-block and of the block, is that
of the block's vector where the disturbance is broadband. A tone near the 1x component leaks more into the short
sub-blocks than into the block: the chain takes out the strongest one before; what is left errs on the safe side.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from drivers.signal.block import Floats, dot
from drivers.signal.orders import Complexes, Course, fit_orders
from drivers.signal.windows import taper

TURNS_PER_SUBBLOCK = 4
MAX_SUBBLOCKS = 16
WITH_TREND = 4
"""Sub-blocks from which on the part of the vector that follows the speed is taken out: the reading states its speed."""


def scatter_of(course: Course, basis: Floats, values: Floats, weights: Floats) -> float | None:
    """Standard deviation per real component of the 1x vector, peak, in the unit of values (n,).

    weights (n,): those of the block's own estimate; samples of weight 0 that the taper does not explain are left out.
    None below 8 turns, where no two sub-blocks fit.
    """
    parts = min(MAX_SUBBLOCKS, course.turns // TURNS_PER_SUBBLOCK)
    if parts < 2:
        return None
    borders = np.round(np.linspace(0, course.turns, parts + 1)) * math.tau
    starts = np.searchsorted(course.angle, borders)
    vectors, speeds, sizes = [], [], []
    for part, (first, last) in enumerate(itertools.pairwise(starts)):
        piece = slice(first, last)
        length = borders[part + 1] - borders[part]
        w = taper("hann", (course.angle[piece] - borders[part]) / length) * (weights[piece] > 0.0)
        try:
            vectors.append(fit_orders(basis[:, piece], w, values[piece])[0][0])
        except np.linalg.LinAlgError:
            continue  # all of its samples are lost
        speeds.append(dot(w, course.speed[piece]) / float(w.sum()))
        sizes.append(float(w.sum()) ** 2 / dot(w, w))
    if len(vectors) < 2:
        return None
    deviation = _deviation(np.array(vectors), np.array(speeds))
    return deviation * math.sqrt(float(np.mean(sizes)) * dot(weights, weights)) / float(weights.sum())


def _deviation(vectors: Complexes, speeds: Floats) -> float:
    """Standard deviation per real component about the mean, or about a straight line over the speed."""
    columns = [np.ones_like(speeds)]
    if len(vectors) >= WITH_TREND and np.ptp(speeds) > 0.0:
        columns.append((speeds - speeds.mean()) / np.ptp(speeds))
    model = np.stack(columns, axis=1)
    found = np.linalg.lstsq(model, vectors, rcond=None)[0]
    rest = vectors - model @ found
    return math.sqrt(float(np.sum(np.abs(rest) ** 2)) / (2.0 * (len(vectors) - len(columns))))
