"""A balancer on a CAN bus as a driver: frames in, readings out."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from datetime import UTC, datetime, timedelta

from drivers.base import BaseDriver
from drivers.can.bus import BusAddress, bus_errors
from drivers.can.decoder import FrameDecoder, Masses, Vector
from drivers.can.frames import Frame, Frames, open_frames
from drivers.can.mapping import CanMapping
from drivers.can.message_plan import CounterState
from drivers.can.refusals import in_short
from drivers.clock import Clock
from drivers.reading import Answer, Counter, Mark, Reading

POLL_S = 0.1
"""How long a closed driver goes on waiting for a frame at most."""


class CanDriver(BaseDriver):
    """Readings of a balancer on a CAN bus.

    Times are the host's clock where it moves on, held up by the time that really passed where it is set back. Numbers
    count on by one for each reading and for each that the balancer's counters show to be lost; answers have a count of
    their own. on_answer: called with the balancer's own corrections, on_mark: with how far its counters are, once all
    readings before were given out; both from the thread that iterates. resume: an earlier driver's last mark.
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
        on_mark: Callable[[Mark], None] | None = None,
        resume: Mark | None = None,
        open_with: Callable[[BusAddress], Frames] = open_frames,
    ) -> None:
        super().__init__(source, sequence_start=sequence_start)
        self.address = address
        self.decoder = FrameDecoder(mapping)
        self._clock, self._monotonic, self._open_with = clock, monotonic, open_with
        self._on_answer, self._on_mark = on_answer, on_mark
        self._frames: Frames | None = None
        self._unmarked = False
        self._marks = 0 if resume is None else resume.number
        self._resume(() if resume is None else resume.counters)
        self._sequence = self._answers = sequence_start - 1
        self._waiting: deque[Reading] = deque()
        self._time = SteadyTime(clock, monotonic)

    def bus_state(self) -> str:
        """The balancer as text: its status, its heartbeat, and what was refused."""
        decoder = self.decoder
        silent = decoder.silent_s(self._monotonic())
        words = []
        if silent is None:
            words.append("balancer not heard yet")
        elif silent > decoder.mapping.heartbeat_timeout_s:
            words.append(f"balancer silent for {silent:.0f} s")
        if decoder.status is not None:
            words.append(f"balancer {decoder.status}")
        if any(decoder.counts.values()):
            words.append(in_short(decoder.counts))
        if decoder.lost_frames:
            unread = f" (about {decoder.lost_unread} while nothing read the bus)" if decoder.lost_unread else ""
            words.append(f"frames lost {decoder.lost_frames}{unread}")
        return ", ".join(words)

    def _connect(self) -> None:
        self._frames = self._open_with(self.address)

    def _disconnect(self) -> None:
        frames, self._frames = self._frames, None
        self._count(missed=len(self._waiting))
        self._waiting.clear()
        if frames is not None:
            with suppress(Exception):  # an adapter that is gone cannot be let go of
                frames.close()

    def _next(self) -> Reading | None:
        """Raises `BusUnavailable` where the bus is lost."""
        waiting = self._waiting
        while not waiting:
            if self._unmarked:
                self._mark()
            source = self._frames
            if self._closed.is_set() or source is None:
                return None
            try:
                frames = source.take(POLL_S)
            except Exception:
                if self._closed.is_set():
                    return None  # closed under the wait, by another thread
                with bus_errors(self.address):
                    raise
            self._read(frames)
        try:
            return waiting.popleft()
        except IndexError:
            return None  # closed meanwhile, by another thread

    def _read(self, frames: Sequence[Frame]) -> None:
        decoder = self.decoder
        feed = decoder.feed
        self._time.look()
        for stamp, identifier, extended, data, is_data in frames:
            at = self._monotonic() if stamp is None else stamp
            found = feed(identifier, extended, data, at, is_data=is_data)
            if found:
                self._keep(found, at)
        if frames:
            self._unmarked = self._on_mark is not None
            self._count(refused=decoder.refused - self._refused)

    def _keep(self, found: list[Vector | Masses], at: float) -> None:
        moment = self._time.at(at)
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

    # ------------------------------------------------------------ what a later driver has to know
    def _mark(self) -> None:
        self._unmarked = False
        now, passed = self._clock.now(), self._monotonic()
        counters = tuple(
            Counter(name, one.count, now - timedelta(seconds=passed - one.at), one.period_s)
            for name, one in self.decoder.counters().items()
        )
        self._marks += 1
        if self._on_mark is not None:
            self._on_mark(Mark(self.source, self._marks, counters))

    def _resume(self, counters: Sequence[Counter]) -> None:
        now, passed = self._clock.now(), self._monotonic()
        self.decoder.resume(
            {
                # A clock that was set back meanwhile cannot make a time to come of it.
                one.name: CounterState(one.count, passed - max((now - one.at).total_seconds(), 0.0), one.period_s)
                for one in counters
            }
        )


class SteadyTime:
    """Moments of the monotonic clock as times that never go back.

    The clock's where it is ahead, else the last one and what has really passed since.
    """

    def __init__(self, clock: Clock, monotonic: Callable[[], float]) -> None:
        self._clock, self._monotonic = clock, monotonic
        self._zero = datetime.min.replace(tzinfo=UTC)
        """Time at which the monotonic clock was 0; it only moves on."""

    def look(self) -> None:
        """Look at the clock."""
        self._zero = max(self._zero, self._clock.now() - timedelta(seconds=self._monotonic()))

    def at(self, monotonic_s: float) -> datetime:
        """Time, aware, UTC, of a moment; not before that of an earlier moment."""
        return self._zero + timedelta(seconds=monotonic_s)


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
