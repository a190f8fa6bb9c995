"""Parts on the scale: written down with their places, refused by name where they cannot be meant."""

from __future__ import annotations

from typing import Any

import pytest

from tests.api.arrangements.test_arrangements import places
from tests.support.http.workshop import Workshop


@pytest.fixture
def machine(shared_shop: Workshop) -> str:
    """A machine with six places for bars and six for knives."""
    made = shared_shop.machine()
    for name in ("bars", "knives"):
        shared_shop.ask("PUT", f"/machines/{made}/place-sets/{name}", {"places": places()})
    return made


def weigh(shop: Workshop, machine: str, *parts: dict[str, Any], place_set: str | None = "bars") -> list[dict[str, Any]]:
    made: list[dict[str, Any]] = shop.post(
        f"/machines/{machine}/parts", {"place_set": place_set, "parts": list(parts), "note": "by hand"}
    )
    return made


def test_a_weighing_is_kept_with_its_place(shared_shop: Workshop, machine: str) -> None:
    made = weigh(shared_shop, machine, {"part": "a", "mass_g": 6000.0, "place": "1"}, {"part": "b", "mass_g": 6010.0})
    assert [(one["part"], one["event"], one["place"], one["place_set"]) for one in made] == [
        ("a", "weighed", "1", "bars"),
        ("b", "weighed", None, "bars"),
    ]
    assert shared_shop.get(f"/machines/{machine}/parts") == made


def test_what_was_in_the_place_is_taken_off(shared_shop: Workshop, machine: str) -> None:
    weigh(shared_shop, machine, {"part": "a", "mass_g": 6000.0, "place": "1"})
    weigh(shared_shop, machine, {"part": "b", "mass_g": 6010.0, "place": "1"})
    now = {one["part"]: (one["event"], one["place"]) for one in shared_shop.get(f"/machines/{machine}/parts")}
    assert now == {"a": ("taken_off", None), "b": ("weighed", "1")}
    weigh(shared_shop, machine, {"part": "k", "mass_g": 600.0, "place": "1"}, place_set="knives")
    where = {one["part"]: one["place"] for one in shared_shop.get(f"/machines/{machine}/parts")}
    assert where == {"a": None, "b": "1", "k": "1"}, "a place of another set is another place"


BAD: dict[str, tuple[list[dict[str, Any]], str]] = {
    "a mass of zero": ([{"part": "x", "mass_g": 0.0}], "mass_not_positive"),
    "kg typed as g": ([{"part": "x", "mass_g": 6.0}], "mass_implausible"),
    "no mass at all": ([{"part": "x"}], "part_not_weighed"),
    "the same part twice": ([{"part": "x", "mass_g": 6000.0}, {"part": "x", "mass_g": 6001.0}], "part_twice"),
    "an unknown place": ([{"part": "x", "mass_g": 6000.0, "place": "99"}], "unknown_place"),
    "two ends where there is one": (
        [{"part": "x", "mass_g": [3000.0, 3000.0], "place": "2"}],
        "two_ended_part_in_one_ended_place",
    ),
    "moment and ends": ([{"part": "x", "mass_g": [3000.0, 3000.0], "moment_g_mm": 5.0}], "moment_and_ends"),
    "a number of another set": ([{"part": "k", "mass_g": 6000.0}], "part_of_other_set"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_meant_is_refused_and_nothing_is_stored(shared_shop: Workshop, machine: str, name: str) -> None:
    weigh(shared_shop, machine, *({"part": f"p{n}", "mass_g": 6000.0 + n, "place": str(n)} for n in range(1, 4)))
    weigh(shared_shop, machine, {"part": "k", "mass_g": 600.0}, place_set="knives")
    before = shared_shop.count("part_entry")
    parts, code = BAD[name]
    problem = shared_shop.refused(
        "POST", f"/machines/{machine}/parts", {"place_set": "bars", "parts": parts}, 422, code
    )
    assert problem["advice"]
    assert problem["field"].startswith("parts[")
    assert shared_shop.count("part_entry") == before


def test_a_set_that_is_not_there_is_refused(shared_shop: Workshop, machine: str) -> None:
    body = {"place_set": "hammers", "parts": [{"part": "x", "mass_g": 6000.0}]}
    shared_shop.refused("POST", f"/machines/{machine}/parts", body, 404, "place_set_not_found")
