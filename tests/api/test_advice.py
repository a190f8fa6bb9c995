"""What a refusal advises is something that the service would then take."""

from __future__ import annotations

import pytest

from tests.api.workshop import JSON, Workshop, machine_body, problem_of


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
