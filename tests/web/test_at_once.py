"""Two tablets at the same instant, and one form sent twice: done once, and never on what was not seen."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Barrier
from typing import Any

import pytest

from service.runtime import idempotency
from service.runtime.solver_slots import SolverSlots
from tests.support.http.workshop import Workshop, application, tablet

HTML = {"accept": "text/html"}
RUN = {"readings[0].amplitude": "3.11", "readings[0].phase_deg": "40"}


def hidden(shop: Workshop, path: str) -> dict[str, str]:
    """The stamp and the key that the first form of a page carries with it."""
    page = shop.client.get(path, headers=HTML).text
    main = page[page.index("<main") :]
    return dict(re.findall(r'name="(stamp|form_key)" value="(\w+)"', main)[:2])


def at_once(monkeypatch: pytest.MonkeyPatch, path: str, forms: Sequence[Mapping[str, str]]) -> list[Any]:
    """The answers to forms that are sent together: each is read, and found fresh, before any is done."""
    met, do = Barrier(len(forms), timeout=30), idempotency.answer

    def together(*given: Any) -> Any:
        met.wait()
        return do(*given)

    monkeypatch.setattr(idempotency, "answer", together)

    def send(form: Mapping[str, str]) -> Any:
        return tablet(application()).post(path, data=dict(form), headers=HTML, follow_redirects=False)

    try:
        with ThreadPoolExecutor(len(forms)) as pool:
            return sorted(pool.map(send, forms), key=lambda answer: int(answer.status_code))
    finally:
        monkeypatch.undo()


def test_of_two_tablets_at_the_same_instant_one_is_refused_and_shown_the_newer_state(
    shop: Workshop, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = shop.session()
    forms = [{**hidden(shop, f"/sessions/{session}"), **RUN, "readings[0].amplitude": text} for text in ("3.1", "9.9")]
    assert len({form["stamp"] for form in forms}) == 1
    stored, refused = at_once(monkeypatch, f"/sessions/{session}/runs", forms)
    assert (stored.status_code, refused.status_code) == (303, 409)
    assert "What you sent was not stored" in refused.text
    assert "Trial run in plane 1" in refused.text
    assert len(shop.get(f"/sessions/{session}")["runs"]) == 1


def test_two_plans_at_the_same_instant_are_one(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    session = shop.session()
    shop.learn(session)
    shop.correct(session)
    asked = {"objective": "residual_vibration", "mode": "best", "max_masses_per_plane": "1"}
    forms = [{**hidden(shop, f"/sessions/{session}"), **asked} for _ in range(2)]
    answers = at_once(monkeypatch, f"/sessions/{session}/plans", forms)
    assert [answer.status_code for answer in answers] == [303, 409]
    assert len(shop.get(f"/sessions/{session}")["plans"]) == 1


def test_a_form_sent_twice_at_the_same_instant_is_done_once(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    session = shop.session()
    form = {**hidden(shop, f"/sessions/{session}"), **RUN}
    answers = at_once(monkeypatch, f"/sessions/{session}/runs", [form, form])
    assert [(answer.status_code, answer.headers["location"]) for answer in answers] == [
        (303, f"/sessions/{session}")
    ] * 2
    assert len(shop.get(f"/sessions/{session}")["runs"]) == 1
    again = shop.client.post(f"/sessions/{session}/runs", data=form, headers=HTML, follow_redirects=False)
    assert (again.status_code, again.headers["location"]) == (303, f"/sessions/{session}")
    changed = {**form, "readings[0].amplitude": "9.9"}
    assert shop.client.post(f"/sessions/{session}/runs", data=changed, headers=HTML).status_code == 409
    assert len(shop.get(f"/sessions/{session}")["runs"]) == 1


def test_a_delivery_sent_twice_is_booked_once(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    box = shop.box(count=10)
    form = {**hidden(shop, f"/boxes/{box}"), "received[0]": "5"}
    assert [one.status_code for one in at_once(monkeypatch, f"/boxes/{box}", [form, form])] == [303, 303]
    assert shop.on_hand(box)[10.0] == 15
    fresh = {**hidden(shop, f"/boxes/{box}"), "received[0]": "5"}
    assert shop.client.post(f"/boxes/{box}", data=fresh, headers=HTML, follow_redirects=False).status_code == 303
    assert shop.on_hand(box)[10.0] == 20


def test_a_machine_and_a_session_sent_twice_are_one(shop: Workshop) -> None:
    machine, box = shop.machine(), shop.box()
    form = {**hidden(shop, "/sessions/new"), "machine_id": machine, "catalogue_id": box}
    sent = [shop.client.post("/sessions/new", data=form, headers=HTML, follow_redirects=False) for _ in range(2)]
    assert sent[0].headers["location"] == sent[1].headers["location"]
    assert len(shop.get("/sessions")) == 1


def test_a_plan_that_is_asked_for_while_too_many_are_computed_is_asked_for_again(shop: Workshop) -> None:
    session, turns = shop.session(), SolverSlots(1, wait_s=0.0)
    application().state.work = replace(shop.work, turns=turns)
    shop.learn(session)
    shop.correct(session)
    form = {**hidden(shop, f"/sessions/{session}/step/plan"), "objective": "components"}
    path = f"/sessions/{session}/plans"
    with turns.turn():
        busy = shop.client.post(path, data=form, headers=HTML)
    assert (busy.status_code, busy.headers["retry-after"]) == (503, "2")
    assert f'<form method="post" action="{path}" data-again-s="2">' in busy.text
    typed = dict(re.findall(r'<input type="hidden" name="([\w.]+)" value="(\w*)">', busy.text))
    assert typed.items() >= form.items()
    assert shop.client.post(path, data=typed, headers=HTML, follow_redirects=False).status_code == 303
    (plan,) = shop.get(f"/sessions/{session}")["plans"]
    with turns.turn():
        front = shop.client.get(f"{path}/{plan['id']}/front", headers=HTML)
    assert (front.status_code, front.headers["refresh"]) == (503, "2")
