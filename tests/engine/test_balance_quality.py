"""Balance quality by ISO 21940-11, static and couple parts, and the trial masses that follow from the rotor."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from service.engine import balance_quality as quality
from service.errors import InvalidInput
from tests.support.numerics.drum_log import session

MACHINE = session().machine
PERMISSIBLE = 6.3 / (460.0 * math.pi / 30.0) * 120.0 * 1e3
"""G 6.3 at 460 r/min, 120 kg: 15.7 kg mm."""


def test_nothing_left_is_within_the_grade() -> None:
    found = quality.tolerance_of(MACHINE, np.zeros(2, complex), np.zeros((4, 4)), math.inf)
    assert found is not None
    assert found.permissible_gmm == pytest.approx(PERMISSIBLE)
    assert sum(one.permissible_gmm for one in found.bearings) == pytest.approx(PERMISSIBLE)
    assert [one.residual_gmm for one in found.bearings] == [0.0, 0.0]
    assert found.within
    assert found.assumptions == ("rigid_rotor", "no_bow")


def test_what_is_left_is_carried_to_the_bearings() -> None:
    """100 g at 330 mm in the plane at -330 mm, bearings at -480 and 440 mm: lever rule."""
    found = quality.tolerance_of(MACHINE, np.array([100.0 + 0j, 0j]), np.zeros((4, 4)), math.inf)
    assert found is not None
    left = 33_000.0 * (440.0 + 330.0) / 920.0
    assert [one.residual_gmm for one in found.bearings] == pytest.approx([left, 33_000.0 - left])
    assert not found.within
    share = quality.share_of_permissible(MACHINE)
    assert share is not None
    assert share[0, 0] * 100.0 == pytest.approx(left / found.bearings[0].permissible_gmm)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"balance_grade_mm_s": None}, None),
        ({"rotor_mass_kg": None}, "grade_not_judged.rotor_mass_missing"),
        ({"sensors": ()}, "grade_not_judged.bearings_missing"),
    ],
)
def test_what_is_not_stated_leaves_no_grade_and_says_why(changes: dict[str, object], why: str | None) -> None:
    bare = replace(MACHINE, **changes)  # type: ignore[arg-type]
    assert quality.tolerance_of(bare, np.zeros(2, complex), np.zeros((4, 4)), math.inf) is None
    assert quality.share_of_permissible(bare) is None
    told = quality.tolerance_missing(bare)
    assert (None if told is None else told.key) == why


def test_static_and_couple_parts() -> None:
    """Equal masses in line are static, opposite ones a couple."""
    static = quality.static_couple_of(MACHINE, np.array([50.0 + 0j, 50.0 + 0j]))
    couple = quality.static_couple_of(MACHINE, np.array([50.0 + 0j, -50.0 + 0j]))
    assert static is not None
    assert couple is not None
    assert (static.unbalance_gmm, static.moment_gmm2) == pytest.approx((33_000.0, 0.0), abs=1e-6)
    assert (couple.unbalance_gmm, couple.moment_gmm2) == pytest.approx((0.0, 33_000.0 * 330.0), abs=1e-6)
    one_side = replace(MACHINE, planes=tuple(replace(p, axial_mm=100.0) for p in MACHINE.planes))
    assert quality.static_couple_of(one_side, np.ones(2, complex)) is None


def test_a_trial_mass_is_suggested_for_each_plane() -> None:
    found = quality.trial_masses(MACHINE, None, None)
    assert [one.plane for one in found] == ["1", "2"]
    with pytest.raises(InvalidInput):
        quality.trial_masses(replace(MACHINE, rotor_mass_kg=None), None, None)


def test_each_bearing_carries_its_part() -> None:
    """The mass centre is 480 mm from P and 440 mm from Q."""
    assert quality.carried_kg(MACHINE, 0) == pytest.approx(120.0 * 440.0 / 920.0)
    assert quality.carried_kg(MACHINE, 1) == pytest.approx(120.0 * 480.0 / 920.0)
    nowhere = replace(MACHINE, sensors=tuple(replace(sensor, axial_mm=None) for sensor in MACHINE.sensors))
    assert quality.carried_kg(nowhere, 0) == 60.0
