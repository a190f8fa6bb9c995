"""A balancer on a CAN bus as a driver: frames in, readings out."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from datetime import datetime, timedelta

import can

from drivers.base import BaseDriver
from drivers.can_bus import BusAddress, bus_errors, open_bus
from drivers.can_decoder import FrameDecoder, Masses, Vector
from drivers.can_mapping import CanMapping
from drivers.clock import Clock
from drivers.reading import Answer, Reading

POLL_S = 0.1
"""How long a closed driver goes on waiting for a frame at most."""


class CanDriver(BaseDriver):
    """Readings of a balancer on a CAN bus.

    Times are the host's clock where it moves on, held up by the time that really passed where it is set back. Numbers
    count on by one for each reading and for each that the balancer's counters show to be lost; answers have a count of
    their own. on_answer: called with the balancer's own corrections, from the thread that iterates.
    """

    def __init__(
        self,
        address: BusAddress,
        mapping: CanMapping,
        *,
        clock: Clock,
        source: str = "can",
        sequence_start: int = 1,
        monotonic: Callable[[], float] = time.monotonic,
        on_answer: Callable[[Answer], None] | None = None,
        open_with: Callable[[BusAddress], can.BusABC] = open_bus,
    ) -> None:
        super().__init__(source, sequence_start=sequence_start)
        self.address = address
        self.decoder = FrameDecoder(mapping)
        self._clock, self._monotonic, self._on_answer, self._open_with = clock, monotonic, on_answer, open_with
        self._bus: can.BusABC | None = None
        self._sequence = self._answers = sequence_start - 1
        self._waiting: deque[Reading] = deque()
        self._time = SteadyTime(clock, monotonic)

    def bus_state(self) -> str:
        """The balancer in words: its status, its heartbeat, and what was refused."""
        decoder = self.decoder
        silent = decoder.silent_s(self._monotonic())
        words = []
        if silent is None:
            words.append("balancer not heard yet")
        elif silent > decoder.mapping.heartbeat_timeout_s:
            words.append(f"balancer silent for {silent:.0f} s")
        if decoder.status is not None:
            words.append(f"balancer {decoder.status}")
        words += [f"{reason} {count}" for reason, count in decoder.counts.items() if count]
        if decoder.lost_frames:
            words.append(f"frames lost {decoder.lost_frames}")
        return ", ".join(words)

    def _connect(self) -> None:
        self._bus = self._open_with(self.address)

    def _disconnect(self) -> None:
        bus, self._bus = self._bus, None
        self._count(missed=len(self._waiting))
        self._waiting.clear()
        if bus is not None:
            bus.shutdown()

    def _next(self) -> Reading | None:
        """Raises `BusUnavailable` where the bus is lost."""
        waiting, decoder = self._waiting, self.decoder
        while not waiting:
            bus = self._bus
            if self._closed.is_set() or bus is None:
                return None
            try:
                message = bus.recv(POLL_S)
            except Exception:
                if self._closed.is_set():
                    return None  # closed under the wait, by another thread
                with bus_errors(self.address):
                    raise
            if message is None:
                continue
            is_data = not (message.is_error_frame or message.is_remote_frame or message.is_fd)
            now = self._monotonic()
            found = decoder.feed(message.arbitration_id, message.is_extended_id, message.data, now, is_data=is_data)
            if found:
                self._keep(found)
            elif decoder.refused != self._refused:
                self._count(refused=decoder.refused - self._refused)
        return waiting.popleft()

    def _keep(self, found: list[Vector | Masses]) -> None:
        moment = self._time.now()
        for one in found:
            if isinstance(one, Masses):
                self._answers += 1
                if self._on_answer is not None:
                    self._on_answer(Answer(self.source, self._answers, moment, one.masses))
                continue
            if one.lost:
                self._sequence += one.lost
                self._count(missed=one.lost)
            self._sequence += 1
            self._waiting.append(reading_of(one, self.source, self._sequence, moment))


class SteadyTime:
    """Times that never go back: the clock's where it is ahead, else the last one and what has really passed since."""

    def __init__(self, clock: Clock, monotonic: Callable[[], float]) -> None:
        self._clock, self._monotonic = clock, monotonic
        self._last: tuple[datetime, float] | None = None

    def now(self) -> datetime:
        """Present time, aware, UTC, not before the one of the last call."""
        moment, passed = self._clock.now(), self._monotonic()
        if self._last is not None:
            moment = max(moment, self._last[0] + timedelta(seconds=max(passed - self._last[1], 0.0)))
        self._last = (moment, passed)
        return moment


def reading_of(vector: Vector, source: str, sequence: int, moment: datetime) -> Reading:
    """A decoded vector as a reading."""
    return Reading(
        source=source,
        sequence=sequence,
        taken_at=moment,
        sensor=vector.sensor,
        amplitude=vector.amplitude,
        phase_deg=vector.phase_deg,
        speed_rpm=vector.speed_rpm,
        overall_rms=vector.overall_rms,
    )
