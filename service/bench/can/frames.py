"""Prepared frames of two sensors, and what is measured of how they are taken."""

from __future__ import annotations

import time
from dataclasses import dataclass
from datetime import UTC, datetime

import can

from drivers.can.frames import AT_ONCE, Frame
from drivers.can.mapping_file import standard_mapping
from drivers.can.reader import FLUSH_S
from drivers.can.sender import FrameEncoder
from drivers.reading import Reading

COUNTER_TURNS = 100
SENSORS = ("P", "Q")
MAPPING = standard_mapping(SENSORS)


@dataclass(frozen=True)
class Measured:
    """frames that were sent, stored readings, seconds until all were stored, CPU seconds of the reading process."""

    frames: int
    stored: int
    seconds: float
    cpu_s: float

    @property
    def rate(self) -> float:
        """Frames per second, from the first on the bus to the last in the database."""
        return self.frames / self.seconds


def prepared_frames() -> list[can.Message]:
    """Frames of two sensors whose counters go on where the list begins again."""
    encoder = FrameEncoder(MAPPING)
    found: list[can.Message] = []
    for index in range(256 * COUNTER_TURNS):
        reading = Reading(
            "x", 1, datetime.now(UTC), SENSORS[index % 2], 3.0 + 0.001 * (index % 500), 0.1 * (index % 3600)
        )
        found.append(encoder.reading(reading)[-1])
    return found


class PreparedFrames:
    """Gives prepared frames, `rate` of them a second or as fast as they are taken, this many in all."""

    def __init__(self, messages: list[can.Message], count: int, rate: int | None) -> None:
        self._frames = [(m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in messages]
        self._count, self._rate = count, rate
        self._given = 0
        self.begun = 0.0

    def take(self, timeout_s: float) -> list[Frame]:
        """What came since, as many as a reader hands over at once."""
        if not self._given:
            self.begun = time.perf_counter()
        due = self._count
        if self._rate is not None:
            time.sleep(FLUSH_S)
            due = min(due, int((time.perf_counter() - self.begun) * self._rate))
        upto = min(due, self._given + AT_ONCE)
        if upto == self._given:
            time.sleep(timeout_s)
        at, size = time.monotonic(), len(self._frames)
        given: list[Frame] = [(at, *self._frames[number % size], True) for number in range(self._given, upto)]
        self._given = upto
        return given

    def close(self) -> None:
        """There is no bus to let go of."""
