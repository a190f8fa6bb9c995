"""Every bad input has a refusal with a name, and nothing is stored."""

from __future__ import annotations

from typing import Any

import pytest

from tests.api.arrangements.test_arrangements import BARS, parts, places
from tests.support.http.workshop import Workshop


def request(**changes: Any) -> dict[str, Any]:
    """A good request, changed."""
    return {"places": places(), "parts": parts()} | changes


def changed(index: int, **changes: Any) -> list[dict[str, Any]]:
    """Good parts, one of them changed."""
    return [{**part, **changes} if n == index else part for n, part in enumerate(parts())]


TWO_ENDS = places(axial=(-500.0, 500.0))
BAD: dict[str, tuple[dict[str, Any], str]] = {
    "a part listed twice": (request(parts=changed(1, id="b1")), "part_twice"),
    "two parts in one place": (request(parts=changed(1, present="1")), "place_taken_twice"),
    "an unknown place": (request(parts=changed(1, present="99")), "unknown_place"),
    "an unknown kind": (request(places=places(kind="left"), parts=changed(1, kind="up")), "unknown_kind"),
    "a mass of zero": (request(parts=changed(1, mass_g=0.0)), "mass_not_positive"),
    "a negative mass": (request(parts=changed(1, mass_g=-5.0)), "mass_not_positive"),
    "kg typed as g": (request(parts=changed(1, mass_g=5.978)), "mass_implausible"),
    "g typed as mg": (request(parts=changed(1, mass_g=5978000.0)), "mass_implausible"),
    "both ends at one position": (request(places=places(axial=(5.0, 5.0))), "ends_at_one_position"),
    "two ends in a place with one": (
        request(parts=changed(1, mass_g=[3000.0, 3000.0])),
        "two_ended_part_in_one_ended_place",
    ),
    "present arrangement incomplete": (
        request(offset="in_balance_with_old", parts=changed(1, present=None)),
        "present_incomplete",
    ),
    "an unweighed part that may move": (
        request(offset="in_balance_with_old", parts=changed(1, mass_g=None, may="move")),
        "part_not_weighed",
    ),
    "an unweighed part on a bare drum": (request(parts=changed(1, mass_g=None, may="stay")), "part_not_weighed"),
    "a part that stays nowhere": (request(parts=changed(1, present=None, may="stay")), "stays_without_place"),
    "a place twice": (request(places=[*places(), places()[0]]), "place_twice"),
    "an unknown group": (request(group_limits=[{"group": "x", "max_difference_g": 1.0}]), "unknown_group"),
    "no places": ({"parts": parts()}, "places_missing"),
    "a set without a machine": ({"parts": parts(), "set": "bars"}, "machine_missing"),
    "fewest moves without a limit": (request(mode="fewest_moves"), "limit_missing"),
    "planes at one position": (request(planes_axial_mm=[5.0, 5.0]), "planes_at_one_position"),
    "measured without a correction": (request(offset="measured"), "correction_missing"),
    "bearing force without a machine": (request(objective="bearing_force"), "machine_missing"),
    "an unknown plane": (request(offset=[{"plane": 2, "unbalance_g_mm": 1.0, "angle_deg": 0.0}]), "unknown_plane"),
    "a box without a machine": (request(use="both"), "catalogue_missing"),
    "moment and ends": (
        request(places=TWO_ENDS, parts=changed(1, mass_g=[3000.0, 2978.0], moment_g_mm=5.0)),
        "moment_and_ends",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_it_is_refused_by_name_and_nothing_is_stored(shared_shop: Workshop, name: str) -> None:
    body, code = BAD[name]
    before = shared_shop.count("arrangement")
    problem = shared_shop.refused("POST", "/arrangements", body, 422, code)
    assert problem["advice"]
    assert shared_shop.count("arrangement") == before


def test_not_a_number_is_refused(shared_shop: Workshop) -> None:
    for bad in ("NaN", "Infinity"):
        text = '{"places": [], "parts": [{"id": "a", "mass_g": ' + bad + "}]}"
        answer = shared_shop.client.post(
            "/api/v1/arrangements", content=text, headers={"Content-Type": "application/json"}
        )
        assert answer.status_code == 422


def test_a_good_request_is_good(shared_shop: Workshop) -> None:
    assert shared_shop.post("/arrangements", request())["status"] == "optimal"
    assert len(BARS) == 6
