"""Motion of a linkage over a turn of its crank: positions, velocities and accelerations of every link.

Complex numbers stand for vectors in the plane, x + i y, angles count anticlockwise. The crank angle is the direction
of the crank's local x axis; the crank turns at constant speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from service.mechanics.bodies import ComplexArray, FloatArray
from service.mechanics.chain import Linkage, Pair, Support
from service.mechanics.refusals import Refusal
from service.messages import Message

BoolArray = NDArray[np.bool_]

DEAD_POINT = math.radians(1e-4)
"""Smallest angle between the links of a dyad, rad; below it forces are without limit."""
CLEAR = math.radians(0.5)
"""By so much the links of a dyad must stay clear of being in line while the crank turns, rad."""
SCANNED = 1440
"""Crank angles at which dead points and gaps are looked for; between them the narrowest places are refined."""
NARROW = 0.99
"""Places where the cosine between links is no larger are not refined: a step of the scan changes it by less."""
BISECTIONS, THIRDS = 40, 60


@dataclass(frozen=True)
class Motion:
    """Motion at crank angles (n,), rad. Arrays are (links, n) in the order of the linkage's links.

    origin, velocity, acceleration: of each link's local origin, m, m/s, m/s2. axis: unit vector of its local x axis.
    omega, alpha: rad/s, rad/s2. points: places (n,) of every named point. transmission: per dyad, angle (n,) between
    its links, rad.
    """

    angles: FloatArray
    speed: float
    origin: ComplexArray
    velocity: ComplexArray
    acceleration: ComplexArray
    axis: ComplexArray
    omega: FloatArray
    alpha: FloatArray
    points: Mapping[str, ComplexArray]
    transmission: FloatArray


@dataclass
class _State:
    """Arrays of a motion while it is built up, link by link."""

    origin: ComplexArray
    velocity: ComplexArray
    acceleration: ComplexArray
    axis: ComplexArray
    omega: FloatArray
    alpha: FloatArray

    def at(self, support: Support) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Place, velocity and acceleration (n,) of a support."""
        if support.carrier is None:
            still = np.zeros_like(self.origin[0])
            return still + support.on_carrier, still, still
        k = support.carrier
        arm = self.axis[k] * support.on_carrier
        turning = 1j * self.omega[k]
        return (
            self.origin[k] + arm,
            self.velocity[k] + turning * arm,
            self.acceleration[k] + (1j * self.alpha[k] + turning**2) * arm,
        )


def whole_turn(samples: int) -> FloatArray:
    """Crank angles (samples,) over one turn from 0, rad; the end is not repeated."""
    return 2.0 * math.pi * np.arange(samples) / samples


def motion(linkage: Linkage, angles: FloatArray, speed: float) -> Motion:
    """Motion at crank angles (n,) in rad; speed: of the crank in rad/s.

    Raises Refusal where a dyad does not close, with the crank angles at which the linkage does, or is in line.
    """
    if not math.isfinite(speed):
        raise Refusal(Message("not_finite", field="speed", value=speed))
    layout, shape = linkage.layout, (len(linkage.links), len(angles))
    state = _still(shape)
    state.omega[layout.crank] = speed
    _hang(state, layout.crank, np.exp(1j * angles), state.at(layout.pivot), layout.pivot.on_link)
    transmission = np.stack([_place(linkage, state, pair, angles) for pair in layout.pairs])
    places = {name: np.full(len(angles), place) for name, place in linkage.ground.items()}
    for k, link in enumerate(linkage.links):
        for name, local in link.points.items():
            places.setdefault(name, state.origin[k] + state.axis[k] * local)
    return Motion(
        angles,
        speed,
        state.origin,
        state.velocity,
        state.acceleration,
        state.axis,
        state.omega,
        state.alpha,
        places,
        transmission,
    )


def _still(shape: tuple[int, int]) -> _State:
    still = np.zeros(shape, dtype=np.complex128)
    return _State(still, still.copy(), still.copy(), still.copy(), np.zeros(shape), np.zeros(shape))


