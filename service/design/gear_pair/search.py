"""Best gear pairs by enumeration: a proof for the sound model, exact roots for the printed one."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from service.design.gear_pair.case import GearCase
from service.mechanics.bodies import FloatArray
from service.mechanics.gears import SLENDER, STOUT, as_printed, dynamic_factor, least_width, pair, printed_loads
from service.mechanics.kinematics import BoolArray

DISTANCE_SCALE = 100.0
"""Centre distance in mm that weighs as much as a kg of mass."""
MODULE_GRID = 4001
INSIDE = 1e-12
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
Width = Callable[[FloatArray], FloatArray]


def aimed(case: GearCase, module: FloatArray, width: FloatArray, teeth: FloatArray) -> FloatArray:
    """The weighted objective (...) of the sound model."""
    one = pair(case.duty, module, width, teeth)
    return case.weight * one.mass + (1.0 - case.weight) * one.distance / DISTANCE_SCALE


def candidates(case: GearCase) -> tuple[FloatArray, BoolArray]:
    """Every module with every number of teeth, (k, 3) of module, least width and teeth, and whether each is feasible.

    Mass rises with the width and nothing else depends on it, so that the least width that carries the load is best.
    """
    module, teeth = (grid.ravel() for grid in np.meshgrid(case.modules, case.teeth_choices, indexing="ij"))
    needed = least_width(case.duty, module, teeth) * (1.0 + INSIDE)
    width = np.maximum(np.maximum(needed, SLENDER * module), case.widths[0])
    feasible = width <= np.minimum(STOUT * module, case.widths[1])
    return np.stack([module, width, teeth], axis=1), feasible


def best_sound(case: GearCase) -> tuple[FloatArray, float] | None:
    """The best pair (3,) and its objective, proved by trying all; None where no pair is feasible."""
    found, feasible = candidates(case)
    if not feasible.any():
        return None
    found = found[feasible]
    values = aimed(case, *found.T)
    best = int(values.argmin())
    return found[best], float(values[best])


def best_printed(case: GearCase) -> tuple[FloatArray, float]:
    """The best (3,) of the printed objective and its value.

    For a module and teeth it is piecewise linear in the width, so that the best width is a bound or a kink; along each
    of these branches the module is searched on a grid and refined.
    """
    low, high = float(case.modules[0]), float(case.modules[-1])
    grid = np.linspace(low, high, MODULE_GRID)
    best: tuple[float, FloatArray] | None = None
    for teeth in case.teeth_choices.tolist():
        for width in _branches(case, teeth):

            def value(module: FloatArray, width: Width = width, teeth: float = teeth) -> FloatArray:
                z = np.full_like(module, teeth)
                return as_printed(case.duty, module, width(module), z, case.weight).value

            for module in _refined(value, grid):
                now = float(value(np.array([module]))[0])
                if best is None or now < best[0]:
                    best = (now, np.array([module, float(width(np.array([module]))[0]), teeth]))
    assert best is not None  # noqa: S101  there is at least one number of teeth
    return best[1], best[0]


def _branches(case: GearCase, teeth: float) -> list[Width]:
    """Widths as functions of the module: the bounds, and where a penalty begins."""
    bending, contact = printed_loads(case.duty)
    form = 0.48356 * teeth - 2.86368
    low, high = case.widths

    def kink(load: float, factor: float) -> Width:
        def width(module: FloatArray) -> FloatArray:
            velocity = 3.14 * module * teeth * case.duty.revolutions / 60.0
            dynamic = dynamic_factor(case.duty.cut, velocity, printed=True)
            return np.clip(load * dynamic * factor / (module * teeth) ** 2, low, high)

        return width

    return [
        lambda m: np.full_like(m, low),
        lambda m: np.full_like(m, high),
        lambda m: np.clip(SLENDER * m, low, high),
        lambda m: np.clip(STOUT * m, low, high),
        kink(bending, form),
        kink(contact, 1.0),
    ]


def _refined(value: Callable[[FloatArray], FloatArray], grid: FloatArray) -> list[float]:
    """Modules of the lowest local minima on a grid, refined between their neighbours."""
    values = value(grid)
    padded = np.concatenate([[np.inf], values, [np.inf]])
    low = np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]))
    found = [float(grid[0]), float(grid[-1])]
    for k in low[np.argsort(values[low])][:4]:
        a, b = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
        found.append(_golden(lambda m: float(value(np.array([m]))[0]), float(a), float(b)))
    return found


def _golden(value: Callable[[float], float], low: float, high: float) -> float:
    """Place of the least value between low and high, to the last digits: minima here are most often kinks."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = value(left), value(right)
    while right - left > 1e-16 * max(abs(left), abs(right)):
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = value(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = value(right)
    return left if at_left <= at_right else right
