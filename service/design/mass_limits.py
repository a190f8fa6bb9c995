"""Limits on the mass numbers q = (m, m x, m y, J) of one link: scaled g(q) <= 0 with slopes, and as stated.

Upper limits on radius and lower ones on inertia are written over the mass, so that they are convex in q.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from service.design.study import LimitCheck, Sense, limit_check
from service.mechanics.bodies import Body, FloatArray

Kind = Literal[
    "mass_min", "mass_max", "centre_radius_min", "centre_radius_max", "inertia_origin_max", "inertia_centre_min"
]
_STATED: dict[Kind, tuple[Sense, str]] = {
    "mass_min": ("at_least", "mass"),
    "mass_max": ("at_most", "mass"),
    "centre_radius_min": ("at_least", "length"),
    "centre_radius_max": ("at_most", "length"),
    "inertia_origin_max": ("at_most", "inertia"),
    "inertia_centre_min": ("at_least", "inertia"),
}
CONVEX: frozenset[Kind] = frozenset(_STATED) - {"centre_radius_min"}


@dataclass(frozen=True)
class MassLimit:
    """A limit of link number `link`, in SI; mass and inertia: of the link as it is, for scaling."""

    kind: Kind
    link: int
    bound: float
    mass: float
    inertia: float

    def scaled(self, q: FloatArray) -> FloatArray:
        """The constraint g (...) for mass numbers q (..., 4)."""
        m, moment2 = q[..., 0], q[..., 1] ** 2 + q[..., 2] ** 2
        if self.kind == "mass_min":
            return np.asarray(1.0 - m / self.bound)
        if self.kind == "mass_max":
            return np.asarray(m / self.bound - 1.0)
        if self.kind == "inertia_origin_max":
            return np.asarray(q[..., 3] / self.bound - 1.0)
        if self.kind == "inertia_centre_min":
            return np.asarray((moment2 / m + self.bound - q[..., 3]) / self.inertia)
        if self.kind == "centre_radius_max":
            return np.asarray((moment2 / (m * self.bound**2) - m) / self.mass)
        return np.asarray(1.0 - moment2 / (self.bound * m) ** 2)

    def slope(self, q: FloatArray) -> FloatArray:
        """Slopes (4,) of the constraint at q (4,)."""
        m, x, y = q[0], q[1], q[2]
        moment2 = x**2 + y**2
        if self.kind == "mass_min":
            return np.array([-1.0 / self.bound, 0.0, 0.0, 0.0])
        if self.kind == "mass_max":
            return np.array([1.0 / self.bound, 0.0, 0.0, 0.0])
        if self.kind == "inertia_origin_max":
            return np.array([0.0, 0.0, 0.0, 1.0 / self.bound])
        if self.kind == "inertia_centre_min":
            return np.array([-moment2 / m**2, 2.0 * x / m, 2.0 * y / m, -1.0]) / self.inertia
        square = self.bound**2
        if self.kind == "centre_radius_max":
            inner = np.array([-moment2 / (m**2 * square) - 1.0, 2.0 * x / (m * square), 2.0 * y / (m * square), 0.0])
            return inner / self.mass
        return np.array([2.0 * moment2 / m**3, -2.0 * x / m**2, -2.0 * y / m**2, 0.0]) / square

    def checked(self, body: Body, name: str) -> LimitCheck:
        """The limit and what a body has. name: of its link."""
        sense, quantity = _STATED[self.kind]
        values = {"mass": body.mass, "length": abs(body.centre)}
        inertia = body.inertia if self.kind == "inertia_origin_max" else body.central_inertia
        return limit_check(self.kind, values.get(quantity, inertia), self.bound, sense, quantity, name)


@dataclass(frozen=True)
class Sector:
    """The mass centre of link number `link` lies in directions lower to upper, rad, less than half a turn apart."""

    link: int
    lower: float
    upper: float
    scale: float

    def slopes(self) -> FloatArray:
        """Rows (2, 4) s with s q <= 0 inside, scaled; the constraint is linear in the mass numbers."""
        rows = [
            [0.0, math.sin(self.lower), -math.cos(self.lower), 0.0],
            [0.0, -math.sin(self.upper), math.cos(self.upper), 0.0],
        ]
        return np.array(rows) / self.scale


def sectors(link: int, lower: float, upper: float, scale: float) -> list[Sector]:
    """Sectors below half a turn whose union is the stated range of directions, rad."""
    parts = max(1, math.ceil((upper - lower) / (math.pi - 1e-9)))
    edges = np.linspace(lower, upper, parts + 1)
    if lower < 0.0 < upper and parts == 2:
        edges[1] = 0.0
    return [Sector(link, float(one), float(other), scale) for one, other in pairwise(edges)]


def angle_check(body: Body, lower: float, upper: float, name: str) -> LimitCheck:
    """The stated range of directions, and the direction of a body's mass centre, nearest to the range."""
    turn = 2.0 * math.pi
    angle = math.atan2(body.moment_y, body.moment_x)
    from_lower = math.remainder(angle - (lower + upper) / 2.0, turn)
    angle = (lower + upper) / 2.0 + from_lower
    past = abs(from_lower) - (upper - lower) / 2.0
    limit = upper if from_lower > 0.0 else lower
    sense: Sense = "at_most" if from_lower > 0.0 else "at_least"
    return LimitCheck("centre_angle", angle, limit, sense, past / max(abs(limit), 1.0), "angle", name)
