"""Waveforms written down as formulas: what the chain must find is known before it looks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from drivers.signal.block import Block, Channel, Floats
from drivers.signal.chain import Measured, Refusal, Settings, measure

DRIFTS = (-0.03, 0.0, 0.03)
"""Of the speed over a block, as far as the chain is to stand it."""


@dataclass(frozen=True)
class Tone:
    """Velocity v(t) = sqrt 2 rms (w / w0)^growth cos(angle - lag), mm/s; the block holds its exact derivative, m/s2.

    The speed drifts evenly by `drift` over the block, w0 at its middle. mark: the part of a turn after which the mark
    first passes. harmonics: (order, rms, lag) beside it. neighbour: (order of w0, rms) at a constant frequency.
    snr_db: white noise, so far below the 1x acceleration.
    """

    rms: float = 3.0
    lag_deg: float = 70.0
    hz: float = 7.7
    turns: float = 16.5
    rate: float = 2560.0
    drift: float = 0.0
    growth: float = 0.0
    mark: float = 0.0
    harmonics: tuple[tuple[int, float, float], ...] = ()
    neighbour: tuple[float, float] | None = None
    snr_db: float | None = None

    @property
    def seconds(self) -> float:
        return self.turns / self.hz

    def times(self) -> Floats:
        return np.arange(int(self.seconds * self.rate)) / self.rate

    def angle(self, t: Floats) -> Floats:
        """Angle since the mark passed: int w dt, less its value at `mark`."""
        w0, swing = math.tau * self.hz, self.drift / self.seconds
        return w0 * ((1.0 - self.drift / 2.0) * t + swing * t * t / 2.0) - math.tau * self.mark

    def speed(self, t: Floats) -> Floats:
        return math.tau * self.hz * (1.0 - self.drift / 2.0 + self.drift / self.seconds * t)

    def edges(self) -> Floats:
        """Times at which the angle is a whole number of turns: roots of the quadratic."""
        w0 = math.tau * self.hz
        a, b = w0 * self.drift / self.seconds / 2.0, w0 * (1.0 - self.drift / 2.0)
        c = -math.tau * (self.mark + np.arange(-1, int(1.1 * self.turns) + 2))
        roots = -2.0 * c / (b + np.sqrt(b * b - 4.0 * a * c))
        return np.asarray(roots[(roots >= 0.0) & (roots <= self.times()[-1])])

    def acceleration(self, rng: np.random.Generator | None = None) -> Floats:
        t = self.times()
        one_x = self._derivative(t, 1, self.rms, self.lag_deg)
        out = one_x + sum(self._derivative(t, *harmonic) for harmonic in self.harmonics)
        if self.neighbour is not None:
            w = math.tau * self.hz * self.neighbour[0]
            out = out + math.sqrt(2.0) * self.neighbour[1] * w * np.cos(w * t + 0.6) * 1e-3
        if self.snr_db is not None:
            assert rng is not None
            out = out + rng.standard_normal(len(t)) * one_x.std() * 10.0 ** (-self.snr_db / 20.0)
        return out

    def _derivative(self, t: Floats, order: int, rms: float, lag_deg: float) -> Floats:
        """d/dt of sqrt 2 rms (w / w0)^growth cos(order angle - lag), mm/s, in m/s2."""
        w, w0 = self.speed(t), math.tau * self.hz
        argument = order * self.angle(t) - math.radians(lag_deg)
        size = math.sqrt(2.0) * rms * (w / w0) ** self.growth
        rise = size * self.growth / w * (w0 * self.drift / self.seconds)
        return (rise * np.cos(argument) - size * order * w * np.sin(argument)) * 1e-3

    def block(self, seed: int = 0, channel: Channel | None = None) -> Block:
        samples = self.acceleration(np.random.default_rng(seed))
        return Block((channel or Channel("P"),), samples[None], self.rate, self.edges())


def measured(block: Block, settings: Settings | None = None) -> Measured:
    """The only channel of a block, which must not be refused."""
    (one,) = measure(block, settings)
    assert isinstance(one, Measured), one
    return one


def refused(block: Block, settings: Settings | None = None) -> Refusal:
    """The only channel of a block, which must be refused."""
    (one,) = measure(block, settings)
    assert isinstance(one, Refusal), one
    return one


def with_samples(block: Block, samples: Floats) -> Block:
    """The block with other samples (n,)."""
    return replace(block, samples=samples[None])


def apart(one_deg: float, other_deg: float) -> float:
    """Degrees between two directions, 0 to 180."""
    return abs((one_deg - other_deg + 180.0) % 360.0 - 180.0)


def vector(found: Measured) -> complex:
    """1x vector, lag."""
    return complex(found.amplitude * np.exp(1j * math.radians(found.phase_deg)))
