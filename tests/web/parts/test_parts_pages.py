"""Pages of parts without a browser: German, refusals, the lock, what is really mounted, and moves in order."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.model.arrangement import Arrangement, ArrangementRequest
from service.model.base import read_json
from service.usecases.arrangements import arrangements
from service.web.parts import mounting
from tests.api.arrangements.test_arrangements import BARS, parts, places
from tests.support.http.workshop import Workshop
from tests.web.test_german_pages import GERMAN, english

HTML = {"accept": "text/html"}
TICKS = {
    "lock": {"standstill": "yes", "key_out": "yes", "blocked": "yes"},
    "release": {"torqued": "yes", "tools_out": "yes", "guards_on": "yes"},
}


def post(shop: Workshop, path: str, **fields: str) -> Any:
    return shop.client.post(path, data=fields, headers=GERMAN, follow_redirects=False)


@pytest.fixture
def machine(shared_shop: Workshop) -> str:
    """A machine with six weighed bars in their places."""
    made = shared_shop.machine()
    shared_shop.ask("PUT", f"/machines/{made}/place-sets/bars", {"places": places()})
    weighed = [{"part": p["id"], "mass_g": p["mass_g"], "place": p["present"]} for p in parts()]
    shared_shop.post(f"/machines/{made}/parts", {"place_set": "bars", "parts": weighed})
    return made


def arranged(shop: Workshop, machine: str, **fields: str) -> str:
    """The path of an arrangement asked for with the page's form."""
    sent = {"offset": "bare", "mode": "best", "scale_resolution_g": "1"} | fields
    answer = post(shop, f"/machines/{machine}/parts/bars/arrange", **sent)
    assert answer.status_code == 303, re.findall(r"class=\"fault[^>]*>([^<]*)", answer.text)
    return str(answer.headers["location"])


def test_every_page_in_german(shared_shop: Workshop, machine: str) -> None:
    made = arranged(shared_shop, machine)
    here = f"/machines/{machine}/parts"
    paths = [f"/machines/{machine}", f"{here}/new", f"{here}/bars", f"{here}/bars/weigh", f"{here}/bars/weigh?place="]
    paths += [f"{here}/bars/arrange", f"{here}/bars/broke", f"{here}/bars/broke?place=2"]
    paths += [made, f"{made}/front", f"{made}/mount", f"{made}/report", f"{made}/replacement?place=2"]
    for path in paths:
        page = shared_shop.client.get(path, headers=GERMAN)
        assert (page.status_code, english(page.text)) == (200, []), path
    for step in ("lock", "mounted", "release"):
        assert post(shared_shop, f"{made}/{step}", **TICKS.get(step, {})).status_code == 303
        page = shared_shop.client.get(f"{made}/mount", headers=GERMAN)
        assert (page.status_code, english(page.text)) == (200, []), step


