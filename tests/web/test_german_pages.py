"""A German session with findings and refusals, from new machine to certificate: nothing of it is in English."""

from __future__ import annotations

import html
import re

from service.usecases.sessions import reports, sessions
from service.web.certificate.content import certificate
from service.web.certificate.pdf import to_pdf
from service.web.pictures.reader import Reader
from service.web.preferences import Preferences
from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass
from tests.web.certificate.test_certificate import pages_of

GERMAN = {"accept": "text/html", "accept-language": "de"}
ENGLISH = re.compile(r"\b(the|is|are|and|of|with|which|has|have|must|its|to|from|for|be|or|this|that|take|run|plane)\b")
"""Words that every English sentence of the service has one of, and no German one."""


def english(page: str) -> list[str]:
    """Lines of a page's text, hints and descriptions too, that are in English."""
    body = re.sub(r"(?s)<(style|script)\b.*?</\1>|<svg[^>]*>|class=\"[^\"]*\"", " ", page)
    said = re.findall(r'(?:aria-label|title|placeholder|data-[a-z]+-text|data-text)="([^"]*)"', page)
    lines = [html.unescape(one).strip() for one in (*re.split(r"<[^>]*>", body), *said)]
    return [line for line in lines if ENGLISH.search(line)]


def look(shop: Workshop, path: str, status: int = 200) -> str:
    """A page, once nothing of it is in English."""
    answer = shop.client.get(path, headers=GERMAN)
    assert answer.status_code == status, answer.text[:500]
    assert english(answer.text) == [], path
    return str(answer.text)


def send(shop: Workshop, session: str, path: str, *, status: int = 303, **fields: str) -> str:
    """A form of the session, sent as its page would."""
    page = shop.client.get(f"/sessions/{session}", headers=GERMAN).text
    stamp = re.search(r'name="stamp" value="(\w+)"', page)
    sent = {"stamp": stamp.group(1) if stamp else "", **fields}
    answer = shop.client.post(f"/sessions/{session}/{path}", data=sent, headers=GERMAN, follow_redirects=False)
    fault = re.findall(r"class=\"fault[^>]*>([^<]*)", answer.text)
    assert answer.status_code == status, (path, fault)
    assert english(answer.text) == [], path
    return str(answer.text)


def mirrored() -> LinearDrum:
    """The drum with a stray run: what it says contradicts the others."""
    return LinearDrum({"P": 5.0 + 1.0j, "Q": -3.0 + 2.0j}, DRUM.influence)


def test_a_german_session_with_findings_and_refusals_says_nothing_in_english(shop: Workshop) -> None:
    machine = shop.machine(balance_grade_mm_s=16.0)
    box = shop.post("/catalogues", {"name": "Kasten", "items": [{"mass_g": 10.0, "count": 1}]})
    key = shop.session(machine, box["id"])
    for path in ("/", "/sessions", "/sessions/new", "/machines", f"/boxes/{box['id']}", "/boxes/new", "/sources"):
        look(shop, path)
    look(shop, f"/sessions/{key}")
    send(shop, key, "corrections", source="fit", status=422)
    send(shop, key, "corrections", source="saved_influence", status=422)
    send(shop, key, "runs/take", status=422)
    shop.learn(key)
    shop.run(key, "trial", [mass("1", 2000.0, 90.0)], mirrored())
    shop.run(key, "trial", [mass("1", 2000.0, 90.0)])
    look(shop, f"/sessions/{key}")
    look(shop, f"/sessions/{key}/runs")
    send(shop, key, "corrections", source="fit")
    assert shop.get(f"/sessions/{key}")["corrections"][-1]["diagnostics"], "there is something to find"
    look(shop, f"/sessions/{key}/step/correction")
    # One piece of 10 g meets no limit: the plan says why, and what would help.
    send(shop, key, "plans", objective="residual_vibration", mode="fewest", max_masses_per_plane="1")
    assert shop.get(f"/sessions/{key}")["plans"][-1]["status"] == "infeasible"
    look(shop, f"/sessions/{key}/step/plan")
    send(shop, key, "plans", objective="residual_vibration", mode="best", max_masses_per_plane="1")
    plan = shop.get(f"/sessions/{key}")["plans"][-1]
    look(shop, f"/sessions/{key}/step/plan")
    front = f"/sessions/{key}/plans/{plan['id']}/front"
    look(shop, front)
    shop.ask("PATCH", f"/sessions/{key}", {"catalogue_id": shop.box()})
    assert f"Aus dem Kasten „{box['name']}“" in look(shop, front)
    shop.ask("PATCH", f"/sessions/{key}", {"catalogue_id": box["id"]})
    send(shop, key, "stops", purpose="plan", plan_id="none", status=404)
    send(shop, key, "stops/9/lock", standstill="yes", key_out="yes", blocked="yes", status=404)
    send(shop, key, "stops", purpose="plan", plan_id=plan["id"])
    send(shop, key, "stops/1/plan", status=409)
    send(shop, key, "stops/1/lock", status=422)
    send(shop, key, "stops/1/lock", standstill="yes", key_out="yes", blocked="yes")
    shop.ask("PATCH", f"/catalogues/{box['id']}", {"counted": [{"mass_g": 10.0, "pieces": 0}]})
    send(shop, key, "stops/1/plan", status=409)
    shop.ask("PATCH", f"/catalogues/{box['id']}", {"received": [{"mass_g": 10.0, "pieces": 1}]})
    send(shop, key, "stops/1/plan")
    send(shop, key, "stops/1/cancel", status=409)
    send(shop, key, "stops/1/release", torqued="yes", tools_out="yes", guards_on="yes")
    look(shop, f"/sessions/{key}/step/fit")
    shop.run(key, "check", [mass("1", 10.0, 0.0)])
    look(shop, f"/sessions/{key}")
    look(shop, f"/sessions/{key}/step/check")
    report = look(shop, f"/sessions/{key}/report")
    assert "Auswuchtprotokoll" in report
    sheet = certificate(sessions.get(shop.work, key), reports.report(shop.work, key), Reader(Preferences("de")))
    assert [line for page in pages_of(to_pdf(sheet)) for line in re.split(r"[.:;]", page) if ENGLISH.search(line)] == []
    send(shop, key, "close")
    look(shop, f"/sessions/{key}")
    send(shop, key, "teach")
    send(shop, key, "runs", status=409, **{"readings[0].amplitude": "3,1"})
