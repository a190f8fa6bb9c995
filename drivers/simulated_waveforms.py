"""The simulated drum as a source of raw waveforms: its readings come through the whole signal chain."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime

import numpy as np

from drivers.block_driver import BlockDriver, TimedBlock
from drivers.checks import require
from drivers.clock import Clock
from drivers.drum import DrumSpec, FittedMass, unbalance_of
from drivers.signal.chain import Settings
from drivers.waveform import Disturbance, simulate_block


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
        self._last: datetime | None = None

    def fit_masses(self, masses: Iterable[FittedMass]) -> None:
        """State all pieces that are bolted on now, from the next block on. Raises `InvalidSetting`."""
        pieces = tuple(masses)
        for piece in pieces:
            unbalance_of(self.spec, piece)
        self._masses = pieces

    def _next_block(self) -> TimedBlock | None:
        moment = self.clock.now()
        if self._last is not None:
            moment = max(moment, self._last)  # a wall clock may be set back, readings may not
        self._last = moment
        block = simulate_block(
            self.spec,
            self._masses,
            seconds=self._block_s,
            sample_rate_hz=self._sample_rate_hz,
            rng=self._rng,
            disturbance=self._disturbance,
        )
        return None if self.clock.wait(self._closed, self._block_s) else TimedBlock(moment, block)
