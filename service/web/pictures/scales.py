"""Round numbers for rings, ticks and full scales."""

from __future__ import annotations

import math

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


def ticks(highest: float, most: int = 5) -> tuple[float, ...]:
    """Round values from one step to at least `highest`, `most` at most; (1,) where nothing is above 0."""
    if not (math.isfinite(highest) and highest > 0.0):
        return (1.0,)
    decade = 10.0 ** math.floor(math.log10(highest / most))
    step = next(s * decade for s in _STEPS if s * decade * most >= highest * (1.0 - 1e-9))
    return tuple(step * (i + 1) for i in range(math.ceil(highest / step * (1.0 - 1e-9))))
