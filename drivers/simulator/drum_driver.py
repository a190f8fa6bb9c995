"""The simulated drum: a driver whose readings come from the mechanics of drivers.simulator.rotor.

It knows nothing of influence coefficients or plans: masses are bolted on, it turns, its instruments read.
"""

from __future__ import annotations

import cmath
import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from drivers.base import BaseDriver
from drivers.checks import require
from drivers.clock import Clock
from drivers.reading import Reading
from drivers.simulator.example import STOCK_G, threshing_drum_example
from drivers.simulator.faults import NO_FAULTS, Faults, LooseMass, check_faults
from drivers.simulator.rotor import Bearing, Motion, Rotation, Rotor, Unbalance, steady_motion
from drivers.simulator.sensors import Sensor, overall_rms, sense
from drivers.simulator.spec import (
    AngleSense,
    DrumSpec,
    FittedMass,
    PhaseSense,
    Plane,
    Scatter,
    stated_phase,
    unbalance_of,
)

__all__ = [
    "NO_FAULTS",
    "STOCK_G",
    "AngleSense",
    "Bearing",
    "DrumSpec",
    "Faults",
    "FittedMass",
    "LooseMass",
    "PhaseSense",
    "Plane",
    "Rotation",
    "Rotor",
    "Scatter",
    "Sensor",
    "SimulatedDrum",
    "Unbalance",
    "threshing_drum_example",
]


@dataclass(frozen=True, slots=True)
class _Signal:
    """What a channel shows, before it becomes a reading."""

    amplitude: float
    phase_deg: float
    overall_rms: float


