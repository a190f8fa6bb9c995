"""The page and the form of a machine: everything stated is shown with its unit, nothing is lost by a change."""

from __future__ import annotations

import html
import re
from typing import Any

from tests.support.http.workshop import Workshop, machine_body
from tests.web.test_german_pages import GERMAN, english

HTML = {"accept": "text/html"}
NARROW = "\N{NARROW NO-BREAK SPACE}"
FULL: dict[str, Any] = {
    "balance_grade_mm_s": 16.0,
    "vibration_limit_mm_s": 0.5,
    "bearings": [{"name": "gear", "axial_mm": -500.0}, {"name": "pulley", "axial_mm": 450.0}],
    "sensors": [
        {"name": "P", "axial_mm": -480.0, "bearing": "gear", "direction": "horizontal", "limit": 0.7, "serial": "S 1"},
        {"name": "Q", "axial_mm": 440.0, "bearing": "pulley", "direction": "vertical", "unit": "um"}
        | {"quantity": "displacement", "detection": "peak_to_peak", "limit": 25.0},
    ],
}


def full(shop: Workshop) -> str:
    """A machine of which everything is stated."""
    planes = [{**plane, "max_total_mass_g": 900.0, "max_force_n": 250.0} for plane in machine_body()["planes"]]
    return shop.machine(**FULL, planes=planes)


def text_of(page: str) -> str:
    """What is read on a page."""
    body = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", page[page.index("<main") :]))
    return html.unescape(body).replace(NARROW, " ")


def as_typed(page: str) -> dict[str, str]:
    """The fields of the form of a machine as the page has filled them."""
    part = page[page.index('class="machine-form"') :]
    fields = dict.fromkeys(re.findall(r'<input[^>]* name="([^"]+)"', part), "")
    fields |= {name: html.unescape(text) for name, text in re.findall(r'name="([^"]+)" value="([^"]*)"', part)}
    radios = re.findall(r'<input type="radio" name="([^"]+)" value="([^"]*)"( checked)?', part)
    fields |= dict.fromkeys((name for name, _, _ in radios), "")
    fields |= {name: text for name, text, checked in radios if checked}
    for name, options in re.findall(r'(?s)<select[^>]* name="([^"]+)"[^>]*>(.*?)</select>', part):
        chosen = re.search(r'value="([^"]*)" selected', options) or re.search(r'value="([^"]*)"', options)
        fields[name] = chosen.group(1) if chosen else ""
    return {name: text for name, text in fields.items() if not re.match("more_|fewer_|form_", name)}


def test_limits_grade_and_places_are_shown_with_their_units(shop: Workshop) -> None:
    machine = full(shop)
    said = text_of(shop.client.get(f"/machines/{machine}", headers=HTML).text)
    for words in ("0.5 mm/s rms", "G 16", "gear at -500 mm, pulley at 450 mm".replace("-", "\N{MINUS SIGN}")):
        assert words in said
    for words in (
        "\N{MINUS SIGN}480 mm",
        "\N{MINUS SIGN}330 mm",
        "0.7 mm/s rms",
        "25 µm pk-pk",
        "at most 900 g",
        "250 N",
    ):
        assert words in said
    shop.client.cookies.set("drumtrue_preferences", "length=in&velocity=in/s&detection=peak")
    said = text_of(shop.client.get(f"/machines/{machine}", headers=HTML).text)
    shop.client.cookies.delete("drumtrue_preferences")
    assert "0.0278 in/s pk" in said, "0.5 mm/s rms"
    assert "12.99 in" in said
    for path in (f"/machines/{machine}", f"/machines/{machine}/edit", "/machines/new"):
        page = shop.client.get(path, headers=GERMAN)
        assert (page.status_code, english(page.text)) == (200, [])


def test_a_change_of_one_field_leaves_all_others_as_they_were(shop: Workshop) -> None:
    machine = full(shop)
    before = shop.get(f"/machines/{machine}")
    page = shop.client.get(f"/machines/{machine}/edit", headers=HTML).text
    assert "Stated for this machine" in page
    sent = as_typed(page) | {"service_speed_rpm": "480"}
    answer = shop.client.post(f"/machines/{machine}/edit", data=sent, headers=HTML, follow_redirects=False)
    assert answer.status_code == 303
    after = shop.get(f"/machines/{machine}")
    changed = {"service_speed_rpm", "updated_at", "version"}
    assert {name for name in before if before[name] != after[name]} <= changed
    assert after["service_speed_rpm"] == 480.0


def test_bearings_follow_the_sensors_they_came_from(shop: Workshop) -> None:
    machine = shop.machine()
    page = shop.client.get(f"/machines/{machine}/edit", headers=HTML).text
    assert "Two sensors with a place along the shaft" in page
    assert "5 runs at least instead of 3" in page
    sent = as_typed(page) | {"sensors[0].axial_mm": "-470"}
    shop.client.post(f"/machines/{machine}/edit", data=sent, headers=HTML)
    assert shop.get(f"/machines/{machine}")["bearings"][0] == {"name": "P", "axial_mm": -470.0}


def test_which_way_round_is_asked_and_never_assumed(shop: Workshop) -> None:
    """A wrong end, rotation or sense mirrors every mass: nothing of it stands in an empty form."""
    page = shop.client.get("/machines/new", headers=HTML).text
    typed = as_typed(page)
    assert [typed[name] for name in ("seen_from", "rotation", "angle_sense", "balance_grade_mm_s")] == [""] * 4
    sent = typed | {"name": "Which way round", "service_speed_rpm": "460", "form_key": "which"}
    sent |= {f"planes[{index}].radius_mm": "330" for index in (0, 1)}
    tokens = dict(re.findall(r'name="(form_token)" value="(\w+)"', page))
    refused = shop.client.post("/machines/new", data=sent | tokens, headers=HTML, follow_redirects=False)
    assert refused.status_code == 422
    assert refused.text.count('class="fault" role="alert"') + refused.text.count('id="seen_from-fault"') == 3
    known = {"seen_from": "the pulley", "rotation": "ccw", "angle_sense": "with_rotation"}
    taken = shop.client.post("/machines/new", data=sent | tokens | known, headers=HTML, follow_redirects=False)
    assert taken.status_code == 303
    stored = shop.get(taken.headers["location"])
    assert {name: stored[name] for name in known} == known
    assert stored["balance_grade_mm_s"] is None
