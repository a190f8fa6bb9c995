"""A lower bound from the relaxed problem: parts may be split among the places.

For a direction w no arrangement has a smaller <w, r> than the cheapest matching of parts and places, and no residual r
a smaller norm than <w, r> / (dual norm of w). Directions come from the point nearest to 0 of all mixtures of
arrangements, approached by conditional gradients (Frank and Wolfe 1956), each step one matching.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from service.balancing.arrangement.exact.region import Support, as_real, dual_norm
from service.balancing.arrangement.exact.slots import Slots
from service.balancing.rotor.phasors import IntArray

STEPS = 25
"""Matchings: enough to tell a drum that the parts cannot balance from one that they can."""
ROUNDING = 1e-9
"""Part of the largest effect that a bound is lowered by: sums of it are rounded."""


@dataclass(frozen=True)
class Bound:
    """`value` is below every arrangement's objective; support: the direction that shows it, None where it is 0."""

    value: float
    support: Support | None
    matchings: tuple[IntArray, ...]


def relaxed_bound(slots: Slots, steps: int = STEPS) -> Bound:
    """Lower bound of a problem, with the matchings (M,) that were met on the way."""
    index = np.arange(slots.size)
    effects = as_real(slots.effects)
    offset = as_real(slots.offset)
    forbidden = float(np.abs(effects).sum(axis=2).max(initial=0.0)) * 4.0 * (slots.size + 1) + 1.0
    slack = ROUNDING * (float(np.abs(effects).max(initial=0.0)) + float(np.abs(offset).max(initial=0.0)))
    point = offset + effects[slots.base, index].sum(axis=0)
    best, support = 0.0, None
    met: list[IntArray] = []
    for _ in range(steps):
        length = float(np.linalg.norm(point))
        if length <= slack:
            break
        direction = point / length
        cost = np.where(slots.allowed, effects @ direction, forbidden)
        rows, columns = linear_sum_assignment(cost)
        matching = np.empty(slots.size, dtype=np.int64)
        matching[columns] = rows
        met.append(matching)
        vertex = offset + effects[matching, index].sum(axis=0)
        least = float(direction @ vertex) - slack
        value = least / float(dual_norm(slots.norm, direction))
        if support is None or least > support.least:
            support = Support(direction, least)
        best = max(best, value)
        step = vertex - point
        square = float(step @ step)
        if square <= 0.0 or length - least <= 1e-6 * length:
            break
        point = point + min(max(-float(point @ step) / square, 0.0), 1.0) * step
    return Bound(best, support if support is not None and support.least > 0.0 else None, tuple(met))
