"""What a refusal advises is something that the service would then take."""

from __future__ import annotations

import pytest

from tests.support.http.workshop import JSON, Workshop, machine_body, problem_of


@pytest.mark.parametrize(("quantity", "unit"), [("velocity", "um"), ("displacement", "g"), ("acceleration", "mm/s")])
def test_units_that_are_advised_are_taken(shop: Workshop, quantity: str, unit: str) -> None:
    def body(name: str, stated: str) -> dict[str, object]:
        return machine_body(name, sensors=[{"name": "P", "quantity": quantity, "unit": stated}])

    advice = shop.refused("POST", "/machines", body("drum", unit), 422, "invalid_input")["advice"]
    advised = advice.removeprefix("use one of: ").split(", ")
    assert advised
    for number, taken in enumerate(advised):
        shop.post("/machines", body(f"drum {number}", taken))


def test_a_plane_is_named_once_in_a_correction(shop: Workshop) -> None:
    session = shop.session()
    shop.learn(session)
    body = {"source": "fit", "planes": ["1", "1"]}
    problem = shop.refused("POST", f"/sessions/{session}/corrections", body, 422, "invalid_input")
    assert (problem["field"], problem["value"]) == ("planes", "1")


@pytest.mark.parametrize(
    ("path", "words"), [("readings", "smaller batches"), ("blocks", "shorter blocks"), ("machines", "in parts")]
)
def test_too_long_a_body_is_advised_on_what_it_is(shared_shop: Workshop, path: str, words: str) -> None:
    answer = shared_shop.client.post(f"/api/v1/{path}", content=b"[" + b" " * (5 << 20), headers=JSON)
    assert words in problem_of(answer, 413, "too_large")["advice"]


RUN_OF_NONE = {"kind": "initial", "readings": []}
NOTHING_MOVED = {"kind": "received", "pieces": [{"mass_g": 10.0, "pieces": 0}]}
WORDED = [
    ("PATCH", "/sessions/$session", {"state": "open"}, "state", "cannot be reopened"),
    ("POST", "/sessions/$session/runs", RUN_OF_NONE, "readings", "the list must have at least 1 "),
    ("POST", "/sessions/$session/runs", {}, "kind", "this field is required"),
    ("POST", "/machines", machine_body(foo=1), "foo", "there is no such field here"),
    ("POST", "/machines", machine_body(rotor_mass_kg=1e12), "rotor_mass_kg", "at most 1000000000"),
    ("POST", "/machines", machine_body("a\tb\x01"), "name", "characters that "),
    ("PATCH", "/sessions/$session/runs/$run", {"excluded": True, "reason": " "}, "reason", "at least 1 char"),
    ("POST", "/catalogues/$box/stock", NOTHING_MOVED, "pieces[0].pieces", "a movement of"),
    ("GET", "/history?kind=foo", None, "kind", 'no history of "foo"'),
    ("GET", "/sources/x/readings?from=2026-03-02T00:00:00Z&to=2026-03-01T00:00:00Z", None, "from", "after the last"),
]


@pytest.mark.parametrize(("method", "path", "body", "field", "words"), WORDED, ids=[w[-1] for w in WORDED])
def test_a_refusal_names_its_rule_in_words(
    shared_shop: Workshop, method: str, path: str, body: object, field: str, words: str
) -> None:
    shop, box = shared_shop, shared_shop.box()
    session = shop.session(box=box)
    run = shop.run(session, "initial")["id"]
    at = path.replace("$session", session).replace("$box", box).replace("$run", run)
    problem = shop.refused(method, at, body, 422, "invalid_input")
    assert problem["field"] == field
    assert words in problem["detail"]
    assert "keeps the rule" not in problem["advice"]
    assert "Tuple" not in problem["detail"]
