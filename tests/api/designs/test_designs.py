"""Design studies over HTTP: answers in the document's units, refusals by name, limits of time kept."""

from __future__ import annotations

import json
from typing import Any

import pytest

from service.app import PREFIX
from tests.support.http.workshop import Workshop, problem_of

pytestmark = pytest.mark.only("sqlite")
"""Nothing is stored: an engine is as good as another."""


def gear(shop: Workshop) -> dict[str, Any]:
    return {**shop.get("/designs/gear_pair")["document"], "published": []}


def test_an_optimum_is_answered_in_the_units_of_its_document(shop: Workshop) -> None:
    answer = shop.post("/design-optima", {"document": gear(shop)})
    assert (answer["status"], answer["evidence"]["kind"]) == ("optimal", "proved_bound")
    scalars = {one["name"]: (one["value"], one["unit"]) for one in answer["after"]["scalars"]}
    assert scalars["distance"] == (pytest.approx(165.6053), "mm")
    again = shop.post("/design-evaluations", {"document": answer["document"]})
    assert again["responses"]["feasible"]


def test_a_linkage_is_evaluated_with_its_joints_over_a_turn(shop: Workshop) -> None:
    document = shop.get("/designs/sixbar")["document"]
    answer = shop.post("/design-evaluations", {"document": document})
    assert len(answer["drawing"]["joints"]["E"]) == 360
    assert {one["name"] for one in answer["curves"]} == {"force_x", "force_y", "moment", "torque"}


def test_refusals_are_problems_with_their_field(shop: Workshop) -> None:
    document = {**gear(shop), "units": {}}
    answer = shop.client.post(f"{PREFIX}/design-evaluations", json={"document": document})
    assert problem_of(answer, 422, "design_unit_missing")["field"].startswith("gear.")
    found = shop.post("/design-checks", {"document": document})
    assert not found["accepted"]
    assert len(found["findings"]) > 3
    answer = shop.client.post(f"{PREFIX}/design-optima", json={"document": {"study": "bridge"}})
    problem_of(answer, 422, "design_study_unknown")
    problem_of(shop.client.get(f"{PREFIX}/designs/bridge"), 404, "design_preset_unknown")


def test_what_is_no_number_is_refused(shop: Workshop) -> None:
    body = json.dumps({"document": gear(shop)}).replace("7.5", "NaN", 1)
    headers = {"content-type": "application/json"}
    answer = shop.client.post(f"{PREFIX}/design-evaluations", content=body, headers=headers)
    assert answer.status_code == 422


def test_a_search_ends_at_its_time_limit(shop: Workshop) -> None:
    document = shop.get("/designs/flywheel_literature")["document"]
    body = {"document": document, "steps": 500, "time_limit_s": 5e-6}  # the clock goes on by 1e-6 s a look
    answer = shop.post("/design-optima", body)
    assert answer["evidence"]["starts"] < 10
    assert answer["status"] in ("limit_reached", "converged")
