"""Whatever comes in, the chain measures finite values, refuses in its own words, or raises the documented errors."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.errors import InvalidSetting, SignalRefused
from drivers.signal.block import Block, Channel
from drivers.signal.chain import Measured, Settings, measure
from tests.support.drivers.analytic import Tone

anything = st.floats(allow_infinity=False)
settings_of_any_kind = st.builds(
    Settings,
    phase_sense=st.sampled_from(["lag", "lead"]),
    window=st.sampled_from(["rectangular", "hann", "blackman_harris"]),
    harmonics=st.integers(1, 20),
    accept_clipped=st.booleans(),
)
channels = st.sampled_from(
    [
        Channel("P"),
        Channel("P", "displacement", "um", "peak_to_peak"),
        Channel("P", "acceleration", "g", "rms", "displacement", "mil"),
        Channel("P", raw_unit="g", full_scale=1.0),
    ]
)


def check(block: Block, chosen: Settings) -> None:
    try:
        outcomes = measure(block, chosen)
    except (InvalidSetting, SignalRefused) as error:
        assert str(error)  # noqa: PT017
        return
    for one in outcomes:
        if isinstance(one, Measured):
            numbers = [one.speed_rpm, one.overall_rms, one.scatter or 0.0]
            numbers += [number for c in one.components for number in (c.amplitude, c.phase_deg)]
            assert all(math.isfinite(number) and number >= 0.0 for number in numbers)
            assert all(component.phase_deg < 360.0 for component in one.components)
        else:
            assert one.reason


class TestAnything:
    @given(
        channels,
        st.lists(anything, max_size=80),
        st.lists(st.one_of(st.floats(-1.0, 2.0), anything), max_size=20),
        st.floats(1e-3, 1e5),
        settings_of_any_kind,
    )
    @settings(max_examples=100, deadline=None)
    def test_any_samples_and_edges(
        self, channel: Channel, samples: list[float], edges: list[float], rate: float, chosen: Settings
    ) -> None:
        check(Block((channel,), np.array([samples], float), rate, np.sort(np.array(edges, float))), chosen)

    @given(
        channels,
        st.lists(st.tuples(st.integers(0, 300), st.integers(1, 60), anything), max_size=4),
        st.floats(1e-12, 1e12),
        st.sets(st.integers(0, 15), max_size=3),
        st.floats(1e-4, 1e4),
        settings_of_any_kind,
    )
    @settings(max_examples=100, deadline=None)
    def test_a_good_block_with_damage(
        self,
        channel: Channel,
        hurts: list[tuple[int, int, float]],
        size: float,
        lost_edges: set[int],
        faster: float,
        chosen: Settings,
    ) -> None:
        tone = Tone(rate=154.0)
        samples = tone.acceleration() * size
        for start, length, value in hurts:
            samples[start : start + length] = value
        edges = np.delete(tone.edges(), sorted(lost_edges))
        check(Block((channel,), samples[None], tone.rate * faster, edges / faster), chosen)
