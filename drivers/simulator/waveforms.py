"""The simulated drum down to its waveforms: what its sensors feel sample by sample, and when its mark passes.

The 1x acceleration follows the mechanics at the speed of each moment (a slow drift: the motion keeps up with it).
Beside it lies what makes up the sensor's `broadband_rms`: harmonics of looseness, the tone of a neighbouring machine,
and bearing noise that swells as the balls pass. Then come noise of the electronics, the range of the input, and a
key-phasor that jitters, misses and bounces.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from drivers.checks import require, require_finite
from drivers.quantities import PER_UNIT
from drivers.signal.block import Block, Channel, Floats
from drivers.simulator.sensors import Sensor, displacement
from drivers.simulator.spec import DrumSpec, FittedMass, motion_of

ORDER_OF = {"displacement": 0, "velocity": 1, "acceleration": 2}
BALL_PASS_ORDER = 3.57
"""Balls over the outer race in a turn: no whole number, so nothing of it is synchronous."""
BEARING_FROM_ORDER, BEARING_TO_HZ = 6.0, 1000.0
SPEED_GRID = 33


@dataclass(frozen=True, slots=True)
class Disturbance:
    """What a block holds besides the drum's own 1x.

    speed_drift: change of the speed over the block as a share of it, even, the nominal speed in the middle.
    harmonics, neighbour, bearing: shares of the sensor's broadband power; together 1, or none of it where the sensor
    has no broadband_rms. neighbour_order: frequency of the neighbour's tone over that of the nominal speed.
    electronics: rms of white noise, m/s2. full_scale: greatest acceleration that the input takes, m/s2; None: any.
    jitter_s: standard deviation of an edge's time. missed, doubled: probability that an edge is lost, or bounces.
    """

    speed_drift: float = 0.0
    harmonics: float = 0.3
    neighbour: float = 0.3
    bearing: float = 0.4
    neighbour_order: float = 1.31
    electronics: float = 0.0
    full_scale: float | None = None
    jitter_s: float = 0.0
    missed: float = 0.0
    doubled: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        shares = (self.harmonics, self.neighbour, self.bearing)
        require(min(shares) >= 0.0 and abs(sum(shares) - 1.0) < 1e-9, f"shares {shares}", "be >= 0 and sum up to 1")
        require(abs(self.speed_drift) <= 0.5, f"speed_drift {self.speed_drift}", "be within -0.5 and 0.5")
        require(self.neighbour_order > 0.0, f"neighbour_order {self.neighbour_order}", "be > 0")
        require(self.electronics >= 0.0, f"electronics {self.electronics}", "be >= 0")
        require(self.full_scale is None or self.full_scale > 0.0, f"full_scale {self.full_scale}", "be > 0")
        require(self.jitter_s >= 0.0, f"jitter_s {self.jitter_s}", "be >= 0")
        for name in ("missed", "doubled"):
            require(0.0 <= getattr(self, name) <= 1.0, f"{name} {getattr(self, name)}", "be a probability")


@dataclass(frozen=True, slots=True, eq=False)
class _Turning:
    """Times (n,) s, turned angle (n,) rad since the axis x was passed, and speed (n,) rad/s, of the drifting drum."""

    times: Floats
    angle: Floats
    speed: Floats


def simulate_block(
    spec: DrumSpec,
    masses: Iterable[FittedMass] = (),
    *,
    seconds: float,
    sample_rate_hz: float,
    rng: np.random.Generator,
    disturbance: Disturbance | None = None,
    speed_rpm: float | None = None,
) -> Block:
    """Sample the drum with these pieces bolted on, at speed_rpm, else at the speed of service.

    Each channel is the acceleration, m/s2, felt by a sensor of the drum, to be stated as that sensor states it. The
    drum starts from a random angle. Raises `InvalidSetting` for a length, rate or speed that is not positive.
    """
    disturbance = disturbance or Disturbance()
    for name, value in (("seconds", seconds), ("sample_rate_hz", sample_rate_hz)):
        require(math.isfinite(value) and value > 0.0, f"{name} {value}", "be a number above 0")
    nominal = (speed_rpm or spec.speed_rpm) * math.tau / 60.0
    start = float(rng.uniform(0.0, math.tau))
    times = np.arange(int(seconds * sample_rate_hz)) / sample_rate_hz
    rise = nominal * disturbance.speed_drift / seconds
    first = nominal * (1.0 - disturbance.speed_drift / 2.0)
    turning = _Turning(times, start + first * times + rise / 2.0 * times**2, first + rise * times)
    pieces = tuple(masses)
    channels, rows = [], []
    for sensor in spec.sensors:
        channels.append(
            Channel(sensor.name, sensor.quantity, sensor.unit, sensor.detection, full_scale=disturbance.full_scale)
        )
        felt = _one_x(spec, pieces, sensor, turning) + _beside(sensor, turning, nominal, disturbance, rng)
        felt = felt + disturbance.electronics * rng.standard_normal(len(times))
        limit = disturbance.full_scale or math.inf
        rows.append(np.clip(felt, -limit, limit))
    passed = math.radians(spec.spin * spec.pickup_deg) - start
    edges = _edges(passed, first, rise, seconds, disturbance, rng)
    return Block(tuple(channels), np.stack(rows), sample_rate_hz, edges)


def _one_x(spec: DrumSpec, masses: tuple[FittedMass, ...], sensor: Sensor, turning: _Turning) -> Floats:
    """Acceleration, m/s2, of the unbalance: Re(p(w) exp(j angle)) with the phasor p of the moment's speed w."""
    low, high = float(turning.speed.min()), float(turning.speed.max())
    speeds = np.linspace(low, high, SPEED_GRID) if high > low else np.array([low])
    phasors = np.array([_phasor(spec, masses, sensor, float(speed)) for speed in speeds])
    real = np.interp(turning.speed, speeds, phasors.real)
    imaginary = np.interp(turning.speed, speeds, phasors.imag)
    return np.asarray(real * np.cos(turning.angle) - imaginary * np.sin(turning.angle), float)


