"""A form that is refused because the session went on: the newer state, and the form with what was typed."""

from __future__ import annotations

import html
import re

import pytest

from service.web.session.guide import look
from tests.support.http.workshop import Workshop
from tests.support.pages.posted import GUIDED
from tests.web.session.test_undoing import HTML, LOCKED, RELEASED, send
from tests.web.test_german_pages import GERMAN, english

RUN = {"readings[0].amplitude": "9,87 mm/s", "readings[1].phase_deg": "🙂", "speed_rpm": "455,5"}
FITTED = {"differs": "yes", "actual[0].position_deg": "20", "actual[0].mass_g": "10", "actual[1].weighed_g": "10,4"}
TYPED: dict[str, dict[str, str]] = {
    "runs": RUN,
    "runs/take": {"anyway": "yes"},
    "runs/x/exclude": {"excluded": "yes", "reason": "Riemen lose"},
    "corrections": {"source": "balancer", "masses[0].mass_g": "101,5", "masses[1].angle_deg": "41"},
    "plans": {"mode": "fewest", "objective": "residual_vibration", "max_masses_per_plane": "2"},
    "plans/x/again": {"blocked_plane": "1", "blocked_deg": "40"},
    "box": {"catalogue_id": "{box}"},
    "close": {},
    "teach": {},
    "stops": {"purpose": "trial", "plane": "2"},
    "stops/x/lock": LOCKED,
    "stops/x/trial": {"masses.mass_g": "52,5", "masses.angle_deg": "40", "keep": "yes"},
    "stops/x/plan": FITTED,
    "stops/x/bare": {},
    "stops/x/release": RELEASED,
    "stops/x/cancel": {},
    "stops/x/correct": {},
    "runs/x/repeat": {},
}
UNSEEN = {"differs", "objective", "purpose", "source", "excluded", "mode", "catalogue_id"}
"""What is sent as a button's or a list's own value, and told in words."""


def refused_form(page: str) -> str:
    """The part of a page that shows the form which was refused."""
    return page[page.index("data-kept") :].split("</section>")[0]


def values(part: str) -> list[str]:
    """What stands in the fields of a part of a page."""
    return [html.unescape(text) for text in re.findall(r'<input[^>]* value="([^"]*)"', part)]


@pytest.mark.parametrize("path", GUIDED)
def test_every_form_that_another_tablet_overtook_is_shown_again(shared_shop: Workshop, path: str) -> None:
    shop, asked = shared_shop, path.removeprefix("/sessions/x/")
    session, box = shop.session(), shop.box()
    shop.run(session, "initial")
    sent = {name: text.format(box=box) for name, text in TYPED[asked].items()}
    before = shop.rows()
    address = f"/sessions/{session}/{asked.replace('x', '1')}" if "stops" in asked else f"/sessions/{session}/{asked}"
    answer = shop.client.post(address, data={"stamp": "old", "moment": "initial 0 begin", **sent}, headers=GERMAN)
    assert answer.status_code == 409
    assert shop.rows() == before
    assert "Testlauf in Ebene 1" in answer.text, "the newer state"
    assert english(answer.text) == []
    kept = refused_form(answer.text)
    assert re.search(r"<h2>Nicht gespeichert: „[^“]+“</h2>", kept)
    shown = values(kept)
    for name, text in sent.items():
        assert name in UNSEEN or ("✓" if text == "yes" else text) in shown, name
    assert ("box" in sent.get("catalogue_id", "")) <= any("box" in text for text in shown)


def test_what_was_typed_for_one_run_is_not_filled_in_for_another(shop: Workshop) -> None:
    session = shop.session()
    as_found = {"stamp": "old", "moment": "initial 0 begin", "readings[0].amplitude": "9.87"}
    shop.run(session, "initial")
    send(shop, session, "stops", purpose="trial", plane="1")
    send(shop, session, "stops/1/lock", **LOCKED)
    send(shop, session, "stops/1/trial", **{"masses.mass_g": "50", "masses.angle_deg": "20"})
    page = send(shop, session, "stops/1/release", **RELEASED).text
    assert "Run with the trial mass" in page
    late = shop.client.post(f"/sessions/{session}/runs", data=as_found, headers=HTML)
    assert "9.87" in values(refused_form(late.text))
    assert values(late.text).count("9.87") == 1
    moment = re.search(r'name="moment" value="([^"]+)"', page)
    assert moment is not None
    # A run left out elsewhere is another state, and the same thing to do: the form is filled in, to be sent again.
    again = shop.client.post(f"/sessions/{session}/runs", data={**as_found, "moment": moment.group(1)}, headers=HTML)
    assert again.status_code == 409
    assert values(again.text).count("9.87") == 2
    assert '<details class="card typed" open>' in again.text


def test_a_form_out_of_order_is_shown_again_too(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    sent = {"stamp": look(shop.work, session).stamp, "readings[0].amplitude": "9.87"}
    answer = shop.client.post(f"/sessions/{session}/runs", data=sent, headers=HTML)
    assert answer.status_code == 409
    assert 'class="fault general"' in answer.text
    assert "9.87" in values(refused_form(answer.text))
