"""A key-phasor that was sampled: taken from 5 samples a turn on, and its own error is in the stated scatter."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.signal.block import Block, Channel
from drivers.signal.chain import Measured, measure
from drivers.signal.edges import find_edges
from drivers.signal.integrity import integrity_of

CHANNELS = (Channel("P", detection="peak", raw_quantity="velocity", raw_unit="mm/s"),)
LAG_DEG, HZ, TURNS = 70.0, 10.0, 20


def block(seed: int, per_turn: float, *, noise: float = 0.0, duty: float = 0.2, limit: float = math.inf) -> Block:
    """A sine of 1 mm/s with a step pulse a turn, both sampled `per_turn` times a turn."""
    rng = np.random.default_rng(seed)
    times = np.arange(int((TURNS + 1) * per_turn)) / (HZ * per_turn)
    turned = HZ * times - rng.uniform()
    samples = np.cos(math.tau * turned - math.radians(LAG_DEG)) + noise * rng.standard_normal(len(times))
    pulses = np.where(turned % 1.0 < duty, 5.0, 0.0)
    edges = find_edges(pulses, HZ * per_turn)
    return Block(CHANNELS, np.clip(samples, -limit, limit)[None], HZ * per_turn, edges, 1.0 / (HZ * per_turn))


def one(found: Block) -> Measured:
    (got,) = measure(found)
    assert isinstance(got, Measured), got
    return got


@pytest.mark.parametrize("duty", [0.2, 0.5])
@pytest.mark.parametrize("per_turn", [5.0, 6.37, 8.0, 10.21, 15.0, 20.01, 24.0, 27.3, 50.0])
def test_a_faultless_pulse_is_taken_from_five_samples_a_turn_on(per_turn: float, duty: float) -> None:
    for seed in range(8):
        got = one(block(seed, per_turn, noise=0.001, duty=max(duty, 1.01 / per_turn)))
        assert got.speed_rpm == pytest.approx(60.0 * HZ, rel=0.02)
        assert "edges_repaired" not in got.flags


@pytest.mark.parametrize("per_turn", [8.0, 20.0, 50.0, 50.3, 200.0])
def test_the_stated_scatter_holds_the_error_of_the_edges(per_turn: float) -> None:
    ratios = []
    for seed in range(60):
        got = one(block(seed, per_turn, noise=0.007))
        error = got.amplitude * np.exp(1j * math.radians(got.phase_deg)) - np.exp(1j * math.radians(LAG_DEG))
        assert got.scatter is not None
        ratios.append(abs(error) / (math.sqrt(2.0) * got.scatter))
    assert 0.3 <= float(np.sqrt(np.mean(np.square(ratios)))) <= 1.4
    assert float(np.mean(np.array(ratios) > 1.73)) <= 0.12


@pytest.mark.parametrize("per_turn", [25.5, 32.0, 63.99, 64.0, 64.3, 128.0])
@pytest.mark.parametrize("limit", [0.95, 0.8, 0.6])
def test_clipping_is_seen_where_the_sampling_keeps_to_the_turn(per_turn: float, limit: float) -> None:
    for seed in range(6):
        assert integrity_of(block(seed, per_turn, noise=0.0014, limit=limit).samples[0]).clipped > 0
        assert integrity_of(block(seed, per_turn, noise=0.0014).samples[0]).clipped == 0


@pytest.mark.parametrize("steps", [50, 205, 2000])
@pytest.mark.parametrize("per_turn", [64.0, 200.3, 500.3, 2000.0])
def test_coarse_steps_are_no_clipping_and_clipping_is_seen_in_coarse_steps(per_turn: float, steps: int) -> None:
    for seed in range(4):
        samples = block(seed, per_turn, noise=0.0014).samples[0]
        assert integrity_of(np.round(samples * steps) / steps).clipped == 0
        cut = np.round(np.clip(samples, -0.8, 0.8) * steps) / steps
        assert integrity_of(cut).clipped > 0
