"""Where a linkage turns: dead points to half a degree, wherever they lie between the crank angles that are scanned."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.errors import NumericsError
from service.mechanics.bodies import Body
from service.mechanics.chain import Dyad, Link, Linkage
from service.mechanics.kinematics import CLEAR, corner_cosines, require_turning, turning_intervals

BODY = Body.about_centre(1.0, 0j, 0.1)
CRANK, COUPLER = 0.05, 0.3


def four_bar(ground: float, rocker: float, turned: float = 0.0) -> Linkage:
    """A crank-rocker whose frame lies at an angle: its dead points lie anywhere between scanned angles."""
    axis = complex(math.cos(turned), math.sin(turned))
    links = (
        Link("crank", {"A": 0j, "P": complex(CRANK)}, BODY),
        Link("coupler", {"P": 0j, "J": complex(COUPLER)}, BODY),
        Link("rocker", {"G": 0j, "J": complex(rocker)}, BODY),
    )
    return Linkage({"A": 0j, "G": ground * axis}, "crank", links, (Dyad("J", ("coupler", "rocker"), "left"),))


def with_margin(margin: float, turned: float, *, stretched: bool) -> Linkage:
    """A crank-rocker whose links come within `margin`, rad, of being in line: apart stretched, or folded."""
    between = math.pi - margin if stretched else margin
    rocker = 0.2
    apart = math.sqrt(COUPLER**2 + rocker**2 - 2.0 * COUPLER * rocker * math.cos(between))
    return four_bar(apart - CRANK if stretched else apart + CRANK, rocker, turned)


@given(st.floats(0.0, 6.2), st.booleans(), st.floats(1e-6, 0.01))
def test_the_rule_of_half_a_degree_is_kept_to_a_millionth(turned: float, stretched: bool, off: float) -> None:
    require_turning(with_margin(CLEAR * (1.0 + off), turned, stretched=stretched))
    with pytest.raises(NumericsError) as refused:
        require_turning(with_margin(CLEAR * (1.0 - off), turned, stretched=stretched))
    assert refused.value.code == "linkage_singular"
    assert refused.value.data is not None
    assert refused.value.data.parameters["margin"] == pytest.approx(math.degrees(CLEAR) * (1.0 - off), rel=1e-4)
    worst = math.degrees(turned + math.pi if stretched else turned) % 360.0
    assert abs((float(str(refused.value.data.parameters["value"])) - worst + 180.0) % 360.0 - 180.0) < 0.01


@given(st.floats(0.0, 6.2))
def test_a_gap_narrower_than_the_scan_is_found_with_the_angles_at_which_it_closes(turned: float) -> None:
    linkage = four_bar(COUPLER + 0.2 - CRANK + 1e-8, 0.2, turned)
    with pytest.raises(NumericsError) as refused:
        require_turning(linkage)
    assert refused.value.code == "linkage_does_not_close"
    ((start, end),) = turning_intervals(linkage)
    assert 0.0 < 2.0 * math.pi - (end - start) < 2.0 * math.pi / 1440
    edges = np.array([start + 1e-9, end - 1e-9, start - 1e-7, end + 1e-7])
    assert (np.abs(corner_cosines(linkage, edges)) <= 1.0).tolist() == [[True, True, False, False]]


def test_intervals_end_where_the_angle_between_links_is_the_one_asked_for() -> None:
    linkage = four_bar(0.31, 0.05)
    (interval, *_) = turning_intervals(linkage, math.cos(CLEAR))
    between = np.arccos(corner_cosines(linkage, np.array(interval)))[0]
    assert np.minimum(between, math.pi - between) == pytest.approx(CLEAR, rel=1e-6)
    assert turning_intervals(four_bar(0.28, 0.2)) == [(0.0, 2.0 * math.pi)]
