"""The form of any machine, fetched and sent back as it is, leaves the machine as it was; an edit changes its field."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.http.workshop import Workshop, machine_body
from tests.web.test_machine_pages import HTML, as_typed, full

NAMES = st.text(
    st.characters(blacklist_categories=("Cs", "Cc"), blacklist_characters="\x7f"), min_size=1, max_size=30
).filter(lambda text: text.strip() == text != "")
NUMBERS = st.floats(1e-9, 1e9) | st.floats(0.1, 1000.0) | st.just(360.0 / 7)
PLACES = st.none() | st.floats(-1e9, 1e9) | st.floats(-900.0, 900.0)
ANGLES = st.lists(st.floats(0.0, 359.0), min_size=1, max_size=20, unique=True) | st.just(
    [360.0 * n / 7 for n in range(7)]
)
UNITS = [("velocity", "mm/s"), ("velocity", "in/s"), ("acceleration", "m/s2"), ("acceleration", "g")]
UNITS += [("displacement", "um"), ("displacement", "mm"), ("displacement", "mil")]


def optional(strategy: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.none() | strategy


@st.composite
def planes(draw: st.DrawFn, name: str) -> dict[str, Any]:
    angles = draw(ANGLES)
    labels = st.lists(NAMES | st.sampled_from(["A 1", "C;3"]), min_size=len(angles), max_size=len(angles), unique=True)
    return {
        "name": name,
        "radius_mm": draw(NUMBERS),
        "axial_mm": draw(PLACES),
        "positions_deg": angles,
        "hole_labels": draw(optional(labels)),
        "masses_per_position": (most := draw(st.integers(1, 20))),
        "max_masses": draw(st.integers(1, min(20, most * len(angles)))),
        "max_total_mass_g": draw(optional(NUMBERS)),
        "max_force_n": draw(optional(NUMBERS)),
    }


@st.composite
def sensors(draw: st.DrawFn, name: str) -> dict[str, Any]:
    quantity, unit = draw(st.sampled_from(UNITS))
    return {
        "name": name,
        "axial_mm": draw(PLACES),
        "direction": draw(optional(st.sampled_from(["horizontal", "vertical", "axial", "radial"]))),
        "quantity": quantity,
        "unit": unit,
        "detection": draw(st.sampled_from(["rms", "peak", "peak_to_peak"])),
        "limit": draw(optional(NUMBERS)),
        "serial": draw(optional(NAMES)),
    }


@st.composite
def descriptions(draw: st.DrawFn) -> dict[str, Any]:
    """A machine as the API may be sent it; one that breaks a rule of several fields together is refused there."""
    named = st.lists(NAMES, min_size=1, max_size=4, unique=True)
    some = draw(named | st.just([f"sensor {n}" for n in range(64)]))
    places = draw(st.lists(st.floats(-900.0, 900.0), max_size=3, unique=True))
    body = {
        "type": draw(optional(NAMES)),
        "rotor_mass_kg": draw(optional(NUMBERS)),
        "service_speed_rpm": draw(NUMBERS),
        "rotation": draw(st.sampled_from(["cw", "ccw"])),
        "seen_from": draw(optional(NAMES)),
        "balance_grade_mm_s": draw(optional(NUMBERS)),
        "vibration_limit_mm_s": draw(optional(NUMBERS)),
        "iso_20816": draw(optional(st.just({"group": 1, "support": "rigid"}))),
        "angle_sense": draw(st.sampled_from(["against_rotation", "with_rotation"])),
        "phase_sense": draw(st.sampled_from(["lag", "lead"])),
        "bearings": [{"name": f"bearing {n}", "axial_mm": place} for n, place in enumerate(places)],
        "planes": [draw(planes(name)) for name in draw(named)],
        "sensors": [draw(sensors(name)) for name in some[:4]] + [{"name": name} for name in some[4:]],
    }
    return {name: value for name, value in body.items() if value is not None}


def without_times(machine: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in machine.items() if name != "updated_at"}


@pytest.mark.parametrize("units", ["metric", "imperial"])
def test_any_machine_is_as_it_was_after_its_form_is_sent_back(shared_shop: Workshop, units: str) -> None:
    shop = shared_shop
    shop.client.post("/preferences", data={"language": "de", "units": units})

    taken: list[int] = []

    @settings(max_examples=50)
    @given(body=descriptions())
    def holds(body: dict[str, Any]) -> None:
        shop.now()
        answer = shop.client.post("/api/v1/machines", json={"name": f"drum at {shop.now().isoformat()}", **body})
        if answer.status_code == 422:
            return
        taken.append(1)
        before = answer.json()
        path = f"/machines/{before['id']}/edit"
        fields = as_typed(shop.client.get(path, headers=HTML).text)
        sent = shop.client.post(path, data=fields, headers=HTML, follow_redirects=False)
        assert sent.status_code == 303, sent.text
        assert without_times(shop.get(f"/machines/{before['id']}")) == without_times(before)

    holds()
    assert len(taken) > 8


@pytest.mark.parametrize(
    ("field", "typed", "path", "stored"),
    [
        ("planes[0].name", "Left", ("planes", 0, "name"), "Left"),
        ("planes[0].radius_mm", "331", ("planes", 0, "radius_mm"), 331.0),
        ("sensors[1].name", "outer", ("sensors", 1, "name"), "outer"),
        ("sensors[0].limit", "", ("sensors", 0, "limit"), None),
        ("planes[1].holes", "4", ("planes", 1, "positions_deg"), [20.0, 110.0, 200.0, 290.0]),
        ("sensors[0].unit", "in/s", ("sensors", 0, "unit"), "in/s"),
    ],
)
def test_an_edit_changes_its_field_and_nothing_else(
    shop: Workshop, field: str, typed: str, path: tuple[Any, ...], stored: object
) -> None:
    machine = full(shop)
    before = shop.get(f"/machines/{machine}")
    fields = as_typed(shop.client.get(f"/machines/{machine}/edit", headers=HTML).text)
    answer = shop.client.post(f"/machines/{machine}/edit", data={**fields, field: typed}, follow_redirects=False)
    assert answer.status_code == 303, answer.text
    group, index, name = path
    expected = {**before, group: [dict(one) for one in before[group]]}
    expected[group][index][name] = stored
    assert without_times(shop.get(f"/machines/{machine}")) == without_times(expected)


def test_a_label_with_a_blank_can_be_edited(shop: Workshop) -> None:
    plane = {**machine_body()["planes"][0], "positions_deg": [0.0, 90.0], "max_masses": 2}
    plane["hole_labels"] = ["A 1", "B 2"]
    machine = shop.machine(planes=[plane])
    fields = as_typed(shop.client.get(f"/machines/{machine}/edit", headers=HTML).text)
    shop.client.post(f"/machines/{machine}/edit", data={**fields, "planes[0].hole_labels": "A 1; B 3"})
    assert shop.get(f"/machines/{machine}")["planes"][0]["hole_labels"] == ["A 1", "B 3"]
