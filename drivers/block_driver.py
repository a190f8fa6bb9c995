"""Drivers that take readings from blocks of waveforms: the simulated drum's, and those of files."""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from dataclasses import dataclass
from datetime import datetime

from drivers.base import BaseDriver
from drivers.errors import SignalRefused
from drivers.reading import Reading
from drivers.signal.block import Block
from drivers.signal.chain import Measured, Refusal, Settings, measure


@dataclass(frozen=True, slots=True)
class TimedBlock:
    """A block and the time of its first sample, aware, UTC."""

    taken_at: datetime
    block: Block


def reading_of(
    measured: Measured, *, source: str, sequence: int, taken_at: datetime, session_id: str | None
) -> Reading:
    """State a measurement as the one Reading; harmonics and flags stay behind.

    Numbers are rounded to 9 digits: the last ones depend on how a processor sums, and a block measured again on another
    must give the same reading.
    """
    return Reading(
        source=source,
        sequence=sequence,
        taken_at=taken_at,
        sensor=measured.channel.sensor,
        amplitude=_rounded(measured.amplitude),
        phase_deg=_rounded(measured.phase_deg) % 360.0,
        speed_rpm=_rounded(measured.speed_rpm),
        scatter=_rounded(measured.scatter) if measured.scatter else None,
        overall_rms=_rounded(measured.overall_rms),
        session_id=session_id,
    )


def _rounded(value: float) -> float:
    return float(f"{value:.9g}")


class BlockDriver(BaseDriver):
    """Template of a driver over blocks: a child writes `_next_block`.

    Block number b and channel number c have the sequence number sequence_start + b * channels + c, refused or not: the
    same blocks give the same numbers in every run. A channel that is refused counts as refused; `first_refusal` and
    `last_refusal` tell why, `last_measured` what else there is to know of the last block (harmonics, flags).
    """

    def __init__(
        self,
        source: str,
        *,
        settings: Settings | None = None,
        sequence_start: int = 1,
        session_id: str | None = None,
    ) -> None:
        super().__init__(source, sequence_start=sequence_start)
        self.settings = settings or Settings()
        self.first_refusal: str | None = None
        self.last_refusal: str | None = None
        self.last_measured: tuple[Measured | Refusal, ...] = ()
        self._session_id = session_id
        self._sequence = sequence_start
        self._waiting: deque[Reading] = deque()

    @abstractmethod
    def _next_block(self) -> TimedBlock | None:
        """Wait for the next block; None at the end of the source or when closed meanwhile."""

    def _next(self) -> Reading | None:
        while not self._waiting:
            timed = self._next_block()
            if timed is None:
                return None
            self._take(timed)
        return self._waiting.popleft()

    def _take(self, timed: TimedBlock) -> None:
        first = self._sequence
        self._sequence += len(timed.block.channels)
        try:
            self.last_measured = measure(timed.block, self.settings)
        except SignalRefused as refused:
            self.last_measured = ()
            self._refuse(len(timed.block.channels), str(refused))
            return
        for sequence, outcome in enumerate(self.last_measured, start=first):
            if isinstance(outcome, Refusal):
                self._refuse(1, f"{outcome.channel.sensor}: {outcome.reason}")
            else:
                self._waiting.append(
                    reading_of(
                        outcome,
                        source=self.source,
                        sequence=sequence,
                        taken_at=timed.taken_at,
                        session_id=self._session_id,
                    )
                )

    def _refuse(self, count: int, reason: str) -> None:
        self.first_refusal = self.first_refusal or reason
        self.last_refusal = reason
        self._count(refused=count)
