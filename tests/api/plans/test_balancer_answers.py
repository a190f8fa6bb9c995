"""What a balancer answers is held against the session, the machine and the box before masses are mounted by it."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

from tests.support.http.workshop import Workshop, mass

WHOLE = [mass("1", 120.0, 33.0), mass("2", 90.0, 190.0)]


def answered(shop: Workshop, machine: str, *, masses: list[dict[str, Any]] = WHOLE, days: float = 0.0) -> Any:
    """A stored answer of the machine's balancer, dated so many days from now."""
    shop.ask("PUT", "/sources/balancer", {"machine_id": machine})
    taken_at = (shop.now() + timedelta(days=days)).isoformat()
    number = int(shop.now().timestamp() * 1000)
    body = {"source": "balancer", "sequence": number, "taken_at": taken_at, "masses": masses}
    return shop.post("/balancer-answers", body)


def doubts(shop: Workshop, session: str, **request: Any) -> set[str]:
    """Codes of what is asked about a correction by an answer."""
    correction = shop.post(f"/sessions/{session}/corrections", {"source": "balancer", **request})
    return {one["code"] for one in correction["diagnostics"]}


def test_an_answer_for_this_session_now_is_taken_as_it_is(shop: Workshop) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    answer = answered(shop, machine)
    assert answer["session_id"] == session
    assert doubts(shop, session, answer_id=answer["id"]) == set()


def test_an_answer_of_another_day_is_asked_about(shop: Workshop) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    assert doubts(shop, session, answer_id=answered(shop, machine, days=-3.0)["id"]) == {"answer_older_than_session"}
    assert doubts(shop, session, answer_id=answered(shop, machine, days=365.0)["id"]) == {"answer_dated_ahead"}


def test_a_plane_without_an_answer_is_asked_about_and_nothing_is_an_answer(shop: Workshop) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    half = answered(shop, machine, masses=WHOLE[:1])
    assert doubts(shop, session, answer_id=half["id"]) == {"plane_not_answered"}
    nothing = answered(shop, machine, masses=[WHOLE[0], mass("2", 0.0, 0.0)])
    correction = shop.correct(session, source="balancer", answer_id=nothing["id"])
    assert correction["diagnostics"] == []
    assert [round(one["mass_g"], 6) for one in correction["corrections"]] == [120.0, 0.0]
    assert shop.plan(session, correction, objective="components")["status"] == "optimal"


def test_masses_that_the_box_does_not_come_near_are_asked_about(shop: Workshop) -> None:
    """The sentinel of a 24-bit field of 0.00625 g, say."""
    session = shop.session()
    far = [mass("1", 104_857.5, 0.0), WHOLE[1]]
    assert doubts(shop, session, masses=far) == {"answer_beyond_box"}


def test_one_plane_named_twice_is_refused(shop: Workshop) -> None:
    machine = shop.machine()
    shop.session(machine)
    shop.ask("PUT", "/sources/balancer", {"machine_id": machine})
    body = {"source": "balancer", "sequence": 1, "taken_at": shop.now().isoformat(), "masses": [WHOLE[0], WHOLE[0]]}
    assert shop.refused("POST", "/balancer-answers", body, 422, "invalid_input")["field"] == "masses"


def test_an_answer_for_one_of_two_open_sessions_may_be_taken_by_either_and_is_asked_about(shop: Workshop) -> None:
    machine = shop.machine()
    first, second = shop.session(machine), shop.session(machine)
    answer = answered(shop, machine)
    assert answer["session_id"] is None
    for session in (first, second):
        assert doubts(shop, session, answer_id=answer["id"]) == {"answer_for_several_sessions"}
    named = answered(shop, machine)["id"]
    shop.ask("PATCH", f"/sessions/{second}", {"state": "closed"})
    assert doubts(shop, first, answer_id=named) == set()
