"""What is done with the frames of each message that a mapping names: worked out once, before the first frame.

cantools does not tell standard from extended identifiers when it looks one up; here they are keys of their own.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cantools.database.can import Message, Signal

from drivers.can.mapping import CanMapping, Field, SensorMap

NODE_MASK = 0x03FFFF00
"""Of a J1939 identifier: all but priority and source address."""
LEAST_PERIODS = 8
_FLOAT_MAX = sys.float_info.max

SPEED = ("", "speed")
PAIRED = ("amplitude", "phase")


@dataclass(frozen=True, slots=True)
class Counted:
    """Last count of a message's counter, when it came, and the seconds from one frame to the next (None: unknown)."""

    count: int
    at: float
    period_s: float | None


@dataclass(slots=True)
class MappedSignal:
    """Where a mapped signal goes."""

    slot: tuple[str, str]
    name: str
    factor: float
    valid: str | None


@dataclass(slots=True)
class MessagePlan:
    """All that is done with the frames of one message."""

    message: Message
    decode: Callable[..., Any]
    length: int
    bounds: tuple[tuple[str, float, float, str | None], ...]
    counter: str | None
    modulus: int
    signals: tuple[MappedSignal, ...]
    sensors: tuple[SensorMap, ...]
    planes: bool
    alive: bool
    status: Signal | None
    last_count: int | None = None
    last_at: float = -math.inf
    late_count: int | None = None
    first_at: float = 0.0
    counted: int = 0
    before: Counted | None = None

    def period_s(self) -> float | None:
        """Seconds from one frame to the next, since the counter runs without a break."""
        return (self.last_at - self.first_at) / self.counted if self.counted >= LEAST_PERIODS else None


def plans_of(mapping: CanMapping) -> dict[tuple[int, bool], MessagePlan]:
    """The plan of each message, by identifier (of J1939 without priority and source) and whether it is extended."""
    return {_key(mapping, message): _plan(mapping, message) for message in mapping.messages()}


def _key(mapping: CanMapping, message: Message) -> tuple[int, bool]:
    extended = bool(message.is_extended_frame)
    if extended and mapping.node is not None:
        return (message.frame_id & NODE_MASK, True)
    return (message.frame_id, extended)


def _plan(mapping: CanMapping, message: Message) -> MessagePlan:
    name = message.name
    counter = next((s for s in message.signals if s.name == mapping.counter), None)
    signals = tuple(_signals_of(mapping, name))
    state = mapping.status
    return MessagePlan(
        message=message,
        decode=message.decode,
        length=message.length,
        bounds=tuple(_bound(one, message) for one in signals),
        counter=None if counter is None else counter.name,
        modulus=1 if counter is None else 1 << counter.length,
        signals=signals,
        sensors=tuple(s for s in mapping.sensors if name in (s.amplitude.message, s.phase and s.phase.message)),
        planes=any(name in (p.mass.message, p.angle.message, p.number.message) for p in mapping.corrections),
        alive=mapping.heartbeat in (None, name),
        status=message.get_signal_by_name(state.signal) if state is not None and state.message == name else None,
    )


def _signals_of(mapping: CanMapping, message: str) -> list[MappedSignal]:
    wanted: list[tuple[tuple[str, str], Field | None]] = [(SPEED, mapping.speed)]
    for sensor in mapping.sensors:
        wanted += [((sensor.name, key), getattr(sensor, key)) for key in ("overall", *PAIRED)]
    for plane in mapping.corrections:
        wanted += [((plane.plane, key), getattr(plane, key)) for key in ("mass", "angle", "number")]
    return [
        MappedSignal(slot, field.signal, field.factor, field.valid)
        for slot, field in wanted
        if field is not None and field.message == message
    ]


def _bound(mapped: MappedSignal, message: Message) -> tuple[str, float, float, str | None]:
    """Range of a mapped signal's value as the DBC states it, half a step wide at each end for rounding."""
    signal = message.get_signal_by_name(mapped.name)
    slack = 0.5 * abs(float(signal.scale))
    low = -_FLOAT_MAX if signal.minimum is None else float(signal.minimum) - slack
    high = _FLOAT_MAX if signal.maximum is None else float(signal.maximum) + slack
    return (mapped.name, low, high, mapped.valid)