class SimulatedDrum(BaseDriver):
    """A drum that turns, read by its sensors in rounds: one reading of each sensor, then the next round.

    All randomness comes from `seed`, and each round draws the same numbers whatever the faults, so the same seed and
    the same steps give the same readings. Iteration never ends by itself: it waits interval_s on the clock between
    rounds until the drum is closed. `measure` takes rounds without waiting. Safe between threads.
    """

    def __init__(
        self,
        spec: DrumSpec,
        *,
        seed: int,
        clock: Clock,
        source: str = "sim",
        sequence_start: int = 1,
        interval_s: float = 1.0,
        session_id: str | None = None,
    ) -> None:
        super().__init__(source, sequence_start=sequence_start)
        require(math.isfinite(interval_s) and interval_s >= 0.0, f"interval_s {interval_s}", "be >= 0")
        self.spec = spec
        self.interval_s = interval_s
        self.clock = clock
        self._session_id = session_id
        self._rng = np.random.default_rng(seed)
        self._sequence = sequence_start
        self._masses: tuple[FittedMass, ...] = ()
        self._speed_rpm = spec.speed_rpm
        self._faults = NO_FAULTS
        self._shown: dict[str, _Signal] = {}
        self._round: deque[Reading] = deque()
        self._last_time: datetime | None = None
        self._run = 0
        self.new_run()

    # ------------------------------------------------------------ what is done to the drum
    def fit_masses(self, masses: Iterable[FittedMass]) -> None:
        """State all pieces that are bolted on now, in place of those before; the drum stops for it: a new run starts.

        Raises `InvalidSetting` for an unknown plane; then nothing changes.
        """
        pieces = tuple(masses)
        for piece in pieces:
            self.spec.plane(piece.plane)
        with self._lock:
            self._masses = pieces
            self.new_run()

    def set_speed(self, speed_rpm: float) -> None:
        """Turn at this nominal speed from now on; raises `InvalidSetting` unless it is a number above 0."""
        require(math.isfinite(speed_rpm) and speed_rpm > 0.0, f"speed {speed_rpm} rpm", "be a number above 0")
        with self._lock:
            self._speed_rpm = speed_rpm
            self._drop_round()

    def set_faults(self, faults: Faults) -> None:
        """State all faults, in place of those before; raises `InvalidSetting` for an unknown sensor or plane."""
        check_faults(faults, self.spec)
        with self._lock:
            self._faults = faults
            self._drop_round()

    def new_run(self) -> None:
        """Stop and start again: speed drift and run-to-run scatter are drawn anew."""
        scatter, count = self.spec.scatter, len(self.spec.sensors)
        with self._lock:
            self._run += 1
            self._drop_round()
            draws = self._rng.standard_normal(1 + 2 * count)
            self._drift = 1.0 + scatter.run_speed * float(draws[0])
            gains = 1.0 + scatter.run_amplitude * draws[1 : 1 + count]
            turns = np.deg2rad(scatter.run_phase_deg * draws[1 + count :])
            self._run_factors = gains * np.exp(1j * turns)

    # ------------------------------------------------------------ what is known of the drum
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
        """The faults in force."""
        return self._faults

    @property
    def run(self) -> int:
        """Number of the present run, from 1."""
        return self._run

    def measure(self, readings_per_sensor: int) -> list[Reading]:
        """Take rounds at once, without waiting: this many readings of each sensor, fewer where some are lost.

        Raises `DriverClosed` when not open and `InvalidSetting` for a count below 1.
        """
        self._require_open()
        require(readings_per_sensor >= 1, f"readings_per_sensor {readings_per_sensor}", "be 1 or more")
        with self._lock:
            self._drop_round()
            return [self._accept(one) for _ in range(readings_per_sensor) for one in self._take_round()]

    def _disconnect(self) -> None:
        self._drop_round()

    def _drop_round(self) -> None:
        """Forget what was read before a change and not asked for yet; its sequence numbers stay used."""
        with self._lock:
            self._count(missed=len(self._round))
            self._round.clear()

    def _next(self) -> Reading | None:
        while True:
            with self._lock:
                if self._round:
                    return self._round.popleft()
            if self._last_time is not None and self.clock.wait(self._closed, self.interval_s):
                return None
            with self._lock:
                self._round.extend(self._take_round())
            if self._closed.is_set():
                return None

    def _take_round(self) -> list[Reading]:
        """One reading of each sensor, without those that a fault swallows."""
        faults, sensors = self._faults, self.spec.sensors
        lost = self._rng.random(len(sensors)) < faults.dropout
        wander = self._rng.standard_normal(len(self._masses))
        draws = self._rng.standard_normal((len(sensors), 4))
        motion = self._motion(wander)
        moment = self.clock.now()
        if self._last_time is not None:
            moment = max(moment, self._last_time)  # a wall clock may be set back, readings may not
        self._last_time = moment
        readings = []
        for index, sensor in enumerate(sensors):
            signal = self._signal(sensor, motion, complex(self._run_factors[index]), draws[index])
            sequence, self._sequence = self._sequence, self._sequence + 1
            if lost[index] or sensor.name in faults.silent:
                self._count(missed=1)
            else:
                readings.append(self._reading(sequence, moment, sensor.name, signal))
        return readings

    def _motion(self, wander: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Motion:
        unbalances = list(self.spec.unbalances)
        for piece, drawn in zip(self._masses, wander, strict=True):
            unbalances.extend(self._really_fitted(piece, float(drawn)))
        motion = steady_motion(self.spec.rotor, unbalances, self._speed_rpm * self._drift, self.spec.rotation)
        bend = self._faults.bent_shaft
        return motion if bend is None else motion.bent(bend)

    def _really_fitted(self, piece: FittedMass, drawn: float) -> list[Unbalance]:
        """Return the unbalance of a piece where it really sits; none if it fell off."""
        loose = self._faults.loose_trial_mass
        if loose is not None and loose.plane == piece.plane:
            if loose.lost:
                return []
            piece = replace(piece, angle_deg=piece.angle_deg + loose.slip_deg + loose.wander_deg * drawn)
        sense_used = self.spec.angle_sense
        if self._faults.wrong_angle_sense:
            sense_used = "with_rotation" if sense_used == "against_rotation" else "against_rotation"
        return [unbalance_of(self.spec, piece, angle_sense=sense_used)]

    def _signal(
        self, sensor: Sensor, motion: Motion, run_factor: complex, draws: np.ndarray[tuple[int], np.dtype[np.float64]]
    ) -> _Signal:
        """Show the motion at the sensor's place, scattered, and held where the sensor is stuck."""
        faults, scatter = self._faults, self.spec.scatter
        gain = 1.0 + scatter.amplitude * float(draws[0])
        turn = math.radians(scatter.phase_deg * float(draws[1]))
        vector = sense(self._felt_by(sensor), motion) * run_factor * cmath.rect(gain, turn)
        vector += sensor.noise * complex(draws[2], draws[3])
        spec = self.spec
        if faults.pickup_shift_deg:
            spec = replace(spec, pickup_deg=spec.pickup_deg + faults.pickup_shift_deg)
        phase = stated_phase(spec, vector)
        if faults.wrong_phase_sense:
            phase = (360.0 - phase) % 360.0
        signal = _Signal(abs(vector), phase, overall_rms(sensor, abs(vector)))
        if sensor.name in faults.stuck:
            signal = self._shown.get(sensor.name, signal)
        self._shown[sensor.name] = signal
        return signal

    def _felt_by(self, sensor: Sensor) -> Sensor:
        """Return the sensor at the place its cable really leads to."""
        swapped = self._faults.swapped
        if swapped is None or sensor.name not in swapped:
            return sensor
        other_name = swapped[1] if sensor.name == swapped[0] else swapped[0]
        other = next(one for one in self.spec.sensors if one.name == other_name)
        place = {name: getattr(other, name) for name in ("axial_mm", "direction_deg", "axial_arm_mm")}
        return replace(sensor, **place)

    def _reading(self, sequence: int, moment: datetime, sensor: str, signal: _Signal) -> Reading:
        phased = not self._faults.no_key_phasor
        return Reading(
            source=self.source,
            sequence=sequence,
            taken_at=moment,
            sensor=sensor,
            amplitude=signal.amplitude,
            phase_deg=signal.phase_deg if phased else None,
            speed_rpm=self._speed_rpm * self._drift if phased else None,
            overall_rms=signal.overall_rms,
            session_id=self._session_id,
        )
