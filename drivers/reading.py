"""The one Reading type: on the wire, in a driver, in a recording."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, ClassVar, Final

from annotated_types import Ge, Gt, Le, Len, Timezone

_Text = Annotated[str, Len(1, 100)]

NO_CLOCK: Final = datetime.max.replace(tzinfo=UTC)
"""`taken_at` of a reading whose sender has no clock: the service puts the moment of its receipt in its place."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One sensor at one moment, as its source states it.

    The wire's validator reads the rules and the texts below; the drivers need neither.
    """

    __pydantic_config__: ClassVar[dict[str, Any]] = {
        "strict": True,
        "extra": "forbid",
        "allow_inf_nan": False,
        "use_attribute_docstrings": True,
    }

    source: _Text
    """Who measured."""
    sequence: Annotated[int, Ge(0), Le(2**53 - 1)]
    """A number that the source never uses twice."""
    taken_at: Annotated[datetime, Timezone(...)]
    """When, with its zone (RFC 3339)."""
    sensor: _Text
    """Sensor of the machine."""
    amplitude: Annotated[float, Ge(0), Le(1e9)]
    """1x component in the sensor's declared quantity, unit and detection."""
    phase_deg: Annotated[float, Ge(-360), Le(360)] | None = None
    """Phase, degrees, in the machine's phase sense; null where the source has no key-phasor."""
    speed_rpm: Annotated[float, Gt(0), Le(1e9)] | None = None
    """Speed, r/min."""
    scatter: Annotated[float, Gt(0), Le(1e9)] | None = None
    """Standard deviation of the 1x vector per real component, in the amplitude's unit."""
    overall_rms: Annotated[float, Ge(0), Le(1e9)] | None = None
    """Broadband value beside the 1x amplitude, rms, in the sensor's unit."""
    session_id: str | None = None
    """Session; null for a source that is bound to a machine."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Continuous correction masses that a balancer computed: plane, mass in g, angle in degrees in the machine's sense.

    source and sequence tell answers apart, in the same count as the source's readings.
    """

    source: str
    sequence: int
    taken_at: datetime
    masses: tuple[tuple[str, float, float], ...]


Entry = Reading | Answer
"""What a source has to say."""


@dataclass(frozen=True, slots=True)
class Counter:
    """A counter of a source's frames: its name, the last count, when that came, and the seconds from one to the next.

    period_s: None where too few came to tell.
    """

    name: str
    count: int
    at: datetime
    period_s: float | None


@dataclass(frozen=True, slots=True)
class Mark:
    """How far the counters of a source were when all it said before was read; a later mark has a higher number."""

    source: str
    number: int
    counters: tuple[Counter, ...]
