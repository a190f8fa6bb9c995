"""Which message and signal of a balancer is which reading: a TOML file, checked against its DBC before anything runs.

dbc = "my_balancer.dbc"     # in the same folder; left out: Drumtrue's own balancer.dbc
counter = "Counter"         # the signal that counts frames, in every message that has one
node = 0x21                 # J1939 source address of the balancer, or "any"; left out: the identifiers of the DBC as
                            #   they are, but for those from the null address 0xFE, which stand for any
node_name = 0x8000640000021 # J1939 name of the balancer: its address is the one that it claims
max_age_s = 1.0             # a speed or overall value older than this is not put into a reading
phase_sense = "lag"         # of the machine: what a reading has to state
angle_sense = "against_rotation"

[speed]
message = "Tacho"
signal = "Rev"
unit = "rpm"                # rpm, Hz, rad/s in any usual spelling; left out: the unit of the DBC
valid = "RevOk"             # a signal that is exactly 1 while the value holds; may be left out

[[sensor]]
name = "P"                  # as the machine calls it
unit = "mm/s"               # of the machine's sensor
detection = "rms"
amplitude = {message = "Vib1", signal = "Amp", unit = "in/s", detection = "peak", valid = "AmpOk"}
phase = {message = "Vib1", signal = "Pha", unit = "deg", sense = "lead"}
overall = {message = "Vib1", signal = "Rms"}

[[correction]]
plane = "1"
mass = {message = "Corr1", signal = "Mass", unit = "g"}
angle = {message = "Corr1", signal = "Angle", unit = "deg", sense = "with_rotation"}
number = {message = "Corr1", signal = "Number"}     # counts the answers, so that a set belongs together

[heartbeat]
message = "Alive"
timeout_s = 3.0

[status]
message = "State"
signal = "State"

`valid` may be a table as well: {signal = "Fault", equals = 0}, {signal = "Mode", equals = "Measuring"} (a name of the
DBC's value table), {signal = "Mode", equals = [2, 3]}, {signal = "State", not = 7}, {signal = "Flags", bits = 0x0C,
equals = 0x04} (only these bits are looked at). Any signal may state `not_available`, the raw values that stand for no
value (instead of those that the DBC's value table names and those that J1939 or all bits set tell), and `min` and `max`
in the unit of the DBC (instead of its range).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cantools.database.can import Database, Message

PHASE_SENSES = ("lag", "lead")
ANGLE_SENSES = ("against_rotation", "with_rotation")


@dataclass(frozen=True, slots=True)
class Validity:
    """The signal that vouches for a value, and its raw values that do so; negated: all others do.

    bits: those of the raw value that are compared; None: all.
    """

    signal: str
    values: frozenset[int] = frozenset((1,))
    negated: bool = False
    bits: int | None = None

    def holds(self, raw: float) -> bool:
        """Whether this raw value vouches."""
        shown = int(raw) if self.bits is None else int(raw) & self.bits
        return (shown in self.values) != self.negated

    def example(self, good: bool, length: int) -> int:
        """A raw value of this many bits that vouches, or one that does not."""
        return next((raw for raw in range(1 << min(length, 16)) if self.holds(raw) == good), 0)


@dataclass(frozen=True, slots=True)
class Field:
    """One signal as one number of a reading: `factor` times the signal's value. valid: what vouches for it.

    not_available: raw values that stand for none; None: as the DBC and J1939 say. low, high: range of the signal's
    value; None: the DBC's.
    """

    message: str
    signal: str
    factor: float = 1.0
    valid: Validity | None = None
    not_available: frozenset[int] | None = None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class SensorMap:
    """Signals of one sensor of the machine.

    Factors turn amplitude and overall into its unit and detection (overall: rms), phase into degrees in the machine's
    sense. unit: the sensor's.
    """

    name: str
    amplitude: Field
    phase: Field | None
    overall: Field | None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class PlaneMap:
    """Signals of the balancer's own correction in one plane.

    Factors turn them into g and degrees in the machine's angle sense. number: counts the answers.
    """

    plane: str
    mass: Field
    angle: Field
    number: Field


@dataclass(frozen=True, slots=True)
class CanMapping:
    """A balancer's messages, read. speed: factor turns it into r/min.

    node: J1939 source address; any_node: the first that is heard instead; node_name: the one that claims this name.
    """

    database: Database
    sensors: tuple[SensorMap, ...]
    speed: Field | None
    corrections: tuple[PlaneMap, ...]
    counter: str | None
    node: int | None
    max_age_s: float
    heartbeat: str | None
    heartbeat_timeout_s: float
    status: Field | None
    path: Path | None = None
    any_node: bool = False
    node_name: int | None = None

    def fields(self) -> Iterator[Field]:
        """All mapped signals."""
        for sensor in self.sensors:
            yield from (one for one in (sensor.amplitude, sensor.phase, sensor.overall) if one is not None)
        for plane in self.corrections:
            yield from (plane.mass, plane.angle, plane.number)
        yield from (one for one in (self.speed, self.status) if one is not None)

    def messages(self) -> tuple[Message, ...]:
        """The messages that hold anything mapped, each once."""
        names = {field.message for field in self.fields()} | ({self.heartbeat} if self.heartbeat else set())
        return tuple(message for message in self.database.messages if message.name in names)

    def identifiers(self) -> dict[str, tuple[int, bool]]:
        """Identifier of each message of the DBC by its name, and whether it is extended."""
        return {one.name: (one.frame_id, bool(one.is_extended_frame)) for one in self.database.messages}

    def by_group(self, message: Message) -> bool:
        """Whether frames of a message are told by their J1939 parameter group, whatever priority and address."""
        if not message.is_extended_frame:
            return False
        stated = self.node is not None or self.any_node or self.node_name is not None
        return stated or message.frame_id & 0xFF == 0xFE or message.protocol == "j1939"
