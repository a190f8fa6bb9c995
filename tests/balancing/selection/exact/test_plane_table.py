"""Sums in a grid: what lies in an ellipse is read off a few rows of cells, and nothing is lost."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.selection.exact.plane_table import Ellipse, Reading, length2, table_of
from tests.support.numerics.steps import finished


@given(
    seed=st.integers(0, 2**32 - 1),
    points=st.integers(1, 60),
    spread=st.sampled_from([0.0, 1e-6, 1.0, 300.0]),
    stretch=st.sampled_from([0.01, 1.0, 30.0]),
    radius=st.sampled_from([1e-6, 0.5, 100.0]),
)
def test_the_windows_hold_all_that_lies_in_an_ellipse(
    seed: int, points: int, spread: float, stretch: float, radius: float
) -> None:
    rng = np.random.default_rng(seed)
    vector = np.asarray(5.0 + spread * (rng.normal(size=points) + 1j * rng.normal(size=points)), np.complex128)
    table = finished(table_of(np.arange(points)[:, None], vector))
    np.testing.assert_array_equal(vector[table.index[:, 0]], table.vector)  # rows and sums went together
    asked = np.append(rng.choice(vector, 3), np.asarray(5.0 + 2.0 * spread * rng.normal(size=2), np.complex128))
    ellipse = Ellipse(0j, np.array([[1.0, rng.normal()], [0.0, stretch]]), radius)
    whose, begin, end = table.windows(asked, Reading.of(ellipse, table.margin))
    found = {(int(w), k) for w, b, e in zip(whose, begin, end, strict=True) for k in range(b, e)}
    assert len(found) == int((end - begin).sum())  # no point twice for one question
    for w, z in enumerate(asked):
        inside = np.flatnonzero(ellipse.distance(table.vector - z) <= radius)
        assert {(w, int(k)) for k in inside} <= found


def test_an_ellipse_far_away_touches_nothing() -> None:
    vector = np.asarray(np.linspace(0.0, 1.0, 50) * (1 + 1j), np.complex128)
    table = finished(table_of(np.arange(50)[:, None], vector))
    reading = Reading.of(Ellipse(0j, np.eye(2), 0.1), table.margin)
    for far in (10.0 + 0j, -10.0 + 0j, 10j, -10j):
        assert len(table.windows(np.array([far]), reading)[0]) == 0


def test_a_small_ellipse_reads_few_points() -> None:
    """10,000 points in a square: a hundredth of its side holds about 3, its window not many more."""
    rng = np.random.default_rng(3)
    vector = rng.uniform(size=10_000) + 1j * rng.uniform(size=10_000)
    table = finished(table_of(np.arange(10_000)[:, None], vector))
    _whose, begin, end = table.windows(np.array([0.5 + 0.5j]), Reading.of(Ellipse(0j, np.eye(2), 0.01), table.margin))
    assert (end - begin).sum() < 20


def test_every_ellipse_may_have_a_reading_of_its_own() -> None:
    vector = np.array([0j, 1 + 0j, 2 + 0j])
    table = finished(table_of(np.arange(3)[:, None], vector))
    reading = Reading(np.array([0.1, 5.0]), np.zeros(2), np.array([0.1, 5.0]))
    whose, begin, end = table.windows(np.array([0j, 0j]), reading)
    many = [int((end - begin)[whose == w].sum()) for w in (0, 1)]
    assert many[0] < many[1] == 3


def test_lengths_are_those_of_the_turned_vectors() -> None:
    turn = np.array([[2.0, 1.0], [0.0, 3.0]])
    np.testing.assert_allclose(length2(turn, np.array([1 + 0j, 1j, 1 + 1j])), [4.0, 1.0 + 9.0, 9.0 + 9.0])
    np.testing.assert_allclose(Ellipse(1 + 0j, turn, 1.0).distance(np.array([2 + 0j])), [2.0])
