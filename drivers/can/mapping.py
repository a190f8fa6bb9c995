"""Which message and signal of a balancer is which reading: a TOML file, checked against its DBC before anything runs.

dbc = "my_balancer.dbc"     # beside this file; left out: Drumtrue's own balancer.dbc
counter = "Counter"         # the signal that counts frames, in every message that has one
node = 0x21                 # J1939 source address of the balancer; left out: the identifiers of the DBC as they are
max_age_s = 1.0             # a speed or overall value older than this is not put into a reading
phase_sense = "lag"         # of the machine: what a reading has to state
angle_sense = "against_rotation"

[speed]
message = "Tacho"
signal = "Rev"
unit = "rpm"                # rpm, Hz, rad/s; left out: the unit of the DBC
valid = "RevOk"             # a signal that is 1 while the value holds; may be left out

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
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cantools.database.can import Database, Message

PHASE_SENSES = ("lag", "lead")
ANGLE_SENSES = ("against_rotation", "with_rotation")


@dataclass(frozen=True, slots=True)
class Field:
    """One signal as one number of a reading: `factor` times the signal's value. valid: the signal that vouches."""

    message: str
    signal: str
    factor: float = 1.0
    valid: str | None = None


@dataclass(frozen=True, slots=True)
class SensorMap:
    """Signals of one sensor of the machine.

    Factors turn amplitude and overall into its unit and detection (overall: rms), phase into degrees in the machine's
    sense.
    """

    name: str
    amplitude: Field
    phase: Field | None
    overall: Field | None


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
    """A balancer's messages, read. speed: factor turns it into r/min. node: J1939 source address."""

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
