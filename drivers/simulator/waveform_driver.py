"""The simulated drum as a source of raw waveforms: its readings come through the whole signal chain."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime

import numpy as np

from drivers.block_driver import BlockDriver, TimedBlock
from drivers.checks import require
from drivers.clock import Clock
from drivers.reading import Reading
from drivers.signal.chain import Settings
from drivers.simulator.faults import NO_FAULTS, Faults
from drivers.simulator.spec import DrumSpec, FittedMass, unbalance_of
from drivers.simulator.waveforms import Disturbance, simulate_block


class SimulatedWaveforms(BlockDriver):
    """A drum that turns and is sampled block by block, each of block_s seconds on the clock; it never ends by itself.

    All randomness comes from `seed`. The phase sense is the drum's, whatever the settings say.
    """

    def __init__(
        self,
        spec: DrumSpec,
        *,
        seed: int,
        clock: Clock,
        source: str = "sim-waveforms",
        block_s: float = 4.0,
        sample_rate_hz: float = 2560.0,
        disturbance: Disturbance | None = None,
        settings: Settings | None = None,
        sequence_start: int = 1,
        session_id: str | None = None,
    ) -> None:
        stated = replace(settings or Settings(), phase_sense=spec.phase_sense)
        super().__init__(source, settings=stated, sequence_start=sequence_start, session_id=session_id)
        require(0.0 < block_s <= 3600.0, f"block_s {block_s}", "be above 0 and at most 3600")
        self.spec = spec
        self.clock = clock
        self._block_s = block_s
        self._sample_rate_hz = sample_rate_hz
        self._disturbance = disturbance or Disturbance()
        self._rng = np.random.default_rng(seed)
        self._masses: tuple[FittedMass, ...] = ()
        self._speed_rpm = spec.speed_rpm
        self._run = 1
        self._last: datetime | None = None

    def fit_masses(self, masses: Iterable[FittedMass]) -> None:
        """State all pieces that are bolted on now, from the next block on. Raises `InvalidSetting`."""
        pieces = tuple(masses)
        for piece in pieces:
            unbalance_of(self.spec, piece)
        self._masses = pieces
        self.new_run()

    def set_speed(self, speed_rpm: float) -> None:
        """Turn at this speed from the next block on; raises `InvalidSetting` unless it is a number above 0."""
        require(math.isfinite(speed_rpm) and speed_rpm > 0.0, f"speed {speed_rpm} rpm", "be a number above 0")
        self._speed_rpm = speed_rpm

    def set_faults(self, faults: Faults) -> None:
        """Refuse faults: they are those of readings, and a waveform has its own (see `Disturbance`)."""
        require(faults == NO_FAULTS, "faults of a drum that makes waveforms", "be none: simulate readings for them")

    def new_run(self) -> None:
        """Count a run."""
        self._run += 1

    @property
    def masses(self) -> tuple[FittedMass, ...]:
        """The pieces bolted on, as stated."""
        return self._masses

    @property
    def speed_rpm(self) -> float:
        """Nominal speed."""
        return self._speed_rpm

    @property
    def faults(self) -> Faults:
        """None."""
        return NO_FAULTS

    @property
    def run(self) -> int:
        """Number of the present run, from 1."""
        return self._run

    @property
    def interval_s(self) -> float:
        """Seconds from one round of readings to the next: a block."""
        return self._block_s

    def measure(self, readings_per_sensor: int) -> list[Reading]:
        """Take this many blocks without waiting: a reading of each sensor from each, fewer where one is refused.

        Raises `DriverClosed` when not open and `InvalidSetting` for a count below 1.
        """
        self._require_open()
        require(readings_per_sensor >= 1, f"readings_per_sensor {readings_per_sensor}", "be 1 or more")
        for _ in range(readings_per_sensor):
            self._take(self._block())
        found, self._waiting = list(self._waiting), deque()
        return [self._accept(one) for one in found]

    def _next_block(self) -> TimedBlock | None:
        timed = self._block()
        return None if self.clock.wait(self._closed, self._block_s) else timed

    def _block(self) -> TimedBlock:
        moment = self.clock.now()
        if self._last is not None:
            moment = max(moment, self._last)  # a wall clock may be set back, readings may not
        self._last = moment
        block = simulate_block(
            replace(self.spec, speed_rpm=self._speed_rpm),
            self._masses,
            seconds=self._block_s,
            sample_rate_hz=self._sample_rate_hz,
            rng=self._rng,
            disturbance=self._disturbance,
        )
        return TimedBlock(moment, block)
