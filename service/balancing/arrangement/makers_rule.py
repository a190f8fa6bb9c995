"""What makers' manuals ask for: the heaviest parts opposite each other."""

from __future__ import annotations

import numpy as np

from service.balancing.rotor.phasors import FloatArray, IntArray


def opposite_pairs(masses_g: FloatArray) -> IntArray | None:
    """Part of each of N places, (N,), for masses (N,); None for an odd number.

    The parts sorted by mass, neighbours in rank paired: the heaviest pair goes on places 1 and 1 + N/2, the next on 2
    and 2 + N/2 and so on. Of equal masses the first comes first.
    """
    count = len(masses_g)
    if count % 2 or not count:
        return None
    ranked = np.argsort(-np.asarray(masses_g), kind="stable")
    places = np.empty(count, dtype=np.int64)
    places[: count // 2], places[count // 2 :] = ranked[::2], ranked[1::2]
    return places
