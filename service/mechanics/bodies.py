"""Bodies in plane motion as four numbers, p = (m, m x, m y, J): mass, first moments, inertia about the local origin.

Everything that a linkage does to its frame is linear in these numbers; joining two bodies adds them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from service.mechanics.refusals import Refusal
from service.messages import Message

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

RIM_DISC = 1.5
"""Inertia of a disc about a point of its rim, in units of m R^2: 1/2 + 1."""
THIRDS = 2.0 * math.pi / 3.0 * np.arange(3)
"""Angles of the three point masses of a link, rad."""
ROUNDING = 1e-9


@dataclass(frozen=True)
class Body:
    """A rigid body in its link's local frame. mass: kg; moment_x, moment_y: kg m; inertia about the origin: kg m2."""

    mass: float
    moment_x: float
    moment_y: float
    inertia: float

    @classmethod
    def about_centre(cls, mass: float, centre: complex, inertia: float) -> Self:
        """A body from its inertia about the mass centre; centre: x + i y in m."""
        return cls(mass, mass * centre.real, mass * centre.imag, inertia + mass * abs(centre) ** 2)

    @classmethod
    def about_origin(cls, mass: float, centre: complex, inertia: float) -> Self:
        """A body from its inertia about the local origin; centre: x + i y in m."""
        return cls(mass, mass * centre.real, mass * centre.imag, inertia)

    @property
    def numbers(self) -> FloatArray:
        """The four numbers, p."""
        return np.array([self.mass, self.moment_x, self.moment_y, self.inertia])

    @property
    def centre(self) -> complex:
        """Mass centre x + i y, m; 0 for a body without mass."""
        return complex(self.moment_x, self.moment_y) / self.mass if self.mass > 0.0 else 0j

    @property
    def central_inertia(self) -> float:
        """Inertia about the mass centre, kg m2."""
        return self.inertia - self.mass * abs(self.centre) ** 2


def check_body(body: Body, name: str) -> None:
    """Raise Refusal unless the four numbers can belong to a real body."""
    for field, value in zip(("mass", "moment_x", "moment_y", "inertia"), body.numbers.tolist(), strict=True):
        if not math.isfinite(value):
            raise Refusal(Message("not_finite", field=f"{name}.{field}", value=value))
    if body.mass < 0.0:
        raise Refusal(Message("body_mass_negative", field=f"{name}.mass", value=body.mass, body=name))
    least = body.mass * abs(body.centre) ** 2
    if body.inertia < least * (1.0 - ROUNDING) or (body.mass > 0.0 and body.inertia <= 0.0):
        raise Refusal(
            Message("body_inertia_impossible", field=f"{name}.inertia", value=body.inertia, body=name, least=least)
        )


def rim_disc(x: FloatArray, y: FloatArray, thickness: FloatArray, density: float) -> FloatArray:
    """Numbers (..., 4) of discs whose rim passes through the local origin; centre (x, y) and thickness in m."""
    square = x**2 + y**2
    numbers = np.empty((*x.shape, 4))
    mass = density * math.pi * square * thickness
    numbers[..., 0], numbers[..., 1], numbers[..., 2] = mass, mass * x, mass * y
    numbers[..., 3] = RIM_DISC * mass * square
    return numbers


def rim_disc_slopes(x: FloatArray, y: FloatArray, thickness: FloatArray, density: float) -> FloatArray:
    """Derivatives (..., 4, 3) of `rim_disc` by x, y and thickness."""
    square, area = x**2 + y**2, density * math.pi * thickness
    mass, flat = area * square, density * math.pi * square
    slopes = np.empty((*x.shape, 4, 3))
    slopes[..., 0, 0], slopes[..., 0, 1], slopes[..., 0, 2] = 2.0 * area * x, 2.0 * area * y, flat
    slopes[..., 1, :] = slopes[..., 0, :] * x[..., None]
    slopes[..., 2, :] = slopes[..., 0, :] * y[..., None]
    slopes[..., 1, 0] += mass
    slopes[..., 2, 1] += mass
    slopes[..., 3, :] = slopes[..., 0, :] * (2.0 * RIM_DISC * square)[..., None]
    slopes[..., 3, 2] = RIM_DISC * flat * square
    return slopes


def three_points(masses: FloatArray, radius: FloatArray) -> FloatArray:
    """Numbers (..., 4) of three point masses (..., 3) at 0, 120 and 240 degrees on one radius (...), m."""
    mass = masses.sum(axis=-1)
    return np.stack(
        [mass, radius * (masses @ np.cos(THIRDS)), radius * (masses @ np.sin(THIRDS)), radius**2 * mass], axis=-1
    )


def three_points_slopes(masses: FloatArray, radius: FloatArray) -> FloatArray:
    """Derivatives (..., 4, 4) of `three_points` by the three masses and the radius."""
    one, a = np.ones_like(masses), radius[..., None]
    by_mass = np.stack([one, a * np.cos(THIRDS) * one, a * np.sin(THIRDS) * one, a**2 * one], axis=-2)
    mass = masses.sum(axis=-1)
    by_radius = np.stack(
        [np.zeros_like(mass), masses @ np.cos(THIRDS), masses @ np.sin(THIRDS), 2.0 * radius * mass], axis=-1
    )
    return np.concatenate([by_mass, by_radius[..., None]], axis=-1)


def as_three_points(body: Body) -> tuple[FloatArray, float]:
    """Point masses (3,) and their radius; a negative mass shows a body that three points cannot stand for."""
    radius = math.sqrt(body.inertia / body.mass)
    along = body.moment_x * np.cos(THIRDS) + body.moment_y * np.sin(THIRDS)
    return body.mass / 3.0 + 2.0 / 3.0 * along / radius, radius
