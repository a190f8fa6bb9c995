"""Permissible unbalance, grade reached, zones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.influence.fit import KNOWN_SCATTER
from service.balancing.rotor.tolerance import Permissible, in_bearing_planes, permissible, reached, vibration_zone
from service.errors import NumericsError

SPAN = np.array([-480.0, 440.0])


def test_permissible_unbalance_as_published() -> None:
    """10 kg, 3000 r/min, G 2.5: 7.958 um and 79.58 g.mm (hofmann-global.com, balancing grades)."""
    found = permissible(2.5, 10.0, 3000.0, SPAN)
    assert found.specific_um == pytest.approx(7.958, abs=5e-4)
    assert found.total_g_mm == pytest.approx(79.58, abs=5e-3)


def test_a_threshing_drum_of_g16() -> None:
    found = permissible(16.0, 120.0, 900.0, SPAN)
    assert found.specific_um == pytest.approx(169.8, abs=0.05)
    assert found.total_g_mm == pytest.approx(20_372, abs=1.0)
    np.testing.assert_allclose(found.bearing_g_mm, found.total_g_mm * np.array([440.0, 480.0]) / 920.0)


@given(st.floats(1.0, 1000.0), st.floats(1.0, 1000.0))
def test_allocation_keeps_the_sum_and_the_bounds(a: float, b: float) -> None:
    found = permissible(6.3, 50.0, 1000.0, np.array([-a, b]))
    share = found.bearing_g_mm / found.total_g_mm
    assert share.sum() == pytest.approx(1.0)
    assert 0.3 - 1e-12 <= share.min() <= 0.5
    assert (share[0] - share[1]) * (b - a) >= 0.0


@given(st.integers(0, 10_000))
def test_bearing_planes_keep_resultant_and_moment(seed: int) -> None:
    rng = np.random.default_rng(seed)
    z, u = rng.uniform(-600.0, 600.0, 3), rng.normal(size=3) + 1j * rng.normal(size=3)
    moved = in_bearing_planes(u, z, SPAN)
    assert moved.sum() == pytest.approx(u.sum())
    assert (moved * SPAN).sum() == pytest.approx((u * z).sum())


def test_grade_reached_with_its_interval() -> None:
    limits = Permissible(100.0, 10_000.0, np.array([5000.0, 5000.0]))
    planes, radius = np.array([-480.0, 440.0]), np.array([330.0, 330.0])
    needed = np.array([7.0, 3.0j])
    found = reached(limits, 16.0, needed, np.eye(4), KNOWN_SCATTER, radius, planes, SPAN)
    np.testing.assert_allclose(found.bearing_g_mm, -330.0 * needed)
    assert found.grade_mm_s == pytest.approx(16.0 * 330.0 * 7.0 / 5000.0)
    # 1 g per component at this radius, about z = 1.96 either side.
    assert found.high - found.grade_mm_s == pytest.approx(1.96 * 330.0 * 16.0 / 5000.0, rel=0.05)
    assert found.low < found.grade_mm_s < found.high
    assert found.within
    assert found.surely
    unknown = reached(limits, 16.0, needed, np.full((4, 4), np.nan), 0, radius, planes, SPAN)
    assert unknown.within
    assert not unknown.surely
    assert np.isnan(unknown.high)


def test_overhung_rotors_are_not_guessed_at() -> None:
    with pytest.raises(NumericsError, match="overhung rotor"):
        permissible(16.0, 120.0, 460.0, np.array([100.0, 500.0]))


@pytest.mark.parametrize(
    ("velocity", "group", "support", "zone"),
    [(1.4, 2, "rigid", "A"), (1.41, 2, "rigid", "B"), (7.1, 2, "flexible", "C"), (11.1, 1, "flexible", "D")],
)
def test_zones(velocity: float, group: int, support: str, zone: str) -> None:
    assert vibration_zone(velocity, group, support) == zone  # type: ignore[arg-type]


def test_zones_need_a_known_group() -> None:
    with pytest.raises(
        NumericsError, match="zones exist for group 1 and 2 on rigid or flexible support, got group 3 on rigid"
    ):
        vibration_zone(1.0, 3, "rigid")  # type: ignore[arg-type]
    with pytest.raises(NumericsError, match="velocity"):
        vibration_zone(float("nan"), 1, "rigid")
