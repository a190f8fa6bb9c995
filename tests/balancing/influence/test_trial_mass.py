"""Size, angle and force of a trial mass."""

from __future__ import annotations

import numpy as np
import pytest

from service.balancing.influence.trial_mass import centrifugal_force, examine_force, suggest
from service.errors import NumericsError


def test_a_tenth_of_the_static_load() -> None:
    """60 kg on the bearing, 460 r/min, 330 mm: 77 g."""
    found = suggest(60.0, 330.0, 460.0)
    assert found.mass_g == pytest.approx(77.0, abs=0.5)
    assert found.rule == "static_load"
    assert found.force_n == pytest.approx(0.1 * 60.0 * 9.80665)
    assert found.angle is None


def test_the_smallest_rule_decides() -> None:
    assert suggest(60.0, 330.0, 460.0, permissible_g_mm=1000.0).rule == "permissible_unbalance"
    assert suggest(60.0, 330.0, 460.0, permissible_g_mm=1000.0).mass_g == pytest.approx(30.3, abs=0.05)
    assert suggest(60.0, 330.0, 460.0, permissible_g_mm=20_000.0).rule == "static_load"


def test_an_earlier_coefficient_gives_size_and_angle() -> None:
    influence, vibration = np.array([0.02j, 0.005]), np.array([1.0 + 0j, 0.25])
    found = suggest(60.0, 330.0, 460.0, influence=influence, vibration=vibration)
    assert found.rule == "earlier_coefficient"
    assert found.mass_g == pytest.approx(25.0)
    assert found.angle is not None
    moved = vibration + influence * found.mass_g * np.exp(1j * found.angle)
    assert np.linalg.norm(moved) < np.linalg.norm(vibration)


def test_a_large_mass_is_warned_about_with_its_force() -> None:
    """The published experiment used 400 g: about half the static load."""
    finding = examine_force(400.0, 330.0, 460.0, 60.0, plane=1)
    assert finding is not None
    assert finding.severity == "warning"
    assert f"{centrifugal_force(400.0, 330.0, 460.0):.0f} N" in finding.message
    assert "52%" in finding.message
    assert examine_force(suggest(60.0, 330.0, 460.0).mass_g, 330.0, 460.0, 60.0, plane=1) is None


@pytest.mark.parametrize(("load", "radius", "speed"), [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 0.0)])
def test_impossible_rotors_are_refused(load: float, radius: float, speed: float) -> None:
    with pytest.raises(NumericsError):
        suggest(load, radius, speed)
