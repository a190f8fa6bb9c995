"""Frames to readings: strict about identifier, range, sequence and age; what is refused is counted, not raised.

A frame may be longer than its message or shorter, as long as all mapped signals are in it; a value that stands for
none, or that nothing vouches for, gives no reading.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from drivers.can.j1939 import ADDRESS_CLAIMED, CONNECTION, TRANSFER, Node, Transfers, group_of
from drivers.can.mapping import CanMapping, SensorMap
from drivers.can.message_plan import PAIRED, SPEED, CounterState, MappedSignal, MessagePlan, group_key, plans_of
from drivers.can.refusals import FOREIGN, REASONS

MAX_UNREAD_S = 600.0
MOST = 1e9
"""Highest amplitude, overall value and speed of a reading."""
MAX_ROUTES = 10_000
"""Identifiers whose plan is remembered: a bus has hundreds, one that is disturbed any."""
KEPT_FOREIGN = 20
"""Foreign identifiers that are remembered, to tell the user what is on the bus."""

ANSWER_S = 2.0
"""Frames of one answer come within this time."""
AGAIN_S = 60.0
"""An answer that is equal to the one before is that one, said again, within this time; later it is of another job."""

Value = tuple[float | None, float, str]
"""A value, when it came, and why it is none."""


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
        self.foreign: dict[tuple[int, bool], int] = {}
        """How often some of the identifiers came that the mapping does not name."""
        self._plans = plans_of(mapping)
        self._routes: dict[tuple[int, bool], MessagePlan | None] = {}
        self._grouped = any(plan.by_group for plan in self._plans.values())
        self._node = Node(None if mapping.node_name is not None else mapping.node, mapping.node_name)
        groups = {group_of(p.message.frame_id) for p in self._plans.values() if p.by_group and p.whole > 8}
        self._transfers = Transfers(groups) if groups else None
        self._values: dict[tuple[str, str], Value] = {}
        self._lost: dict[str, int] = {}
        self._answer_at = 0.0
        self._answer: tuple[float, tuple[tuple[str, float, float], ...]] | None = None

    def feed(
        self,
        identifier: int,
        extended: bool,
        data: bytes | bytearray | memoryview,
        at: float,
        *,
        is_data: bool = True,
    ) -> list[Vector | Masses]:
        """Take a frame and return what it completes: nothing, a vector, several where a message has several sensors.

        Never raises: whatever a frame holds, it is counted under its reason.
        """
        self.frames += 1
        key = (identifier, extended)
        try:
            plan = self._routes[key] if key in self._routes else self._route(key)
            if plan is None:
                return self._other(key, data, at)
            if plan.by_group and not self._node.takes(identifier & 0xFF, at, self.mapping.heartbeat_timeout_s):
                return self._refuse("other_node" if self._node.found else "foreign")
            if not is_data:
                return self._refuse("not_data")
            return self._read(plan, data, at)
        except Exception:  # a fault of this code must not end the reading of a bus
            return self._refuse("undecodable")

    def plan_of(self, identifier: int, extended: bool) -> MessagePlan | None:
        """What is read from frames with this identifier; None: nothing."""
        key = (identifier, extended)
        return self._routes[key] if key in self._routes else self._route(key)

    def counters(self) -> dict[str, CounterState]:
        """How far the counters are, by message."""
        return {
            plan.message.name: CounterState(plan.last_count, plan.last_at, plan.period_s())
            for plan in self._plans.values()
            if plan.last_count is not None
        }

    def resume(self, counters: Mapping[str, CounterState]) -> None:
        """Count on from where an earlier decoder was: what was lost in between is told by the first frame of each."""
        for plan in self._plans.values():
            plan.before = counters.get(plan.message.name)

    def silent_s(self, at: float) -> float | None:
        """Seconds since the balancer's last heartbeat, or since any of its frames where none is mapped; None: never."""
        return None if self.heard_at == -math.inf else max(at - self.heard_at, 0.0)

    # ------------------------------------------------------------ frames
    def _refuse(self, reason: str) -> list[Vector | Masses]:
        self.counts[reason] += 1
        self.refused += reason not in FOREIGN
        return []

    def _route(self, key: tuple[int, bool]) -> MessagePlan | None:
        """The plan of an identifier, by itself or by its group."""
        plan = self._plans.get(key)
        if plan is None and key[1] and self._grouped:
            plan = self._plans.get(group_key(key[0]))
        if len(self._routes) < MAX_ROUTES:
            self._routes[key] = plan
        return plan

    def _other(self, key: tuple[int, bool], data: bytes | bytearray | memoryview, at: float) -> list[Vector | Masses]:
        """A frame that no message of the mapping has: of a node's name, a part of a longer message, or foreign."""
        identifier, extended = key
        group = group_of(identifier) if extended and self._grouped else -1
        if group == ADDRESS_CLAIMED and len(data) >= 8:
            self._node.claimed(identifier & 0xFF, int.from_bytes(data[:8], "little"))
        elif group in (CONNECTION, TRANSFER) and self._transfers is not None:
            return self._part(identifier, bytes(data), at)
        if key in self.foreign or len(self.foreign) < KEPT_FOREIGN:
            self.foreign[key] = self.foreign.get(key, 0) + 1
        return self._refuse("foreign")

    def _part(self, identifier: int, data: bytes, at: float) -> list[Vector | Masses]:
        assert self._transfers is not None  # noqa: S101
        broken = self._transfers.broken
        whole = self._transfers.take(identifier, data, at)
        for _ in range(self._transfers.broken - broken):
            self._refuse("incomplete")
        if whole is None:
            return []
        self.frames -= 1  # the message counts once, for its last part
        return self.feed(whole[0], True, whole[1], at)

    def _read(self, plan: MessagePlan, data: bytes | bytearray | memoryview, at: float) -> list[Vector | Masses]:
        if len(data) < plan.whole and not plan.fits(data):
            return self._refuse("wrong_length")
        found: list[tuple[MappedSignal, Value]] = []
        whole = int.from_bytes(data, "little")  # once for all signals that lie in this order
        for mapped in plan.signals:
            signal = mapped.signal
            if signal.plain:
                bits = whole >> signal.place & signal.mask
                raw: float = bits - ((bits & signal.sign) << 1)
            elif signal.shown(data):
                raw = signal.raw(data)
            else:
                continue  # on another page
            value = raw * signal.scale + signal.offset
            flag = mapped.flag
            if flag is not None and not flag.holds(whole, data):
                found.append((mapped, (None, at, "not_valid")))
            elif raw in mapped.missing or raw >= mapped.missing_from or raw != raw:
                found.append((mapped, (None, at, "not_available")))
            elif mapped.low <= value <= mapped.high:
                found.append((mapped, (value * mapped.factor, at, "")))
            else:
                return self._refuse("out_of_range")
        lost = self._counted(plan, data, at)
        return [] if lost is None else self._take(plan, data, found, at, lost)

    def _counted(self, plan: MessagePlan, data: bytes | bytearray | memoryview, at: float) -> int | None:
        """How many frames were lost before this one; None for one that is not new."""
        counter = plan.counter
        if counter is None or (counter.pages and not counter.shown(data)):
            return 0  # nothing counts this message, or this page of it
        count = int(counter.raw(data)) % plan.modulus
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

    def _since(self, before: CounterState, plan: MessagePlan, count: int, at: float) -> int:
        """Frames since the one noted before; whole turns of the counter are told by the time, where its step is known.

        After a long time nothing is said: the balancer may have been off as well.
        """
        away = at - before.at
        if away > MAX_UNREAD_S:
            return 1
        behind = (count - before.count) % plan.modulus
        if before.period_s:
            behind += plan.modulus * max(round((away / before.period_s - behind) / plan.modulus), 0)
        self.lost_unread += max(behind - 1, 0)
        return max(behind, 1)

    def _take(
        self,
        plan: MessagePlan,
        data: bytes | bytearray | memoryview,
        found: list[tuple[MappedSignal, Value]],
        at: float,
        lost: int,
    ) -> list[Vector | Masses]:
        if plan.alive:
            self.heard_at = at
        if plan.status is not None and plan.state_of is not None and plan.status.shown(data):
            self.status = plan.state_of(int(plan.status.raw(data)))
        for mapped, value in found:
            if mapped.slot[1] in PAIRED and mapped.slot in self._values:
                self._refuse("unpaired")
            self._values[mapped.slot] = value
        if plan.planes:
            return self._corrections(at)
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
            self._refuse(amplitude[2] or "out_of_range")
            return None
        if phase is not None and phase[2] == "not_available":
            self.counts["not_available"] += 1  # the amplitude still gives a reading
        speed, overall = self._recent(SPEED, at), self._recent((name, "overall"), at)
        return Vector(
            sensor=name,
            amplitude=amplitude[0],
            phase_deg=None if phase is None or phase[0] is None else _turned(phase[0]),
            speed_rpm=None if speed is None else abs(speed) or None,  # a drum that stands has none
            overall_rms=None if overall is None or overall < 0.0 else overall,
            lost=self._lost.pop(name, 0),
        )

    def _recent(self, slot: tuple[str, str], at: float) -> float | None:
        """A value that still holds; an old one is none."""
        value = self._values.get(slot)
        if value is None or value[0] is None or at - value[1] > self.mapping.max_age_s or abs(value[0]) > MOST:
            return None
        return value[0]

    def _corrections(self, at: float) -> list[Vector | Masses]:
        """The balancer's answer, once all planes have it and it is a new one.

        Only what came together is put together, and each value once: numbers of answers begin anew with each job, so
        that those of two jobs may be equal.
        """
        slots = [[(plane.plane, key) for key in ("mass", "angle", "number")] for plane in self.mapping.corrections]
        for slot in (slot for plane in slots for slot in plane):
            if slot in self._values and at - self._values[slot][1] > ANSWER_S:
                del self._values[slot]
        found = [[self._values.get(slot, (None, 0.0, ""))[0] for slot in plane] for plane in slots]
        masses, numbers = [], set()
        for plane, (mass, angle, number) in zip(self.mapping.corrections, found, strict=True):
            if mass is None or angle is None or number is None:
                return []
            numbers.add(number)
            masses.append((plane.plane, mass, _turned(angle)))
        if len(numbers) != 1:
            return []
        for slot in (slot for plane in slots for slot in plane):
            del self._values[slot]
        answer = (numbers.pop(), tuple(masses))
        again = answer == self._answer and at - self._answer_at <= AGAIN_S
        self._answer, self._answer_at = answer, at
        if again:
            return []
        return [Masses(answer[1])]


def _turned(degrees: float) -> float:
    """0 <= angle < 360."""
    turned = degrees % 360.0
    return 0.0 if turned >= 360.0 else turned
