"""Pages of design studies: kept and changed, refused next to the field, computed, taken over, reported."""

from __future__ import annotations

import re
from typing import Any

import pytest

from service.web.preferences import COOKIE
from tests.support.http.workshop import Workshop

pytestmark = pytest.mark.only("sqlite")
BUDGET = 150_000
"""Bytes of a page, as `drumtrue bench web` has them."""
HTML = {"accept": "text/html", "accept-language": "en"}


def page(shop: Workshop, path: str, **headers: str) -> str:
    answer = shop.client.get(path, headers={**HTML, **headers})
    assert answer.status_code == 200, answer.text
    assert len(answer.content) < BUDGET
    return str(answer.text)


def send(shop: Workshop, path: str, form: dict[str, str]) -> Any:
    return shop.client.post(path, data=form, headers=HTML, follow_redirects=False)


def fields(text: str) -> dict[str, str]:
    """What the page's form would send."""
    form = text[text.index("design-form") :]
    found = {
        name: value for name, value in re.findall(r'<input id="[^"]*" name="([^"]*)" value="([^"]*)"', form) if name
    }
    for name, options in re.findall(r'(?s)<select id="[^"]*" name="([^"]*)".*?>(.*?)</select>', form):
        chosen = re.search(r'value="([^"]*)" selected', options)
        found[name] = chosen[1] if chosen else ""
    base = re.search(r'(?s)<textarea name="base"[^>]*>(.*?)</textarea>', form)
    version = re.search(r'name="study_version" value="(\d*)"', form)
    assert base
    assert version
    plain = base[1].replace("&#34;", '"').replace("&amp;", "&").replace("&#39;", "'").replace("&lt;", "<")
    return {**found, "base": plain, "study_version": version[1]}


def kept(shop: Workshop, name: str) -> str:
    """A published system kept as a study; its address."""
    answer = send(shop, "/designs/new", fields(page(shop, f"/designs/new?name={name}")))
    assert answer.status_code == 303, answer.text
    return str(answer.headers["location"])


@pytest.mark.parametrize(
    "name", ["sixbar", "cleaning", "eightbar", "flywheel_literature", "gear_pair", "shaft_set_utopia"]
)
def test_a_system_kept_as_it_is_shown_is_the_same_to_the_last_digit(shop: Workshop, name: str) -> None:
    address = kept(shop, name)
    study = shop.get(f"/design-studies/{address.rsplit('/', 1)[1]}")
    assert study["document"] == shop.get(f"/designs/{name}")["document"]
    shown = page(shop, address)
    assert "What this design does" in shown
    assert shown.count("<svg") >= 1


def test_a_field_is_changed_in_the_readers_numbers_and_makes_a_version(shop: Workshop) -> None:
    shop.client.cookies.set(COOKIE, "language=de")
    address = kept(shop, "flywheel_thresher")
    sent = {**fields(page(shop, address)), "limits.stress": "6,9", "design.thickness": "0,02 0,02 0,02 0,02 0,03"}
    answer = send(shop, address, sent)
    assert answer.headers["location"] == address
    study = shop.get(f"/design-studies/{address.rsplit('/', 1)[1]}")
    assert (study["version"], study["document"]["limits"]["stress"]) == (2, 6.9)
    assert study["document"]["design"]["thickness"] == [0.02, 0.02, 0.02, 0.02, 0.03]
    again = send(shop, address, {**sent, "limits.stress": "7"})
    assert again.status_code == 409
    assert "Stand 1" in page(shop, f"{address}/versions/1")


@pytest.mark.parametrize(
    ("field", "typed", "said"),
    [
        ("disc.inner_radius", "0", "must be above 0"),
        ("disc.poisson", "abc", "This is not a number"),
        ("disc.speed", "0", "must not be 0"),
        ("design.thickness", "0.02 0.02 nan", "This is not a number"),
        ("design.thickness_bounds", "0.06 0.01", "lower bound first"),
        ("limits.mass", "50", "must be at least 56.1"),
    ],
)
def test_what_is_wrong_stands_next_to_its_field(shop: Workshop, field: str, typed: str, said: str) -> None:
    sent = {**fields(page(shop, "/designs/new?name=flywheel_thresher")), field: typed}
    answer = send(shop, "/designs/new", sent)
    assert answer.status_code == 422
    place = answer.text[answer.text.index(f'name="{field}"') :]
    assert said in place[: place.index("</div>")]
    live = shop.client.post("/designs/check", data=sent).json()
    assert said in live["fields"][field]
    assert shop.get("/design-studies") == []


def test_a_document_of_ones_own_is_kept_or_refused_by_name(shop: Workshop) -> None:
    sent = {"study_name": "Mine", "base": "null", "study_version": "", "document": "study = 'bridge'\nversion = 1"}
    refused = send(shop, "/designs/new", sent)
    assert refused.status_code == 422
    assert "study must be one of" in refused.text.lower()
    broken = send(shop, "/designs/new", {**sent, "document": "{"})
    assert "must be JSON" in broken.text
    from service.design.documents import preset_text

    taken = send(shop, "/designs/new", {**sent, "document": preset_text("gear_pair")})
    assert taken.status_code == 303


def run_of(shop: Workshop, address: str, **asked: str) -> str:
    answer = send(shop, f"{address}/runs", {"run_kind": "optimum", **asked})
    assert answer.status_code == 303, answer.text
    path = str(answer.headers["location"])
    shop.work.background.wait(path.rsplit("/", 1)[1], 60.0)
    return path


def test_an_optimum_stands_next_to_the_present_design_and_is_taken_over(shop: Workshop) -> None:
    address = kept(shop, "gear_pair")
    path = run_of(shop, address)
    shown = page(shop, path)
    assert "Proved: no design within the limits is better" in shown
    assert "What was found is within all limits." in shown
    taken = send(shop, f"{path}/take", {})
    assert taken.headers["location"] == address
    assert shop.get(f"/design-studies/{address.rsplit('/', 1)[1]}")["version"] == 2
    pdf = shop.client.get(path.replace("/designs/runs", "/design-runs") + "/report.pdf")
    assert pdf.content.startswith(b"%PDF")
    assert pdf.content == shop.client.get(f"/api/v1{path.replace('/designs/runs', '/design-runs')}/report.pdf").content


def test_each_point_of_a_front_shows_its_design(shop: Workshop) -> None:
    address = kept(shop, "shaft_set_conflict")
    path = run_of(shop, address, run_kind="front")
    one, other = (page(shop, f"{path}?point={k}") for k in (0, 40))
    assert "Choose a point of the front" in one
    assert "pic-chosen" in one
    assert one != other
    taken = send(shop, f"{path}/take", {"point": "40"})
    design: Any = shop.get(f"/design-studies/{taken.headers['location'].rsplit('/', 1)[1]}")["document"]["design"]
    assert max(design["masses"]) > 500.0


def test_the_published_thresher_flywheel_breaks_its_limit_in_words(shop: Workshop) -> None:
    shown = page(shop, kept(shop, "flywheel_thresher"))
    assert "Stress (r = 0.06 m): at most 6.4 MPa is allowed, this design has 6.42504 MPa" in shown
