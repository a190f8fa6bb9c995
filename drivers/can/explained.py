"""What each frame says by a mapping, and why it gives no reading: for people who check a mapping against bus or log.

The decoder that reads a bus says only how often each reason came. Here every mapped signal of a frame is shown with its
raw number, its value and what is wrong with it; tests hold both against each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from drivers.can.decoder import FrameDecoder, Masses, Vector
from drivers.can.mapping import CanMapping
from drivers.can.message_plan import MappedSignal, MessagePlan


@dataclass(frozen=True, slots=True)
class Shown:
    """A mapped signal in a frame. target: what it is of (P amplitude). why: reason for which it is no value, or empty.

    value: in the unit of the reading (unit), where it is one.
    """

    name: str
    target: str
    raw: float
    value: float
    unit: str
    why: str


@dataclass(frozen=True, slots=True)
class Explained:
    """A frame of the balancer, or one that would be. message: of the mapping; None: of none of its messages.

    reasons: for which it gave no reading or only a part of one. found: what it completed.
    """

    at: float
    identifier: int
    extended: bool
    data: bytes
    message: str | None
    signals: tuple[Shown, ...]
    reasons: tuple[str, ...]
    found: tuple[Vector | Masses, ...] = field(default=())


class Explainer:
    """Feeds a decoder and tells of each frame what became of it."""

    def __init__(self, mapping: CanMapping) -> None:
        self.decoder = FrameDecoder(mapping)
        self._units = _units(mapping)

    def take(self, identifier: int, extended: bool, data: bytes, at: float, *, is_data: bool = True) -> Explained:
        """Decode a frame and explain it."""
        before = dict(self.decoder.counts)
        found = self.decoder.feed(identifier, extended, data, at, is_data=is_data)
        reasons = tuple(reason for reason, count in self.decoder.counts.items() if count > before[reason])
        plan = self.decoder.plan_of(identifier, extended)
        return Explained(
            at=at,
            identifier=identifier,
            extended=extended,
            data=bytes(data),
            message=None if plan is None else plan.message.name,
            signals=() if plan is None or not is_data else self._shown(plan, bytes(data)),
            reasons=reasons,
            found=tuple(found),
        )

    def _shown(self, plan: MessagePlan, data: bytes) -> tuple[Shown, ...]:
        whole = int.from_bytes(data, "little")
        return tuple(
            self._signal(one, data, whole)
            for one in plan.signals
            if one.signal.shown(data) and one.signal.needs <= len(data)
        )

    def _signal(self, mapped: MappedSignal, data: bytes, whole: int) -> Shown:
        raw = mapped.signal.raw(data)
        value = mapped.signal.value(raw)
        name, kind = mapped.slot
        return Shown(
            name=mapped.signal.name,
            target=f"{name} {kind}".strip(),
            raw=raw,
            value=value * mapped.factor,
            unit=self._units.get(mapped.slot, ""),
            why=why_none(mapped, raw, value, data, whole),
        )


def why_none(mapped: MappedSignal, raw: float, value: float, data: bytes, whole: int) -> str:
    """The reason for which a signal of a frame is no value, as the decoder has it; empty where it is one."""
    if mapped.flag is not None and (mapped.flag.signal.needs > len(data) or not mapped.flag.holds(whole, data)):
        return "not_valid"
    if raw in mapped.missing or raw >= mapped.missing_from or raw != raw:
        return "not_available"
    return "" if mapped.low <= value <= mapped.high else "out_of_range"


def _units(mapping: CanMapping) -> Mapping[tuple[str, str], str]:
    """The unit of each value as the decoder gives it: that of the machine's sensor stands in the mapping or the DBC."""
    units = {("", "speed"): "r/min"}
    for sensor in mapping.sensors:
        units[sensor.name, "phase"] = "deg"
        for kind in ("amplitude", "overall"):
            units[sensor.name, kind] = sensor.unit
    for plane in mapping.corrections:
        units[plane.plane, "mass"], units[plane.plane, "angle"] = "g", "deg"
    return units