def _phasor(spec: DrumSpec, masses: tuple[FittedMass, ...], sensor: Sensor, speed: float) -> complex:
    motion = motion_of(spec, masses, speed_rpm=speed * 60.0 / math.tau)
    return -(motion.omega**2) * displacement(sensor, motion)


def _beside(
    sensor: Sensor, turning: _Turning, nominal: float, disturbance: Disturbance, rng: np.random.Generator
) -> Floats:
    """Acceleration, m/s2, of all that makes up the sensor's broadband_rms in its own quantity and unit."""
    level = sensor.broadband_rms * PER_UNIT[sensor.quantity][sensor.unit]
    if level == 0.0:
        return np.zeros_like(turning.times)
    power = 2 - ORDER_OF[sensor.quantity]
    out = np.zeros_like(turning.times)
    for order, share in ((2, 0.6), (3, 0.3), (4, 0.1)):
        size = level * math.sqrt(2.0 * disturbance.harmonics * share)
        out += size * (order * turning.speed) ** power * np.cos(order * turning.angle + rng.uniform(0.0, math.tau))
    tone = disturbance.neighbour_order * nominal
    size = level * math.sqrt(2.0 * disturbance.neighbour) * tone**power
    out += size * np.cos(tone * turning.times + rng.uniform(0.0, math.tau))
    return out + level * math.sqrt(disturbance.bearing) * _bearing(turning, power, rng)


def _bearing(turning: _Turning, power: int, rng: np.random.Generator) -> Floats:
    """Bearing noise of rms 1 in the sensor's quantity, differentiated `power` times: band noise that swells.

    It swells as the balls pass; the band lies so high that the swelling reaches no order below 2.
    """
    n = len(turning.times)
    rate = (n - 1) / float(turning.times[-1])
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    low = BEARING_FROM_ORDER * float(turning.speed.mean()) / math.tau
    inside = (frequency >= low) & (frequency <= min(0.95 * BEARING_TO_HZ, 0.4 * rate))
    if not inside.any():
        return np.zeros(n)
    noise = np.fft.irfft(np.where(inside, np.fft.rfft(rng.standard_normal(n)), 0.0), n)
    noise *= 1.0 + 0.5 * np.cos(BALL_PASS_ORDER * turning.angle)
    spectrum = np.fft.rfft(noise / noise.std()) * (1j * math.tau * frequency) ** power
    return np.asarray(np.fft.irfft(spectrum, n), float)


def _edges(
    passed: float, first: float, rise: float, seconds: float, disturbance: Disturbance, rng: np.random.Generator
) -> Floats:
    """Times at which first t + rise t^2 / 2 = passed + a whole turn, then jitter, loss and bounce; in order."""
    last = first * seconds + rise / 2.0 * seconds**2
    turned = passed % math.tau + math.tau * np.arange(int(last / math.tau) + 1)
    turned = turned[turned <= last]
    times = 2.0 * turned / (first + np.sqrt(first**2 + 2.0 * rise * turned))
    times = times + disturbance.jitter_s * rng.standard_normal(len(times))
    kept = times[rng.random(len(times)) >= disturbance.missed]
    bounced = kept[rng.random(len(kept)) < disturbance.doubled]
    bounced = bounced + rng.uniform(0.02, 0.2, len(bounced)) * math.tau / first
    return np.unique(np.concatenate([kept, bounced]))