def _hang(
    state: _State, k: int, axis: ComplexArray, at: tuple[ComplexArray, ComplexArray, ComplexArray], local: complex
) -> None:
    """Put link k with its local point at a moving place; its omega and alpha are set before."""
    state.axis[k] = axis
    arm, turning = axis * local, 1j * state.omega[k]
    state.origin[k] = at[0] - arm
    state.velocity[k] = at[1] - turning * arm
    state.acceleration[k] = at[2] - (1j * state.alpha[k] + turning**2) * arm


def _place(linkage: Linkage, state: _State, pair: Pair, angles: FloatArray) -> FloatArray:
    """Place both links of a dyad; the angle between them (n,)."""
    (a, b), (first, second) = pair.links, (state.at(support) for support in pair.supports)
    joint, gap = _joint(pair, first[0], second[0])
    if (gap < 0.0).any():
        _refuse_gap(linkage, pair, float(angles[int(gap.argmin())]))
    to_first, to_second = joint - first[0], joint - second[0]
    spread = np.imag(np.conj(to_second) * to_first)
    between = np.abs(np.arctan2(spread, np.real(np.conj(to_second) * to_first)))
    margin = np.minimum(between, math.pi - between)
    if (margin < DEAD_POINT).any():
        worst = int(margin.argmin())
        raise Refusal(
            Message(
                "linkage_singular",
                field=f"dyads.{pair.joint}",
                value=math.degrees(angles[worst]),
                joint=pair.joint,
                margin=math.degrees(margin[worst]),
            )
        )
    state.omega[a], state.omega[b] = _turned(second[1] - first[1], to_first, to_second, spread)
    closing = second[2] - first[2] + state.omega[a] ** 2 * to_first - state.omega[b] ** 2 * to_second
    state.alpha[a], state.alpha[b] = _turned(closing, to_first, to_second, spread)
    for k, reach, at, end, support in zip(
        (a, b), (to_first, to_second), (first, second), pair.ends, pair.supports, strict=True
    ):
        axis = reach / (end - support.on_link)
        _hang(state, k, axis / np.abs(axis), at, support.on_link)
    return between


