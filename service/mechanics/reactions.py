"""Forces in the joints of a linkage, by Newton and Euler, dyad by dyad from the last to the first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.mechanics.bodies import ComplexArray, FloatArray
from service.mechanics.chain import GROUND, Linkage, Pair, Support
from service.mechanics.kinematics import Motion


@dataclass(frozen=True)
class JointForce:
    """Force (n,), N, of the link `by` on the link `on` in the joint `joint`."""

    joint: str
    by: str
    on: str
    force: ComplexArray


@dataclass(frozen=True)
class Reactions:
    """Forces in every joint, and the torque (n,) on the crank, N m; frame: resultant force on the frame (n,), N.

    frame_moment: moment (n,) on the frame about the moment point, N m, the torque's reaction included.
    """

    joints: tuple[JointForce, ...]
    torque: FloatArray
    frame: ComplexArray
    frame_moment: FloatArray


@dataclass
class _Loads:
    """Force (links, n), and moment about each link's origin, that joints must still supply."""

    force: ComplexArray
    moment: FloatArray

    def about(self, k: int, arm: ComplexArray) -> FloatArray:
        """Moment of link k about a point at `arm` from its origin."""
        return np.asarray(self.moment[k] - _cross(arm, self.force[k]))

    def hand_on(self, k: int, arm: ComplexArray, force: ComplexArray) -> None:
        """Let link k carry a force that another link needs at `arm` from its origin."""
        self.force[k] += force
        self.moment[k] += _cross(arm, force)


def reactions(linkage: Linkage, moving: Motion, p: FloatArray) -> Reactions:
    """Joint forces for the mass numbers p (4 links,) of `bodies`, in the order of the linkage's links."""
    layout, loads = linkage.layout, _needed(linkage, moving, p)
    joints: list[JointForce] = []
    frame: list[tuple[complex, ComplexArray]] = []
    for pair in reversed(layout.pairs):
        found, grounded = _dyad(linkage, moving, loads, pair)
        joints[:0] = found
        frame += grounded
    crank, pivot = layout.crank, layout.pivot
    arm = moving.axis[crank] * pivot.on_link
    torque, force = loads.about(crank, arm), loads.force[crank].copy()
    joints.insert(0, JointForce(pivot.name, GROUND, linkage.links[crank].name, force))
    frame.append((pivot.on_carrier, force))
    total = -sum((one for _, one in frame), np.zeros_like(force))
    moments = sum((_cross(np.full_like(force, place - layout.origin), one) for place, one in frame), torque)
    return Reactions(tuple(joints), torque, total, -moments)


def _needed(linkage: Linkage, moving: Motion, p: FloatArray) -> _Loads:
    """Force, and moment about its origin, that the motion of each link needs."""
    m, mx, my, inertia = (column[:, None] for column in p.reshape(-1, 4).T)
    lifted = moving.acceleration + 1j * linkage.gravity
    inward = (1j * moving.alpha - moving.omega**2) * moving.axis
    arm = (mx + 1j * my) * moving.axis
    return _Loads(m * lifted + (mx + 1j * my) * inward, _cross(arm, lifted) + inertia * moving.alpha)


def _dyad(
    linkage: Linkage, moving: Motion, loads: _Loads, pair: Pair
) -> tuple[list[JointForce], list[tuple[complex, ComplexArray]]]:
    """Forces in the three joints of a dyad; what its supports carry is handed on, or listed where it is the ground."""
    (a, b), (first, second) = pair.links, pair.supports
    arms = [moving.axis[k] * support.on_link for k, support in zip(pair.links, pair.supports, strict=True)]
    reaches = [
        moving.axis[k] * (end - support.on_link)
        for k, end, support in zip(pair.links, pair.ends, pair.supports, strict=True)
    ]
    wanted = [loads.about(k, arm) for k, arm in zip(pair.links, arms, strict=True)]
    spread = _cross(reaches[0], reaches[1])
    inner = (wanted[1] * reaches[0] + wanted[0] * reaches[1]) / spread
    at_first, at_second = loads.force[a] - inner, loads.force[b] + inner
    names = [link.name for link in linkage.links]
    found = [
        JointForce(first.name, _carrier(names, first), names[a], at_first),
        JointForce(pair.joint, names[b], names[a], inner),
        JointForce(second.name, _carrier(names, second), names[b], at_second),
    ]
    grounded = []
    for support, force in ((first, at_first), (second, at_second)):
        if support.carrier is None:
            grounded.append((support.on_carrier, force))
        else:
            loads.hand_on(support.carrier, moving.axis[support.carrier] * support.on_carrier, force)
    return found, grounded


def _carrier(names: list[str], support: Support) -> str:
    return GROUND if support.carrier is None else names[support.carrier]


def _cross(p: ComplexArray, q: ComplexArray) -> FloatArray:
    return np.imag(np.conj(p) * q)
