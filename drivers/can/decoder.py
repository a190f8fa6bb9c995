"""Frames to readings: strict about identifier, length, range, sequence and age; what is refused is counted, not raised.

cantools takes over-long frames and values outside [min|max] without a word: those checks are here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cantools.database import DecodeError
from cantools.database.can import Signal

from drivers.can.mapping import CanMapping, SensorMap
from drivers.can.message_plan import NODE_MASK, PAIRED, SPEED, Counted, MessagePlan, plans_of

REASONS = (
    "foreign",
    "not_data",
    "wrong_length",
    "undecodable",
    "out_of_range",
    "doubled",
    "late",
    "not_valid",
    "unpaired",
)
"""Why a frame gave no reading. foreign: of another message or node (not counted as refused). not_data: remote, error or
FD frame. doubled: its counter is that of the frame before. late: its counter is behind. not_valid: the balancer says
itself that the amplitude does not hold. unpaired: amplitude without phase, or phase without amplitude, of one round."""

LONGEST_UNREAD_S = 600.0
MOST = 1e9
"""Highest amplitude, overall value and speed of a reading."""


@dataclass(slots=True)
class Vector:
    """What one sensor said: amplitude and overall in its unit, phase in degrees, speed in r/min.

    lost: readings of the sensor that never arrived since the one before.
    """

    sensor: str
    amplitude: float
    phase_deg: float | None
    speed_rpm: float | None
    overall_rms: float | None
    lost: int


@dataclass(frozen=True, slots=True)
class Masses:
    """The balancer's own answer: plane, mass in g, angle in degrees in the machine's sense."""

    masses: tuple[tuple[str, float, float], ...]


class FrameDecoder:
    """Decodes the frames of one balancer. `at` is any time in seconds that runs evenly; only differences count."""

    def __init__(self, mapping: CanMapping) -> None:
        self.mapping = mapping
        self.counts: dict[str, int] = dict.fromkeys(REASONS, 0)
        self.frames = 0
        self.refused = 0
        """Frames of the balancer that gave no reading though they should have."""
        self.lost_frames = 0
        self.lost_unread = 0
        """Of the lost frames, those that came while nothing read the bus, as far as counters and times can tell."""
        self.status: str | None = None
        self.heard_at = -math.inf
        self._plans = plans_of(mapping)
        self._values: dict[tuple[str, str], tuple[float | None, float]] = {}
        self._lost: dict[str, int] = {}
        self._answer: float | None = None

    def feed(
        self, identifier: int, extended: bool, data: bytes | bytearray, at: float, *, is_data: bool = True
    ) -> list[Vector | Masses]:
        """Take a frame and return what it completes: nothing, a vector, several where a message has several sensors."""
        self.frames += 1
        plan = self._plans.get(self._masked(identifier, extended))
        if plan is None:
            return self._refuse("foreign")
        if not is_data:
            return self._refuse("not_data")
        if len(data) != plan.length:
            return self._refuse("wrong_length")
        try:
            values = plan.decode(data, decode_choices=False)
        except (DecodeError, ValueError):
            return self._refuse("undecodable")
        for name, low, high, valid in plan.bounds:
            # A signal of another multiplexer page is not in this frame. A NaN is in no range.
            if name in values and not low <= values[name] <= high and (valid is None or values.get(valid)):
                return self._refuse("out_of_range")
        lost = self._counted(plan, values, at)
        if lost is None:
            return []
        return self._take(plan, values, at, lost)

    def counters(self) -> dict[str, Counted]:
        """How far the counters are, by message."""
        return {
            plan.message.name: Counted(plan.last_count, plan.last_at, plan.period_s())
            for plan in self._plans.values()
            if plan.last_count is not None
        }

    def resume(self, counters: Mapping[str, Counted]) -> None:
        """Count on from where an earlier decoder was: what was lost in between is told by the first frame of each."""
        for plan in self._plans.values():
            plan.before = counters.get(plan.message.name)

    def silent_s(self, at: float) -> float | None:
        """Seconds since the balancer's last heartbeat, or since any of its frames where none is mapped; None: never."""
        return None if self.heard_at == -math.inf else max(at - self.heard_at, 0.0)

    # ------------------------------------------------------------ frames
    def _refuse(self, reason: str) -> list[Vector | Masses]:
        self.counts[reason] += 1
        self.refused += reason != "foreign"
        return []

    def _masked(self, identifier: int, extended: bool) -> tuple[int, bool]:
        if extended and self.mapping.node is not None:
            mine = identifier & 0xFF == self.mapping.node
            return (identifier & NODE_MASK if mine else -1, True)
        return (identifier, extended)

    def _counted(self, plan: MessagePlan, values: Mapping[str, Any], at: float) -> int | None:
        """How many frames were lost before this one; None for one that is not new."""
        if plan.counter is None:
            return 0
        count = int(values[plan.counter])
        behind = 0 if plan.last_count is None else (count - plan.last_count) % plan.modulus
        if plan.last_count is None or at - plan.last_at > self.mapping.max_age_s:
            # First, or first after a silence: how many were missed cannot be told, unless the last one was noted.
            behind = 1 if plan.before is None else self._since(plan.before, plan, count, at)
            plan.first_at, plan.counted, plan.before = at, -behind, None
        elif behind == 0:
            self._refuse("doubled")
            return None
        elif behind > plan.modulus // 2:
            if plan.late_count is None or (plan.late_count + 1) % plan.modulus != count:
                plan.late_count = count
                self._refuse("late")
                return None
            behind = 1  # two in a row behind: the balancer began to count anew
        plan.last_count, plan.last_at, plan.late_count = count, at, None
        plan.counted += behind
        self.lost_frames += behind - 1
        return behind - 1

    def _since(self, before: Counted, plan: MessagePlan, count: int, at: float) -> int:
        """Frames since the one noted before; whole turns of the counter are told by the time, where its step is known.

        After a long time nothing is said: the balancer may have been off as well.
        """
        away = at - before.at
        if away > LONGEST_UNREAD_S:
            return 1
        behind = (count - before.count) % plan.modulus
        if before.period_s:
            behind += plan.modulus * max(round((away / before.period_s - behind) / plan.modulus), 0)
        self.lost_unread += max(behind - 1, 0)
        return max(behind, 1)

    def _take(self, plan: MessagePlan, values: Mapping[str, Any], at: float, lost: int) -> list[Vector | Masses]:
        if plan.alive:
            self.heard_at = at
        if plan.status is not None and (state := values.get(plan.status.name)) is not None:
            self.status = _state(plan.status, int(state))
        for signal in plan.signals:
            raw = values.get(signal.name)
            if raw is None:
                continue
            holds = signal.valid is None or values.get(signal.valid)
            if signal.slot[1] in PAIRED and signal.slot in self._values:
                self._refuse("unpaired")
            self._values[signal.slot] = (raw * signal.factor if holds else None, at)
        if plan.planes:
            return self._corrections()
        out: list[Vector | Masses] = []
        for sensor in plan.sensors:
            if lost and plan.message.name == sensor.amplitude.message:
                self._lost[sensor.name] = self._lost.get(sensor.name, 0) + lost
            vector = self._vector(sensor, at)
            if vector is not None:
                out.append(vector)
        return out

    # ------------------------------------------------------------ what frames complete
    def _vector(self, sensor: SensorMap, at: float) -> Vector | None:
        name, values = sensor.name, self._values
        amplitude = values.get((name, "amplitude"))
        phase = values.get((name, "phase"))
        if amplitude is None or (sensor.phase is not None and phase is None):
            return None
        del values[name, "amplitude"]
        if phase is not None:
            del values[name, "phase"]
        if amplitude[0] is None or not 0.0 <= amplitude[0] <= MOST:
            self._refuse("not_valid" if amplitude[0] is None else "out_of_range")
            return None
        speed = self._recent(SPEED, at)
        return Vector(
            sensor=name,
            amplitude=amplitude[0],
            phase_deg=None if phase is None or phase[0] is None else _turned(phase[0]),
            speed_rpm=speed or None,  # a drum that stands has none
            overall_rms=self._recent((name, "overall"), at),
            lost=self._lost.pop(name, 0),
        )

    def _recent(self, slot: tuple[str, str], at: float) -> float | None:
        """A value that still holds; an old one is none."""
        value = self._values.get(slot)
        if value is None or value[0] is None or at - value[1] > self.mapping.max_age_s:
            return None
        return value[0] if 0.0 <= value[0] <= MOST else None

    def _corrections(self) -> list[Vector | Masses]:
        """The balancer's answer, once all planes have it and it is a new one."""
        masses, numbers = [], set()
        for plane in self.mapping.corrections:
            found = [self._values.get((plane.plane, key), (None, 0.0))[0] for key in ("mass", "angle", "number")]
            mass, angle, number = found
            if mass is None or angle is None or number is None:
                return []
            numbers.add(number)
            masses.append((plane.plane, mass, _turned(angle)))
        if len(numbers) != 1 or (answer := numbers.pop()) == self._answer:
            return []
        self._answer = answer
        return [Masses(tuple(masses))]


def _state(signal: Signal, value: int) -> str:
    """A status in the words of the DBC, else as a number."""
    return str(signal.choices.get(value, value)) if signal.choices else str(value)


def _turned(degrees: float) -> float:
    """0 <= angle < 360."""
    turned = degrees % 360.0
    return 0.0 if turned >= 360.0 else turned
