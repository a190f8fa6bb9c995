"""A fit is undone in a stop, as every change of masses; what to expect is shown before, and follows what is on."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.support.http.workshop import Workshop, on_rotor

HTML = {"accept": "text/html"}
LOCKED = {"standstill": "yes", "key_out": "yes", "blocked": "yes"}
RELEASED = {"torqued": "yes", "tools_out": "yes", "guards_on": "yes"}


def send(shop: Workshop, session: str, path: str, **fields: str) -> Any:
    """A form of the session's present page; the page after it."""
    page = shop.client.get(f"/sessions/{session}", headers=HTML).text
    stamp = re.search(r'name="stamp" value="(\w+)"', page)
    assert stamp is not None
    return shop.client.post(f"/sessions/{session}/{path}", data={"stamp": stamp.group(1), **fields}, headers=HTML)


def amplitudes(page: str) -> list[str]:
    """The amplitudes of the first table of what to expect."""
    table = page[page.index("To expect") :]
    return re.findall(r'<b>[PQ]</b>.*?<td class="figure">([\d.]+)</td>', table[: table.index("</table>")], re.S)


@pytest.fixture
def planned(shop: Workshop) -> tuple[Workshop, str, Any]:
    session = shop.session()
    shop.learn(session)
    shop.correct(session)
    form = {"objective": "residual_vibration", "mode": "best", "max_masses_per_plane": "1"}
    assert send(shop, session, "plans", **form).status_code == 200
    return shop, session, shop.get(f"/sessions/{session}")["plans"][-1]


def test_a_fit_is_undone_only_once_the_machine_is_locked(planned: tuple[Workshop, str, Any]) -> None:
    shop, session, plan = planned
    box = shop.get(f"/sessions/{session}")["catalogue_id"]
    before = shop.on_hand(box)
    send(shop, session, "stops", purpose="plan", plan_id=plan["id"])
    send(shop, session, "stops/1/lock", **LOCKED)
    send(shop, session, "stops/1/plan")
    send(shop, session, "stops/1/release", **RELEASED)
    assert shop.on_hand(box) != before
    assert "Stop the machine and lock it" in send(shop, session, "stops", purpose="bare").text
    assert send(shop, session, "stops/2/bare").status_code == 409
    assert shop.on_hand(box) != before
    page = send(shop, session, "stops/2/lock", **LOCKED).text
    assert "Take the masses off" in page
    assert page.count('<li class="off">') == len(plan["placements"])
    assert "Before the drum turns again" in send(shop, session, "stops/2/bare").text
    assert shop.on_hand(box) == before
    assert "The best choice from the box" in send(shop, session, "stops/2/release", **RELEASED).text
    assert shop.get(f"/sessions/{session}")["fitted_plan_id"] is None


def test_an_alternative_says_what_to_expect_before_it_is_fitted(planned: tuple[Workshop, str, Any]) -> None:
    shop, session, plan = planned
    page = shop.client.get(f"/sessions/{session}/step/plan", headers=HTML).text
    assert page.count("What to expect of it") == len(plan["alternatives"]) > 0
    best = amplitudes(page)
    send(shop, session, "stops", purpose="plan", plan_id=plan["id"], alternative="0")
    other = amplitudes(send(shop, session, "stops/1/lock", **LOCKED).text)
    assert len(best) == len(other) == 2
    assert best != other
    fitted = send(shop, session, "stops/1/plan")
    assert fitted.status_code == 200
    # What was promised is what is computed for the pieces once they are stated.
    send(shop, session, "stops/1/release", **RELEASED)
    assert amplitudes(shop.client.get(f"/sessions/{session}/step/fit", headers=HTML).text) == other


