"""What may change on the links: counterweight discs, three point masses a link, or the mass numbers themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from service.design.study import Variable
from service.mechanics.bodies import (
    Body,
    FloatArray,
    as_three_points,
    rim_disc,
    rim_disc_slopes,
    three_points,
    three_points_slopes,
)

_POINT_NAMES = ("point_1", "point_2", "point_3", "point_radius")
_NUMBER_NAMES = ("mass", "moment_x", "moment_y", "inertia_origin")


class MassDesign(Protocol):
    """A choice of design variables x (d,) on a linkage with mass numbers p (4 links,)."""

    @property
    def variables(self) -> tuple[Variable, ...]:
        """What may vary, in the order of x."""

    @property
    def linear(self) -> bool:
        """Whether p is linear in x, which keeps convex limits convex."""

    def numbers(self, x: FloatArray) -> FloatArray:
        """Mass numbers (..., 4 links) of designs x (..., d)."""

    def slopes(self, x: FloatArray) -> FloatArray:
        """Derivatives (4 links, d) at one design."""

    def patch(self, x: FloatArray, length: float, mass: float, inertia: float) -> Mapping[str, Any]:
        """A design as a patch of the document; length, mass, inertia: factors of its units to SI."""


@dataclass(frozen=True)
class Counterweights:
    """Discs whose rim passes through the local origin; x = (x, y, thickness) of each, in m.

    base: mass numbers (4 links,) of the linkage; links: index and name of each disc's link; density: kg/m3.
    """

    base: FloatArray
    links: tuple[tuple[int, str], ...]
    density: float
    variables: tuple[Variable, ...]
    linear: bool = False

    def numbers(self, x: FloatArray) -> FloatArray:
        """Mass numbers (..., 4 links) with the discs."""
        discs = self.discs(x)
        p = np.empty((*x.shape[:-1], len(self.base) // 4, 4))
        p[...] = self.base.reshape(-1, 4)
        p[..., [link for link, _ in self.links], :] += discs
        return p.reshape(*x.shape[:-1], -1)

    def discs(self, x: FloatArray) -> FloatArray:
        """Mass numbers (..., discs, 4) of the discs alone."""
        triples = x.reshape(*x.shape[:-1], -1, 3)
        return rim_disc(triples[..., 0], triples[..., 1], triples[..., 2], self.density)

    def slopes(self, x: FloatArray) -> FloatArray:
        """Derivatives (4 links, d)."""
        triples = x.reshape(-1, 3)
        each = rim_disc_slopes(triples[:, 0], triples[:, 1], triples[:, 2], self.density)
        result = np.zeros((len(self.base), len(x)))
        for k, (link, _) in enumerate(self.links):
            result[4 * link : 4 * link + 4, 3 * k : 3 * k + 3] += each[k]
        return result

    def patch(self, x: FloatArray, length: float, mass: float, inertia: float) -> Mapping[str, Any]:  # noqa: ARG002
        """The counterweights as the document states them."""
        rows = (x.reshape(-1, 3) / length).tolist()
        stated = [
            {"link": name, "x": row[0], "y": row[1], "thickness": row[2]}
            for (_, name), row in zip(self.links, rows, strict=True)
        ]
        return {"design": {"counterweight": stated}}


@dataclass(frozen=True)
class PointMasses:
    """Each changed link as three point masses on a radius, x = (m1, m2, m3, radius) of each, kg and m."""

    base: FloatArray
    links: tuple[tuple[int, str], ...]
    variables: tuple[Variable, ...]
    linear: bool = False

    def numbers(self, x: FloatArray) -> FloatArray:
        """Mass numbers (..., 4 links) with the changed links."""
        fours = x.reshape(*x.shape[:-1], -1, 4)
        return _replaced(self.base, self.links, three_points(fours[..., :3], fours[..., 3]))

    def slopes(self, x: FloatArray) -> FloatArray:
        """Derivatives (4 links, d)."""
        fours = x.reshape(-1, 4)
        each = three_points_slopes(fours[:, :3], fours[:, 3])
        result = np.zeros((len(self.base), len(x)))
        for k, (link, _) in enumerate(self.links):
            result[4 * link : 4 * link + 4, 4 * k : 4 * k + 4] = each[k]
        return result

    def patch(self, x: FloatArray, length: float, mass: float, inertia: float) -> Mapping[str, Any]:
        """The changed bodies as the document states them."""
        return _bodies(self.links, self.numbers(x), length, mass, inertia)


@dataclass(frozen=True)
class MassNumbers:
    """Each changed link by its mass numbers, x = (m, m x, m y, J) of each."""

    base: FloatArray
    links: tuple[tuple[int, str], ...]
    variables: tuple[Variable, ...]
    linear: bool = True

    @cached_property
    def _slopes(self) -> FloatArray:
        result = np.zeros((len(self.base), 4 * len(self.links)))
        for k, (link, _) in enumerate(self.links):
            result[4 * link : 4 * link + 4, 4 * k : 4 * k + 4] = np.eye(4)
        return result

    def numbers(self, x: FloatArray) -> FloatArray:
        """Mass numbers (..., 4 links) with the changed links."""
        return _replaced(self.base, self.links, x.reshape(*x.shape[:-1], -1, 4))

    def slopes(self, x: FloatArray) -> FloatArray:  # noqa: ARG002  the same everywhere
        """Derivatives (4 links, d)."""
        return self._slopes

    def patch(self, x: FloatArray, length: float, mass: float, inertia: float) -> Mapping[str, Any]:
        """The changed bodies as the document states them."""
        return _bodies(self.links, self.numbers(x), length, mass, inertia)


def point_variables(name: str, body: Body, masses: tuple[float, float], radii: tuple[float, float]) -> list[Variable]:
    """Variables of one link of `PointMasses`; masses and radii: bounds in kg and m."""
    points, radius = as_three_points(body)
    present = [*points.tolist(), radius]
    bounds = [masses, masses, masses, radii]
    quantities = ("mass", "mass", "mass", "length")
    return [
        Variable(f"{name}.{label}", low, high, value, quantity)
        for label, (low, high), value, quantity in zip(_POINT_NAMES, bounds, present, quantities, strict=True)
    ]


def number_variables(name: str, body: Body, mass: float, moment: float, inertia: float) -> list[Variable]:
    """Variables of one link of `MassNumbers`; mass, moment, inertia: greatest values, kg, kg m and kg m2."""
    bounds = [(1e-3 * body.mass, mass), (-moment, moment), (-moment, moment), (0.0, inertia)]
    quantities = ("mass", "mass_moment", "mass_moment", "inertia")
    return [
        Variable(f"{name}.{label}", low, high, float(value), quantity)
        for label, (low, high), value, quantity in zip(_NUMBER_NAMES, bounds, body.numbers, quantities, strict=True)
    ]


def _replaced(base: FloatArray, links: tuple[tuple[int, str], ...], each: FloatArray) -> FloatArray:
    p = np.empty((*each.shape[:-2], len(base) // 4, 4))
    p[...] = base.reshape(-1, 4)
    p[..., [link for link, _ in links], :] = each
    return p.reshape(*each.shape[:-2], -1)


def _bodies(
    links: tuple[tuple[int, str], ...], p: FloatArray, length: float, mass: float, inertia: float
) -> Mapping[str, Any]:
    stated = []
    for link, name in links:
        body = Body(*p[4 * link : 4 * link + 4].tolist())
        centre = body.centre / length
        stated.append(
            {
                "link": name,
                "body": {
                    "mass": body.mass / mass,
                    "centre": [centre.real, centre.imag],
                    "inertia": body.inertia / inertia,
                    "inertia_about": "origin",
                },
            }
        )
    return {"design": {"link": stated}}
