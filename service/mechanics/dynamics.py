"""What a linkage does to its frame, linear in the masses: p = (m, m x, m y, J) of every link, see `bodies`.

Shaking force f = -sum p F: force of the linkage on the frame. Shaking moment M = -sum p N: moment on the frame about
the moment point, driving torque included. Torque T = sum p D: of the frame on the crank, anticlockwise positive.
Over a turn rms^2 = p^T G p with constant matrices G, so that one evaluation takes microseconds and slopes are exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from service.mechanics.bodies import ComplexArray, FloatArray
from service.mechanics.chain import Linkage
from service.mechanics.kinematics import Motion
from service.mechanics.refusals import Refusal
from service.messages import Message

Quantity = Literal["force", "moment", "torque"]


@dataclass(frozen=True)
class Features:
    """What one unit of each mass number of each link gives over the turn, rows in the order p of link 1, link 2, ...

    force: (4 links, n) N per unit; moment, torque: (4 links, n) N m per unit.
    """

    force: ComplexArray
    moment: FloatArray
    torque: FloatArray

    @cached_property
    def gram(self) -> dict[Quantity, FloatArray]:
        """G (4 links, 4 links) of each quantity: mean square over the turn = p^T G p."""
        n = self.force.shape[1]
        return {
            "force": np.real(self.force @ self.force.conj().T) / n,
            "moment": self.moment @ self.moment.T / n,
            "torque": self.torque @ self.torque.T / n,
        }

    def shaking_force(self, p: FloatArray) -> ComplexArray:
        """Force on the frame (n,), N, for the mass numbers p (4 links,)."""
        return np.asarray(-(p @ self.force))

    def shaking_moment(self, p: FloatArray) -> FloatArray:
        """Moment on the frame (n,), N m."""
        return np.asarray(-(p @ self.moment))

    def driving_torque(self, p: FloatArray) -> FloatArray:
        """Torque on the crank (n,), N m."""
        return np.asarray(p @ self.torque)

    def mean_square(self, quantity: Quantity, p: FloatArray) -> FloatArray:
        """Mean square over the turn of one quantity for mass numbers p (..., 4 links); shape (...)."""
        return np.asarray(np.maximum(((p @ self.gram[quantity]) * p).sum(axis=-1), 0.0))


def features(linkage: Linkage, moving: Motion) -> Features:
    """What each mass number gives at the crank angles of `moving`. Raises Refusal for a crank at rest.

    Gravity enters as an acceleration of i g of every body, so that the shaking force includes the weight.
    """
    if moving.speed == 0.0:
        raise Refusal(Message("speed_zero", field="speed", value=0.0))
    lifted = moving.acceleration + 1j * linkage.gravity
    axis, velocity, omega = moving.axis, moving.velocity, moving.omega
    inward = (1j * moving.alpha - omega**2) * axis
    place = moving.origin - linkage.layout.origin
    force = np.stack([lifted, inward, 1j * inward, np.zeros_like(lifted)], axis=1)
    moment = np.stack(
        [
            _cross(place, lifted),
            _cross(place, inward) + _cross(axis, lifted),
            _cross(place, 1j * inward) + _cross(1j * axis, lifted),
            moving.alpha,
        ],
        axis=1,
    )
    power = np.stack(
        [
            _dot(lifted, velocity),
            _dot(inward, velocity) + _dot(lifted, 1j * omega * axis),
            _dot(1j * inward, velocity) - _dot(lifted, omega * axis),
            moving.alpha * omega,
        ],
        axis=1,
    )
    n = len(moving.angles)
    return Features(force.reshape(-1, n), moment.reshape(-1, n), power.reshape(-1, n) / moving.speed)


def mass_numbers(linkage: Linkage) -> FloatArray:
    """The numbers p (4 links,) of the linkage's own bodies."""
    return np.concatenate([link.body.numbers for link in linkage.links])


def _cross(p: ComplexArray, q: ComplexArray) -> FloatArray:
    return np.imag(np.conj(p) * q)


def _dot(p: ComplexArray, q: ComplexArray) -> FloatArray:
    return np.real(p * np.conj(q))
