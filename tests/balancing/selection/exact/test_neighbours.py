"""The search for near pairs against all pairs, over sizes, spreads and radii of very different scale."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.selection.exact.neighbours import Columns


@given(
    seed=st.integers(0, 2**32 - 1),
    points=st.integers(0, 60),
    queries=st.integers(0, 30),
    spread=st.sampled_from([0.0, 1e-6, 0.3, 10.0, 1e4]),
    sized_for=st.sampled_from([1e-3, 0.5, 20.0]),
    radius=st.sampled_from([0.0, 1e-3, 0.5, 1.0, 30.0, 1e5]),
)
def test_finds_exactly_the_near_pairs(
    seed: int, points: int, queries: int, spread: float, sized_for: float, radius: float
) -> None:
    rng = np.random.default_rng(seed)
    around = 100.0 * rng.normal() + 50j * rng.normal()
    where = np.asarray(around + spread * (rng.normal(size=points) + 1j * rng.normal(size=points)), np.complex128)
    asked = np.asarray(
        around + (spread + radius) * (rng.normal(size=queries) + 1j * rng.normal(size=queries)), np.complex128
    )
    radii = radius * rng.choice([0.5, 1.0, 2.0], queries)
    found = [pair for q, p in Columns(where, sized_for).pairs(asked, radii) for pair in zip(q, p, strict=True)]
    wanted = np.argwhere(np.abs(asked[:, None] - where[None, :]) <= radii[:, None])
    assert len(found) == len(set(found))
    assert sorted((int(q), int(p)) for q, p in found) == [(int(q), int(p)) for q, p in wanted]


def test_chunks_cover_everything() -> None:
    """Half a million pairs come in several chunks, none of them lost."""
    where = np.linspace(0.0, 1.0, 800).astype(np.complex128)
    chunks = list(Columns(where, 1.0).pairs(where, np.full(800, 2.0)))
    assert len(chunks) > 3
    assert sum(len(q) for q, _ in chunks) == 800 * 800
