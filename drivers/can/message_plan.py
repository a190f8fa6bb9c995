"""Decode plan of each mapped message, prepared before the first frame.

cantools does not tell standard from extended identifiers when it looks one up; here they are keys of their own.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass

from cantools.database.can import Message, Signal

from drivers.can.j1939 import group_of
from drivers.can.mapping import CanMapping, Field, SensorMap, Validity
from drivers.can.sentinels import kept_from, named
from drivers.can.signals import RawSignal, raw_signal

MIN_PERIODS = 8
_FLOAT_MAX = sys.float_info.max

SPEED = ("", "speed")
PAIRED = ("amplitude", "phase")
ANGLES = ("phase", "angle")
MAX_TURN = 360.0 + 1e-6
"""Greatest angle, degrees, of a signal whose range nothing states: more is no angle but a value that means none."""


@dataclass(frozen=True, slots=True)
class CounterState:
    """Last count of a message's counter, when it came, and the seconds from one frame to the next (None: unknown)."""

    count: int
    at: float
    period_s: float | None


@dataclass(frozen=True, slots=True)
class Flag:
    """A signal that vouches for values, and when it does."""

    signal: RawSignal
    rule: Validity
    simple: bool

    def holds(self, whole: int, data: bytes | bytearray | memoryview) -> bool:
        """Whether it vouches, in a frame with these data; whole: the data as a little-endian number."""
        signal = self.signal
        if self.simple:
            return whole >> signal.place & signal.mask == 1
        return bool(signal.shown(data)) and self.rule.holds(signal.raw(data))


@dataclass(frozen=True, slots=True)
class MappedSignal:
    """Where a mapped signal lies and where it goes; the range is that of its value in the DBC's unit.

    missing, missing_from: raw values that stand for none, and the lowest from which on all do.
    """

    slot: tuple[str, str]
    signal: RawSignal
    factor: float
    flag: Flag | None
    low: float
    high: float
    missing: frozenset[int]
    missing_from: float


@dataclass(slots=True)
class MessagePlan:
    """All that is done with the frames of one message. whole: bytes that hold all of its mapped signals."""

    message: Message
    by_group: bool
    whole: int
    wanted: tuple[RawSignal, ...]
    counter: RawSignal | None
    modulus: int
    signals: tuple[MappedSignal, ...]
    sensors: tuple[SensorMap, ...]
    planes: bool
    alive: bool
    status: RawSignal | None
    state_of: Callable[[int], str] | None
    last_count: int | None = None
    last_at: float = -math.inf
    late_count: int | None = None
    first_at: float = 0.0
    counted: int = 0
    before: CounterState | None = None

    def period_s(self) -> float | None:
        """Seconds from one frame to the next, since the counter runs without a break."""
        return (self.last_at - self.first_at) / self.counted if self.counted >= MIN_PERIODS else None

    def fits(self, data: bytes | bytearray | memoryview) -> bool:
        """Whether all wanted signals of the frame's page are in it."""
        shown = [one.shown(data) for one in self.wanted]
        return None not in shown and all(
            not on or one.needs <= len(data) for one, on in zip(self.wanted, shown, strict=True)
        )


Key = tuple[int, bool]


def plans_of(mapping: CanMapping) -> dict[Key, MessagePlan]:
    """The plan of each message, by identifier and whether it is extended; by (group, True) where the group tells."""
    return {_key(plan): plan for plan in (_plan(mapping, message) for message in mapping.messages())}


def _key(plan: MessagePlan) -> Key:
    message = plan.message
    if plan.by_group:
        return (-1 - group_of(message.frame_id), True)
    return (message.frame_id, bool(message.is_extended_frame))


def group_key(identifier: int) -> Key:
    """The key of a message that is told by its group; below 0, where no identifier is."""
    return (-1 - group_of(identifier), True)


def _plan(mapping: CanMapping, message: Message) -> MessagePlan:
    name = message.name
    counter = next((raw_signal(message, s.name) for s in message.signals if s.name == mapping.counter), None)
    signals = tuple(_signals_of(mapping, message))
    status = mapping.status
    state = None if status is None or status.message != name else message.get_signal_by_name(status.signal)
    state_at = None if state is None else raw_signal(message, state.name)
    wanted = _distinct(
        [one.signal for one in signals]
        + [one.flag.signal for one in signals if one.flag is not None]
        + [one for one in (counter, state_at) if one is not None]
    )
    return MessagePlan(
        message=message,
        by_group=mapping.by_group(message),
        whole=max(
            (multiplexer.needs for one in wanted for multiplexer in (one, *(m for m, _ in one.pages))), default=0
        ),
        wanted=wanted,
        counter=counter,
        modulus=1 if counter is None else 1 << counter.length,
        signals=signals,
        sensors=tuple(s for s in mapping.sensors if name in (s.amplitude.message, s.phase and s.phase.message)),
        planes=any(name in (p.mass.message, p.angle.message, p.number.message) for p in mapping.corrections),
        alive=mapping.heartbeat in (None, name),
        status=state_at,
        state_of=None if state is None else _state_of(state),
    )


def _distinct(signals: list[RawSignal]) -> tuple[RawSignal, ...]:
    return tuple({one.name: one for one in signals}.values())


def _signals_of(mapping: CanMapping, message: Message) -> list[MappedSignal]:
    wanted: list[tuple[tuple[str, str], Field | None]] = [(SPEED, mapping.speed)]
    for sensor in mapping.sensors:
        wanted += [((sensor.name, key), getattr(sensor, key)) for key in ("overall", *PAIRED)]
    for plane in mapping.corrections:
        wanted += [((plane.plane, key), getattr(plane, key)) for key in ("mass", "angle", "number")]
    j1939 = mapping.by_group(message)
    return [
        _mapped(slot, field, message, j1939=j1939)
        for slot, field in wanted
        if field is not None and field.message == message.name
    ]


def _mapped(slot: tuple[str, str], field: Field, message: Message, *, j1939: bool) -> MappedSignal:
    signal = message.get_signal_by_name(field.signal)
    slack = 0.5 * abs(float(signal.scale))
    low = signal.minimum if field.low is None else field.low
    high = signal.maximum if field.high is None else field.high
    if slot[1] in ANGLES and low is None and high is None:
        low, high = -MAX_TURN / abs(field.factor), MAX_TURN / abs(field.factor)
    automatic = field.not_available is None
    counts = slot[1] == "number"
    return MappedSignal(
        slot=slot,
        signal=raw_signal(message, field.signal),
        factor=field.factor,
        flag=None if field.valid is None else _flag(message, field.valid),
        low=-_FLOAT_MAX if low is None else float(low) - slack,
        high=_FLOAT_MAX if high is None else float(high) + slack,
        missing=named(signal) if field.not_available is None else field.not_available,
        missing_from=math.inf
        if counts or not automatic
        else kept_from(message, signal, j1939=j1939, angle=slot[1] in ANGLES),
    )


def _flag(message: Message, rule: Validity) -> Flag:
    signal = raw_signal(message, rule.signal)
    return Flag(signal, rule, signal.plain and not signal.sign and rule == Validity(rule.signal))


def _state_of(signal: Signal) -> Callable[[int], str]:
    """A status in the words of the DBC, else as a number."""
    choices = {int(raw): str(name) for raw, name in (signal.choices or {}).items()}
    return lambda raw: choices.get(raw, str(raw))