WRONG: dict[str, tuple[str, dict[str, str], int]] = {
    "no mass": ("weigh", {"place": "1", "part": "b1"}, 422),
    "kg typed as g": ("weigh", {"place": "1", "part": "b1", "mass": "6,025"}, 422),
    "a mass of zero": ("weigh", {"place": "1", "part": "b1", "mass": "0"}, 422),
    "not a number": ("weigh", {"place": "1", "part": "b1", "mass": "schwer"}, 422),
    "an unknown place": ("weigh", {"place": "99", "part": "b1", "mass": "6025"}, 422),
    "no number on the part": ("weigh", {"place": "1", "part": "", "mass": "6025"}, 422),
    "no limit": ("arrange", {"offset": "bare", "mode": "fewest_moves"}, 422),
    "an offset that is not offered": ("arrange", {"offset": "measured:x", "mode": "best"}, 422),
    "a box that is not there": ("arrange", {"offset": "bare", "mode": "best", "use": "both", "catalogue_id": "x"}, 422),
    "no such place": ("broke", {"place": "99", "part": "n", "mass": "6000"}, 422),
    "a number that is taken": ("broke", {"place": "1", "part": "b2", "mass": "6000"}, 422),
    "kg for the new part": ("broke", {"place": "1", "part": "n", "mass": "6,1"}, 422),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_meant_is_told_in_german_and_not_stored(shared_shop: Workshop, machine: str, name: str) -> None:
    path, fields, status = WRONG[name]
    before = shared_shop.count("part_entry"), shared_shop.count("arrangement")
    answer = post(shared_shop, f"/machines/{machine}/parts/bars/{path}", **fields)
    assert answer.status_code == status
    assert english(answer.text) == []
    assert "fault" in answer.text or path == "broke"
    assert (shared_shop.count("part_entry"), shared_shop.count("arrangement")) == before


@pytest.mark.parametrize(
    ("field", "text"),
    [("around", "0"), ("around", "500"), ("radius_mm", "0"), ("radius_mm", ""), ("name", "a/b"), ("along", "9")],
)
def test_places_that_cannot_be_are_told_beside_their_field(
    shared_shop: Workshop, machine: str, field: str, text: str
) -> None:
    good = {"name": "Messer", "around": "4", "radius_mm": "260", "axial_mm": "-700", "kinds": "alternating"}
    before = shared_shop.count("place_set")
    answer = post(shared_shop, f"/machines/{machine}/parts/new", **good | {field: text})
    assert answer.status_code == 422
    assert "aria-invalid" in answer.text
    assert english(answer.text) == []
    assert shared_shop.count("place_set") == before
    post(shared_shop, f"/machines/{machine}/parts/new", **good | {"along": "3", "axial_end_mm": "700"})
    made = next(one for one in shared_shop.get(f"/machines/{machine}/place-sets") if one["name"] == "Messer")
    assert [one["label"] for one in made["places"]] == [str(n) for n in range(1, 13)]
    assert sorted({one["axial_mm"][0] for one in made["places"]}) == [-700.0, 0.0, 700.0]
    assert {one["kind"] for one in made["places"]} == {"links", "rechts"}


def test_nothing_is_mounted_before_the_drum_is_locked(shared_shop: Workshop, machine: str) -> None:
    made = arranged(shared_shop, machine)
    assert post(shared_shop, f"{made}/mounted").status_code == 409
    assert post(shared_shop, f"{made}/lock", standstill="yes").status_code == 422
    assert post(shared_shop, f"{made}/release", **TICKS["release"]).status_code == 409
    assert shared_shop.get(made)["state"] == "proposed"
    assert shared_shop.get(made)["locked_at"] is None
    post(shared_shop, f"{made}/lock", **TICKS["lock"])
    one, other = shared_shop.get(made)["arrangement"][:2]
    twice = {"differs": "yes", "actual[0]": other["part"]}
    assert post(shared_shop, f"{made}/mounted", **twice).status_code == 422, "in two places"
    swapped = twice | {"actual[1]": one["part"]}
    assert post(shared_shop, f"{made}/mounted", **swapped).status_code == 303
    really = shared_shop.get(made)["mounted"]
    assert [x["part"] for x in really[:2]] == [other["part"], one["part"]]
    assert post(shared_shop, f"{made}/lock", **TICKS["lock"]).status_code == 409
    sheet = shared_shop.client.get(f"{made}/report", headers=HTML).text
    assert "Mounted, not everywhere as computed" in sheet


def test_the_page_takes_one_step_of_the_front(shared_shop: Workshop, machine: str) -> None:
    made = arranged(shared_shop, machine)
    answer = post(shared_shop, f"{made}/again", max_moves="2")
    again = shared_shop.get(answer.headers["location"])
    assert again["moves_count"] <= 2
    assert again["request"]["max_moves"] == 2


def test_a_form_sent_twice_is_done_once(shared_shop: Workshop, machine: str) -> None:
    before = shared_shop.count("part_entry")
    fields = {"place": "1", "part": "b1", "mass": "6026", "form_key": "the same key"}
    first = post(shared_shop, f"/machines/{machine}/parts/bars/weigh", **fields)
    second = post(shared_shop, f"/machines/{machine}/parts/bars/weigh", **fields)
    assert first.headers["location"] == second.headers["location"]
    assert shared_shop.count("part_entry") == before + 1


def test_one_that_broke_and_was_never_weighed(shared_shop: Workshop) -> None:
    """Those that stay need no mass; the broken one does."""
    machine = shared_shop.machine()
    shared_shop.ask("PUT", f"/machines/{machine}/place-sets/bars", {"places": places()})
    request = {
        "machine_id": machine,
        "set": "bars",
        "parts": [{"id": f"b{n}", "present": str(n)} for n in range(1, 6)]
        + [{"id": "b6", "present": "6", "mass_g": 6e3}],
        "offset": "in_balance_with_old",
    }
    made = shared_shop.post("/arrangements", request)
    shared_shop.post(f"/arrangements/{made['id']}/mounted", {})
    page = shared_shop.client.get(f"/machines/{machine}/parts/bars/broke?place=2", headers=HTML).text
    assert "It was never weighed" in page
    lacks = post(shared_shop, f"/machines/{machine}/parts/bars/broke", place="2", part="n", mass="6010")
    assert lacks.status_code == 422
    good = post(shared_shop, f"/machines/{machine}/parts/bars/broke", place="2", part="n", mass="6010", old="5990")
    found = shared_shop.get(good.headers["location"])
    assert (found["status"], found["new_parts_count"]) == ("optimal", 1)


@given(order=st.permutations(range(6)), off=st.integers(0, 2), new=st.integers(0, 2))
def test_one_part_lies_aside_at_most(order: list[int], off: int, new: int) -> None:
    """Whatever moves: every step can be done, and leads to the arrangement."""
    gone = {"may": "gone"} if off == 2 else {}
    asked = [{"id": f"p{k}", "mass_g": 6000.0 + k, "present": str(k + 1)} | (gone if k == 5 else {}) for k in range(6)]
    asked += [{"id": f"n{k}", "mass_g": 6100.0 + k} for k in range(new)]
    offset = {"offset": "in_balance_with_old"} if gone else {}
    wanted = {str(place + 1): f"p{part}" for place, part in enumerate(order)}
    if new:
        wanted = {place: "n0" if part == "p5" else part for place, part in wanted.items()}
    elif gone:
        return
    made = _moved(asked, wanted, offset)
    held = {p["present"]: p["id"] for p in asked if p.get("present")}
    lying: set[str] = set()
    for step in mounting.handlings(made):
        if step.action in ("off", "lay"):
            assert held.pop(str(step.leaves)) == step.part
            lying |= {step.part} if step.action == "lay" else set()
        elif step.action == "move":
            assert held.pop(str(step.leaves)) == step.part
        elif step.part in lying:
            lying.remove(step.part)
        if step.to is not None:
            assert step.to not in held
            held[step.to] = step.part
        assert len(lying) <= 1
    assert held == wanted


def _moved(asked: list[dict[str, Any]], wanted: dict[str, str], offset: dict[str, str]) -> Arrangement:
    """An arrangement with these parts in these places: the moves in the order that the engine gives."""
    from service.engine.arrangement import answers
    from service.engine.arrangement.frame import frame_of
    from service.engine.arrangement.parts import pose

    request = read_json(ArrangementRequest, json.dumps({"places": places(), "parts": asked, **offset}))
    posed = pose(request, request.places or (), frame_of(request, None, None))
    numbers = {part.id: k for k, part in enumerate(request.parts)}
    row = np.array([numbers[wanted[place.label]] for place in posed.places])
    moves = answers.moves_in_order(posed, row)
    empty = dict.fromkeys(Arrangement.__dataclass_fields__)
    return Arrangement(**empty | {"request": request, "moves": moves})  # type: ignore[arg-type]


def test_the_use_case_locks_nothing_that_is_mounted(shared_shop: Workshop, machine: str) -> None:
    made = arranged(shared_shop, machine).rsplit("/", 1)[1]
    shared_shop.post(f"/arrangements/{made}/mounted", {})
    assert arrangements.get(shared_shop.work, made).locked_at is None
    assert post(shared_shop, f"/arrangements/{made}/lock", **TICKS["lock"]).status_code == 409
    assert len(BARS) == 6
