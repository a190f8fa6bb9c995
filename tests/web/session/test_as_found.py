"""What is known of a drum before its first run, typed where a session is opened."""

from __future__ import annotations

import re

from tests.support.http.workshop import Workshop
from tests.web.test_german_pages import GERMAN, english

HTML = {"accept": "text/html"}


def test_pieces_and_run_out_are_asked_for_and_stored(shop: Workshop) -> None:
    machine, box = shop.machine(), shop.box()
    asked = {"machine_id": machine, "catalogue_id": box, "technician": "Ada", "more": "yes"}
    page = shop.client.post("/sessions/new", data=asked, headers=GERMAN)
    assert (page.status_code, english(page.text)) == (200, [])
    assert 'value="Ada"' in page.text
    places = re.findall(r'<option value="([^"]+)">Ebene [^<]*Loch', page.text)
    assert places[:2] == ["0 20", "0 40"]
    known = dict(re.findall(r'name="(known|known_of)" value="([\w-]+)"', page.text))
    assert known == {"known": "yes", "known_of": machine}
    sent = {name: text for name, text in asked.items() if name != "more"} | known
    sent |= {"on_rotor[1].place": "1 40", "on_rotor[1].mass_g": "1 oz", "on_rotor[1].may": "remove"}
    sent |= {"run_out[1].amplitude": "0.2", "run_out[1].phase_deg": "-90"}
    other = shop.machine()
    refused = shop.client.post("/sessions/new", data={**sent, "machine_id": other}, headers=HTML)
    assert "typed for another machine" in refused.text
    answer = shop.client.post("/sessions/new", data=sent, headers=HTML, follow_redirects=False)
    assert answer.status_code == 303
    session = shop.get(answer.headers["location"])
    assert session["on_rotor"] == [{"plane": "2", "position_deg": 40.0, "mass_g": 28.349523125, "may": "remove"}]
    assert session["run_out"] == [{"sensor": "Q", "amplitude": 0.2, "phase_deg": -90.0}]


def test_who_has_chosen_no_machine_is_asked_for_it_first(shop: Workshop) -> None:
    shop.machine(), shop.machine()
    page = shop.client.post("/sessions/new", data={"more": "yes"}, headers=HTML)
    assert page.status_code == 422
    assert "Choose the machine" in page.text