def test_the_prediction_follows_what_was_really_fitted(planned: tuple[Workshop, str, Any]) -> None:
    shop, session, plan = planned
    send(shop, session, "stops", purpose="plan", plan_id=plan["id"])
    planned_for = amplitudes(send(shop, session, "stops/1/lock", **LOCKED).text)
    really = {"differs": "yes"}
    for index, piece in enumerate(plan["placements"]):
        hole = (piece["position_deg"] + 20.0) % 360.0
        really |= {f"actual[{index}].position_deg": f"{hole:g}", f"actual[{index}].mass_g": f"{piece['mass_g']:g}"}
    really["actual[0].weighed_g"] = f"{plan['placements'][0]['mass_g'] + 3.5:g}"
    assert send(shop, session, "stops/1/plan", **really).status_code == 200
    send(shop, session, "stops/1/release", **RELEASED)
    page = shop.client.get(f"/sessions/{session}/step/fit", headers=HTML).text
    assert amplitudes(page) != planned_for
    assert f"{plan['placements'][0]['mass_g'] + 3.5:g}" in page


def test_a_session_teaches_its_machine_once_and_the_next_needs_no_trial_run(shop: Workshop) -> None:
    machine, box = shop.machine(), shop.box()
    session = shop.session(machine, box)
    shop.learn(session)
    plan = shop.fit(shop.plan(session, shop.correct(session)))
    shop.run(session, "check", on_rotor(plan["fitted"]))
    page = shop.client.get(f"/sessions/{session}", headers=HTML).text
    assert "Teach the machine" in page
    page = send(shop, session, "teach").text
    assert "The machine has learned from this session" in page
    assert send(shop, session, "teach").status_code == 409
    described = shop.client.get(f"/machines/{machine}", headers=HTML).text
    assert "What the machine taught" in described
    assert "0.0140 <small>17°</small>" in described
    assert "mm/s rms for each g" in described
    after = shop.session(machine, box)
    shop.run(after, "initial")
    assert "Use what the machine taught" in shop.client.get(f"/sessions/{after}", headers=HTML).text
    assert "What the drum needs" in send(shop, after, "corrections", source="saved_influence").text


@pytest.mark.parametrize(
    ("objective", "unit"), [("residual_vibration", "1"), ("components", "g.mm"), ("bearing_force", "1")]
)
def test_a_plan_aims_at_what_was_chosen(shop: Workshop, objective: str, unit: str) -> None:
    session = shop.session()
    shop.learn(session)
    shop.correct(session)
    page = shop.client.get(f"/sessions/{session}/step/plan", headers=HTML).text
    assert f'name="objective" value="{objective}"' in page
    page = send(shop, session, "plans", objective=objective, mode="best", max_masses_per_plane="1").text
    assert "The best choice from the box" in page
    plan = shop.get(f"/sessions/{session}")["plans"][-1]
    assert (plan["request"]["objective"], plan["objective_unit"]) == (objective, unit)


@pytest.mark.parametrize(
    ("limit", "grade", "heading", "first"),
    [
        (1e-3, None, "Above the limit", "Trim"),
        (1e3, None, "within its limits", "Close"),
        (1e3, 1e-3, "Balance quality not reached", "Trim"),
        (1e3, 1e3, "within its limits", "Close"),
    ],
)
def test_what_the_heading_asks_for_stands_first_and_closing_asks_again(
    shop: Workshop, limit: float, grade: float | None, heading: str, first: str
) -> None:
    session = shop.session(shop.machine(vibration_limit_mm_s=limit, balance_grade_mm_s=grade))
    plan = shop.fit(shop.planned(session))
    shop.run(session, "check", on_rotor(plan["fitted"]))
    page = shop.client.get(f"/sessions/{session}", headers=HTML).text
    assert heading in page[page.index("<h1>") : page.index("</h1>")]
    assert re.search(r'class="button big">(\w+)', page[page.index("<h1>") :]).group(1) == first  # type: ignore[union-attr]
    assert (page.index("Trim: improve") < page.index("Close the session")) == (first == "Trim")
    asked = page[page.index('<details class="final">') :]
    assert asked.index("cannot be reopened") < asked.index("Close it for good") < asked.index("</details>")
    assert page.count(f'action="/sessions/{session}/close"') == asked.count(f'action="/sessions/{session}/close"') == 1
