"""A trial mass is compared with the load and with what is usual before the drum turns, and its effect shown after."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.http.workshop import DRUM, Workshop, mass, reading
from tests.web.session.test_undoing import HTML, LOCKED, RELEASED, send


def bolt(shop: Workshop, session: str, grams: str, **more: str) -> Any:
    """State a trial mass in hole 1 of plane 1, the machine being locked."""
    return send(
        shop,
        session,
        f"stops/{more.pop('stop', '1')}/trial",
        **{"masses.mass_g": grams, "masses.angle_deg": "20"},
        **more,
    )


@pytest.fixture
def locked(shop: Workshop) -> tuple[Workshop, str]:
    session = shop.session()
    shop.run(session, "initial")
    send(shop, session, "stops", purpose="trial", plane="1")
    send(shop, session, "stops/1/lock", **LOCKED)
    return shop, session


def test_five_kilograms_are_refused_with_the_force_and_the_share(locked: tuple[Workshop, str]) -> None:
    """5 kg at 330 mm and 460 r/min: 5 * 0.33 * 48.17**2 = 3829 N, the bearing carries 60 kg * 9.81 = 588 N."""
    shop, session = locked
    answer = bolt(shop, session, "5000", **{"sure.5000": "yes"})
    assert answer.status_code == 422
    assert "3829\N{NARROW NO-BREAK SPACE}N" in answer.text
    assert "Bolt the trial mass" in answer.text


@pytest.mark.parametrize(("grams", "said"), [("200", "of the load on the bearing"), ("0.2", "less than a third")])
def test_what_is_unusual_is_asked_about_and_the_tick_holds_for_that_mass_alone(
    locked: tuple[Workshop, str], grams: str, said: str
) -> None:
    shop, session = locked
    asked = bolt(shop, session, grams)
    assert asked.status_code == 422
    assert said in asked.text
    assert f'name="sure.{grams}"' in asked.text
    assert bolt(shop, session, "400", **{f"sure.{grams}": "yes"}).status_code == 422
    assert "Before the drum turns again" in bolt(shop, session, grams, **{f"sure.{grams}": "yes"}).text


def test_until_the_drum_has_turned_a_statement_can_be_taken_back(locked: tuple[Workshop, str]) -> None:
    shop, session = locked
    bolt(shop, session, "50", **{"sure.50": "yes"})
    assert "Bolt the trial mass" in send(shop, session, "stops/1/correct").text
    bolt(shop, session, "60", **{"sure.60": "yes"})
    send(shop, session, "stops/1/release", **RELEASED)
    assert "Stop the machine and lock it" in send(shop, session, "stops/1/correct").text
    assert shop.get(f"/sessions/{session}")["masses_on_rotor"] == []
    send(shop, session, "stops/1/lock", **LOCKED)
    bolt(shop, session, "60", **{"sure.60": "yes"})
    send(shop, session, "stops/1/release", **RELEASED)
    shop.run(session, "trial", [mass("1", 60.0, 20.0)])
    assert send(shop, session, "stops/1/correct").status_code == 409


def test_a_fitted_plan_is_taken_back_with_its_stock(shop: Workshop) -> None:
    session = shop.session()
    plan = shop.planned(session)
    box = shop.get(f"/sessions/{session}")["catalogue_id"]
    before = shop.on_hand(box)
    send(shop, session, "stops", purpose="plan", plan_id=plan["id"])
    send(shop, session, "stops/1/lock", **LOCKED)
    send(shop, session, "stops/1/plan")
    assert shop.on_hand(box) != before
    assert "Change the masses" in send(shop, session, "stops/1/correct").text
    assert shop.on_hand(box) == before
    assert "Before the drum turns again" in send(shop, session, "stops/1/plan").text


def test_a_forgotten_trial_mass_is_noticed_right_after_its_run(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    shop.post(
        f"/sessions/{session}/runs",
        {"kind": "trial", "masses": [mass("1", 60.0, 20.0)], "readings": DRUM.readings()},
    )
    page = shop.client.get(f"/sessions/{session}", headers=HTML).text
    assert "Is it on the drum?" in page
    run = shop.get(f"/sessions/{session}")["runs"][-1]["id"]
    assert "Stop the machine and lock it" in send(shop, session, f"runs/{run}/repeat").text
    assert shop.get(f"/sessions/{session}")["runs"][-1]["excluded"]


def test_a_clear_answer_is_shown_without_a_question(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    shop.run(session, "trial", [mass("1", 200.0, 20.0)])
    page = shop.client.get(f"/sessions/{session}", headers=HTML).text
    assert "What the trial mass in plane 1 did" in page
    assert "Repeat this trial run" not in page


def test_without_phase_the_guide_asks_for_as_many_runs_as_are_needed(shop: Workshop) -> None:
    session = shop.session()

    def run(kind: str, masses: list[dict[str, Any]]) -> None:
        readings = [reading(s, v) | {"phase_deg": None} for s, v in DRUM.vibration(masses).items()]
        shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})

    run("initial", [])
    for plane, angle in (("1", 0.0), ("2", 0.0), ("1", 120.0)):
        run("trial", [mass(plane, 200.0, angle)])
        assert shop.get(f"/sessions/{session}")["step"] == "trial"
    assert "Without phase 1 more runs are needed" in shop.client.get(f"/sessions/{session}", headers=HTML).text
    run("trial", [mass("2", 200.0, 120.0)])
    assert shop.get(f"/sessions/{session}")["step"] == "correction"
    assert send(shop, session, "corrections", source="fit").status_code == 200


def checked(shop: Workshop, session: str) -> None:
    """Plan, fit and check the latest correction."""
    plan = shop.plan(session, shop.get(f"/sessions/{session}")["corrections"][-1], objective="components")
    shop.fit(plan)
    seen = shop.get(f"/sessions/{session}")["masses_on_rotor"]
    shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": DRUM.readings(seen)})


def test_a_trim_after_a_balancers_answer_takes_its_next_answer(shop: Workshop) -> None:
    session = shop.session()
    answer = {
        "masses[0].mass_g": "120",
        "masses[0].angle_deg": "200",
        "masses[1].mass_g": "60",
        "masses[1].angle_deg": "80",
    }
    assert send(shop, session, "corrections", source="balancer", **answer).status_code == 200
    checked(shop, session)
    page = shop.client.get(f"/sessions/{session}", headers=HTML).text
    assert "The balancer has computed the masses anew" in page
    assert "Choose the pieces" in send(shop, session, "corrections", source="balancer", **answer).text


def test_a_trim_after_saved_influence_uses_it_again(shop: Workshop) -> None:
    machine = shop.machine()
    first = shop.session(machine)
    shop.planned(first)
    shop.post(f"/machines/{machine}/influence", {"session_id": first})
    second = shop.session(machine)
    shop.run(second, "initial")
    page = shop.client.get(f"/sessions/{second}", headers=HTML).text
    assert page.index("Use what the machine taught") < page.index("Stop the machine to bolt it on")
    shop.correct(second, source="saved_influence")
    checked(shop, second)
    page = shop.client.get(f"/sessions/{second}", headers=HTML).text
    assert 'name="source" value="saved_influence"' in page
    assert "Choose the pieces" in send(shop, second, "corrections", source="saved_influence").text