def _turned(
    closing: ComplexArray, to_first: ComplexArray, to_second: ComplexArray, spread: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rates (w1, w2) with i w1 to_first - i w2 to_second = closing."""
    return (
        -np.real(closing * np.conj(to_second)) / spread,
        -np.real(closing * np.conj(to_first)) / spread,
    )


def _joint(pair: Pair, first: ComplexArray, second: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """Place of the joint (n,), and how far the dyad is from not closing, m2; below 0 it does not."""
    long, short = pair.lengths
    line = second - first
    apart = np.abs(line)
    along = (long**2 - short**2 + apart**2) / (2.0 * np.maximum(apart, 1e-300))
    gap = long**2 - along**2
    turn = 1j if pair.left else -1j
    return first + line / apart * (along + turn * np.sqrt(np.maximum(gap, 0.0))), gap


def corner_cosines(linkage: Linkage, angles: FloatArray) -> FloatArray:
    """Cosine (dyads, n) of the angle between the links of each dyad; beyond 1 or -1 where it does not close.

    What hangs on a dyad that does not close is placed as if its links were in line.
    """
    layout, shape = linkage.layout, (len(linkage.links), len(angles))
    state = _still(shape)
    _hang(state, layout.crank, np.exp(1j * angles), state.at(layout.pivot), layout.pivot.on_link)
    cosines = np.empty((len(layout.pairs), len(angles)))
    for row, pair in enumerate(layout.pairs):
        first, second = (state.at(support) for support in pair.supports)
        joint, _ = _joint(pair, first[0], second[0])
        long, short = pair.lengths
        cosines[row] = (long**2 + short**2 - np.abs(second[0] - first[0]) ** 2) / (2.0 * long * short)
        for k, at, end, support in zip(pair.links, (first, second), pair.ends, pair.supports, strict=True):
            axis = (joint - at[0]) / (end - support.on_link)
            _hang(state, k, axis / np.maximum(np.abs(axis), 1e-300), at, support.on_link)
    return cosines


def require_turning(linkage: Linkage) -> None:
    """Raise Refusal unless the crank turns fully with every dyad clear of its dead points by `CLEAR`.

    The narrowest places are found between the scanned crank angles too. The refusal names dyad, crank angle and the
    crank angles between which the linkage turns.
    """
    angles = np.concatenate([whole_turn(SCANNED), _narrow_places(linkage)])
    for pair, size in zip(linkage.layout.pairs, np.abs(corner_cosines(linkage, angles)), strict=True):
        worst = int(size.argmax())
        if size[worst] > 1.0:
            _refuse_gap(linkage, pair, float(angles[worst]))
        if size[worst] > math.cos(CLEAR):
            raise Refusal(
                Message(
                    "linkage_singular.turn",
                    field=f"dyads.{pair.joint}",
                    value=math.degrees(angles[worst]) % 360.0,
                    joint=pair.joint,
                    least=math.degrees(CLEAR),
                    margin=math.degrees(math.acos(size[worst])),
                    clear=_told(turning_intervals(linkage, math.cos(CLEAR))),
                )
            )


def turning_intervals(linkage: Linkage, most: float = 1.0) -> list[tuple[float, float]]:
    """Crank angles (from, to) in rad between which the linkage turns; one interval of 2 pi for a full turn.

    most: greatest size of the cosine of the angle between the links of a dyad; 1: every dyad closes.
    """
    angles = np.sort(np.concatenate([whole_turn(SCANNED), _narrow_places(linkage) % (2.0 * math.pi)]))
    turns = _turns(linkage, angles, most)
    if turns.all() or not turns.any():
        return [(0.0, 2.0 * math.pi)] if turns.all() else []
    edges = np.flatnonzero(turns != np.roll(turns, -1))
    following = np.append(angles, angles[0] + 2.0 * math.pi)[edges + 1]
    bounds = _bisected(linkage, angles[edges], following, most)
    if turns[edges[0]]:
        bounds = np.roll(bounds, 1)
        bounds[0] -= 2.0 * math.pi
    return [(float(start), float(end)) for start, end in zip(bounds[::2], bounds[1::2], strict=True)]


def _narrow_places(linkage: Linkage) -> FloatArray:
    """Crank angles (n,) at which a dyad comes nearest to a dead point, refined between the scanned ones."""
    angles = whole_turn(SCANNED)
    size = np.abs(corner_cosines(linkage, angles))
    rows, at = np.nonzero((size >= np.roll(size, 1, axis=1)) & (size >= np.roll(size, -1, axis=1)) & (size > NARROW))
    step = 2.0 * math.pi / SCANNED
    low, high = angles[at] - step, angles[at] + step
    places = np.arange(len(at))

    def found(where: FloatArray) -> FloatArray:
        return np.asarray(np.abs(corner_cosines(linkage, where))[rows, places])

    for _ in range(THIRDS if len(at) else 0):
        left, right = low + (high - low) / 3.0, high - (high - low) / 3.0
        nearer = found(left) > found(right)
        low, high = np.where(nearer, low, left), np.where(nearer, right, high)
    return np.asarray((low + high) / 2.0)


def _bisected(linkage: Linkage, low: FloatArray, high: FloatArray, most: float) -> FloatArray:
    """Angles between low and high at which turning changes."""
    before = _turns(linkage, low, most)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        same = _turns(linkage, middle, most) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return (low + high) / 2.0


def _turns(linkage: Linkage, angles: FloatArray, most: float) -> BoolArray:
    return np.asarray((np.abs(corner_cosines(linkage, angles)) <= most).all(axis=0))


def _refuse_gap(linkage: Linkage, pair: Pair, angle: float) -> None:
    field, at = f"dyads.{pair.joint}", math.degrees(angle)
    closes = _told(turning_intervals(linkage))
    if not closes:
        raise Refusal(Message("linkage_does_not_close.never", field=field, value=at, joint=pair.joint))
    raise Refusal(Message("linkage_does_not_close", field=field, value=at, joint=pair.joint, closes=closes))


def _told(intervals: list[tuple[float, float]]) -> tuple[Message, ...]:
    return tuple(
        Message("linkage_closes_between", start=math.degrees(start), end=math.degrees(end)) for start, end in intervals
    )
