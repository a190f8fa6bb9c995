"""Waveforms of a turning mark and its vibration, and an estimator, that share nothing with the signal chain.

Angle, speed and vibration are closed forms of time; key-phasors of six kinds are sampled from the angle. The estimator
is a Hann-weighted least-squares fit on the exact angle of the true edges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from drivers.signal.block import Block, Channel, Floats
from drivers.signal.edges import find_edges

CHANNELS = (Channel("P", detection="peak", raw_quantity="velocity", raw_unit="mm/s"),)
TRUE = complex(np.exp(-1j * math.radians(70.0)))
"""1x vector of the vibration at the mean speed, peak 1."""


@dataclass(frozen=True)
class Case:
    """A block. per_turn: samples; growth: exponent of the speed that the amplitude follows; hunting: share, Hz.

    tones: orders of the mean speed, amplitude. tacho: exact, or one of the sampled ones. clock_ppm: by which the
    key-phasor's clock is off that of the samples.
    """

    turns: float = 20.0
    per_turn: float = 50.3
    hz: float = 10.0
    noise: float = 0.01
    drift: float = 0.0
    growth: float = 0.0
    hunting: tuple[float, float] = (0.0, 1.0)
    tones: tuple[tuple[float, float], ...] = ()
    tacho: str = "exact"
    jitter: float = 0.0
    spread: float = 0.0
    limit: float = math.inf
    bits: int = 0
    full_scale: float = 4.0
    clock_ppm: float = 0.0


@dataclass(frozen=True, eq=False)
class Made:
    """The block, and what only the one who made it knows: sample times, samples, exact edges."""

    block: Block
    times: Floats
    samples: Floats
    edges: Floats


def made(case: Case, seed: int) -> Made:
    rng = np.random.default_rng([20260504, seed])
    case = replace(case, per_turn=case.per_turn * (1.0 + case.spread * rng.uniform(-1.0, 1.0)))
    rate = case.per_turn * case.hz
    count = int((case.turns + 1.0) * case.per_turn) + 2
    seconds, first, phase = count / rate, rng.uniform(), rng.uniform(0.0, math.tau)
    share, slow = case.hunting

    def angle(t: Floats) -> Floats:
        even = case.hz * (t + case.drift * (t * t / (2.0 * seconds) - t / 2.0)) - first
        return even - case.hz * share / (math.tau * slow) * (np.cos(math.tau * slow * t + phase) - math.cos(phase))

    def speed(t: Floats) -> Floats:
        return 1.0 + case.drift * (t / seconds - 0.5) + share * np.sin(math.tau * slow * t + phase)

    t = np.arange(count) / rate
    turned = angle(t)
    x = speed(t) ** case.growth * np.cos(math.tau * turned - math.radians(70.0))
    for order, size in case.tones:
        x = x + size * np.cos(math.tau * order * case.hz * t + rng.uniform(0.0, math.tau))
    x = np.clip(x + case.noise * rng.standard_normal(count), -case.limit, case.limit)
    if case.bits:
        step = 2.0 * case.full_scale / 2**case.bits
        x = np.round(x / step) * step
    whole = np.arange(math.ceil(turned[0]), math.floor(turned[-1]) + 1)
    edges = np.interp(whole, turned, t)
    for _ in range(4):
        edges = edges - (angle(edges) - whole) / (case.hz * speed(edges))
    if case.tacho == "exact":
        seen = np.sort(edges + case.jitter / case.hz * rng.standard_normal(len(edges))) * (1.0 + 1e-6 * case.clock_ppm)
        found, step_s = seen[(seen >= 0.0) & (seen <= seconds)], 0.0
    else:
        found, step_s = find_edges(tachometer(case, turned, rng), rate), 1.0 / rate
    return Made(Block(CHANNELS, x[None], rate, found, step_s), t, x, edges)


def tachometer(case: Case, turned: Floats, rng: np.random.Generator) -> Floats:
    """The signal of a pick-up that sees the mark at angle 0: step, noisy, filtered, narrow, slow and sine."""
    place = turned % 1.0
    near = (turned + 0.5) % 1.0 - 0.5
    flank = 2.0 / case.per_turn
    if case.tacho == "step":
        return np.where(place < 0.2, 5.0, 0.0)
    if case.tacho == "noisy":
        return np.where(place < 0.2, 5.0, 0.0) + 0.3 * rng.standard_normal(len(turned))
    if case.tacho == "narrow":
        return np.where(place < 1.2 / case.per_turn, 5.0, 0.0)
    if case.tacho == "filtered":
        fall = (turned - 0.2 + 0.5) % 1.0 - 0.5
        return 5.0 * np.clip(0.5 + near / flank, 0.0, 1.0) * np.clip(0.5 - fall / flank, 0.0, 1.0)
    if case.tacho == "slow":
        return np.asarray(5.0 / (1.0 + np.exp(-8.0 * np.sin(math.tau * place))))
    assert case.tacho == "sine"
    return np.asarray(np.sin(math.tau * place))


def least_squares(one: Made) -> complex:
    """1x vector by least squares on the exact angle, Hann-weighted over whole turns, with two harmonics and a trend."""
    turned = np.interp(one.times, one.edges, np.arange(len(one.edges)), left=-1.0, right=-1.0)
    inside = turned >= 0.0
    angle, place = math.tau * turned[inside], turned[inside] / (len(one.edges) - 1)
    rows = [np.ones_like(angle), place, *(f(k * angle) for k in (1, 2, 3) for f in (np.cos, np.sin))]
    basis, weights = np.stack(rows), 0.5 - 0.5 * np.cos(math.tau * place)
    found = np.linalg.solve((basis * weights) @ basis.T, (basis * weights) @ one.samples[inside])
    return complex(found[2], -found[3])
