"""Limits on the mass numbers q = (m, m x, m y, J) of one link: scaled g(q) <= 0 with slopes, and as stated.

Upper limits on radius and lower ones on inertia are written over the mass, so that they are convex in q.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from service.design.study import LimitCheck, Sense, limit_check
from service.mechanics.bodies import Body, FloatArray
from service.optimize.problem import IntArray

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
        """The constraint g (n,) for mass numbers q (n, 4)."""
        like = np.ones(len(q))
        return _SCALED[self.kind](q.T, _Held(self.bound * like, self.mass * like, self.inertia * like))[0]

    def checked(self, body: Body, name: str) -> LimitCheck:
        """The limit and what a body has. name: of its link."""
        sense, quantity = _STATED[self.kind]
        values = {"mass": body.mass, "length": abs(body.centre)}
        inertia = body.inertia if self.kind == "inertia_origin_max" else body.central_inertia
        return limit_check(self.kind, values.get(quantity, inertia), self.bound, sense, quantity, name)


@dataclass(frozen=True)
class _Held:
    """Bounds, and masses and inertias to scale with, (k,) of the limits of one kind."""

    bound: FloatArray
    mass: FloatArray
    inertia: FloatArray


@dataclass(frozen=True)
class LimitSet:
    """Limits sorted by kind, so that all of one kind are computed at once. groups: kind, rows, links and levels."""

    count: int
    groups: tuple[tuple[Kind, IntArray, IntArray, _Held], ...]

    @classmethod
    def of(cls, limits: tuple[MassLimit, ...]) -> LimitSet:
        """The set of some limits; rows stay in their order."""
        groups = []
        for kind in dict.fromkeys(limit.kind for limit in limits):
            rows = np.array([k for k, limit in enumerate(limits) if limit.kind == kind])
            held = [limits[k] for k in rows]
            groups.append(
                (
                    kind,
                    rows,
                    np.array([limit.link for limit in held]),
                    _Held(
                        np.array([limit.bound for limit in held]),
                        np.array([limit.mass for limit in held]),
                        np.array([limit.inertia for limit in held]),
                    ),
                )
            )
        return cls(len(limits), tuple(groups))

    def at(self, bodies: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Constraints g (c,) and slopes (c, 4 links) for mass numbers (links, 4)."""
        g, slopes = np.zeros(self.count), np.zeros((self.count, *bodies.shape))
        for kind, rows, links, held in self.groups:
            g[rows], slopes[rows, links] = _SCALED[kind](bodies[links].T, held)
        return g, slopes.reshape(self.count, -1)


_Scaled = Callable[[FloatArray, _Held], tuple[FloatArray, FloatArray]]


def _rows(m: FloatArray | float, x: FloatArray | float, y: FloatArray | float, j: FloatArray | float) -> FloatArray:
    """Slopes (k, 4) from columns."""
    return np.stack(np.broadcast_arrays(m, x, y, j), axis=1)


def _mass_min(q: FloatArray, of: _Held) -> tuple[FloatArray, FloatArray]:
    return 1.0 - q[0] / of.bound, _rows(-1.0 / of.bound, 0.0, 0.0, 0.0)


def _mass_max(q: FloatArray, of: _Held) -> tuple[FloatArray, FloatArray]:
    return q[0] / of.bound - 1.0, _rows(1.0 / of.bound, 0.0, 0.0, 0.0)


def _origin_max(q: FloatArray, of: _Held) -> tuple[FloatArray, FloatArray]:
    return q[3] / of.bound - 1.0, _rows(0.0 * of.bound, 0.0, 0.0, 1.0 / of.bound)


def _centre_min(q: FloatArray, of: _Held) -> tuple[FloatArray, FloatArray]:
    m, x, y, j = q
    moment2 = x**2 + y**2
    g = (moment2 / m + of.bound - j) / of.inertia
    return g, _rows(-moment2 / m**2, 2.0 * x / m, 2.0 * y / m, -1.0) / of.inertia[:, None]


def _radius_max(q: FloatArray, of: _Held) -> tuple[FloatArray, FloatArray]:
    m, x, y, _ = q
    square = m * of.bound**2
    moment2 = x**2 + y**2
    g = (moment2 / square - m) / of.mass
    return g, _rows(-moment2 / (m * square) - 1.0, 2.0 * x / square, 2.0 * y / square, 0.0) / of.mass[:, None]


def _radius_min(q: FloatArray, of: _Held) -> tuple[FloatArray, FloatArray]:
    m, x, y, _ = q
    square = (of.bound * m) ** 2
    moment2 = x**2 + y**2
    return 1.0 - moment2 / square, _rows(2.0 * moment2 / m, -2.0 * x, -2.0 * y, 0.0) / square[:, None]


_SCALED: dict[Kind, _Scaled] = {
    "mass_min": _mass_min,
    "mass_max": _mass_max,
    "inertia_origin_max": _origin_max,
    "inertia_centre_min": _centre_min,
    "centre_radius_max": _radius_max,
    "centre_radius_min": _radius_min,
}


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
