"""Runs of design studies: followed by their events, stopped, read again."""

from __future__ import annotations

import json
from typing import Any

import pytest

from service.app import PREFIX
from service.usecases.designs import runs
from tests.support.http.workshop import Workshop, problem_of

pytestmark = pytest.mark.only("sqlite")
"""The tables are tried on every engine by `test_studies`."""


@pytest.fixture
def beating(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run tells of each step: the clock of the tests hardly goes on."""
    monkeypatch.setattr(runs, "BEAT_S", 0.0)


def document(shop: Workshop, name: str) -> dict[str, Any]:
    return {**shop.get(f"/designs/{name}")["document"], "published": []}


def ended(shop: Workshop, body: dict[str, Any]) -> dict[str, Any]:
    run = shop.post("/design-runs", body)
    assert run["state"] == "running"
    shop.work.background.wait(run["id"], 60.0)
    found: dict[str, Any] = shop.get(f"/design-runs/{run['id']}")
    return found


def events(shop: Workshop, run_id: str) -> list[dict[str, Any]]:
    with shop.client.stream("GET", f"{PREFIX}/design-runs/{run_id}/events") as answer:
        lines = [line for line in answer.iter_lines() if line.startswith("data: ")]
    return [json.loads(line.removeprefix("data: ")) for line in lines]


def test_a_run_of_a_study_keeps_its_optimum(shop: Workshop, beating: None) -> None:
    study = shop.post("/design-studies", {"name": "Pair", "document": document(shop, "gear_pair")})
    run = ended(shop, {"study_id": study["id"]})
    assert (run["state"], run["study_version"]) == ("done", 1)
    assert (run["outcome"]["status"], run["outcome"]["evidence"]["kind"]) == ("optimal", "proved_bound")
    assert run["progress"]["value"] == pytest.approx(run["outcome"]["value"])
    assert [one["id"] for one in shop.get(f"/design-runs?study_id={study['id']}")] == [run["id"]]
    (last,) = events(shop, run["id"])
    assert (last["state"], last["progress"]) == ("done", run["progress"])


def test_a_front_is_kept_with_a_design_at_each_point(shop: Workshop) -> None:
    run = ended(shop, {"document": document(shop, "shaft_set_conflict"), "kind": "front", "points": 5})
    assert (run["state"], run["front"]["complete"]) == ("done", True)
    point = run["front"]["points"][2]
    asked = {**run["document"], "design": point["design"]}
    scalars = shop.post("/design-evaluations", {"document": asked})["responses"]["scalars"]
    assert {one["name"]: one["value"] for one in scalars}["energy"] == pytest.approx(point["first"], rel=1e-6)


def test_a_run_tells_how_far_it_is_and_stops_with_what_it_has(shop: Workshop, beating: None) -> None:
    body = {"document": document(shop, "flywheel_thresher"), "method": "jaya", "steps": 100_000}
    run = shop.post("/design-runs", body)
    told = []
    with shop.client.stream("GET", f"{PREFIX}/design-runs/{run['id']}/events") as answer:
        for line in answer.iter_lines():
            if line.startswith("data: "):
                told.append(json.loads(line.removeprefix("data: ")))
                if told[-1]["state"] == "running" and told[-1]["progress"]["steps"] > 0:
                    shop.client.delete(f"{PREFIX}/design-runs/{run['id']}")
    assert told[-1]["state"] == "stopped"
    steps = [one["progress"]["steps"] for one in told]
    assert steps == sorted(steps)
    found = shop.get(f"/design-runs/{run['id']}")
    assert found["outcome"]["status"] == "stopped"
    assert found["outcome"]["after"]["scalars"]
    assert shop.client.delete(f"{PREFIX}/design-runs/{run['id']}").json()["state"] == "stopped"


def test_another_replica_can_stop_a_run(shop: Workshop, beating: None, monkeypatch: pytest.MonkeyPatch) -> None:
    body = {"document": document(shop, "flywheel_thresher"), "method": "jaya", "steps": 100_000}
    run = shop.post("/design-runs", body)
    here = shop.work.background
    monkeypatch.setattr(here, "stop", lambda _key: None)
    shop.client.delete(f"{PREFIX}/design-runs/{run['id']}")
    here.wait(run["id"], 60.0)
    assert shop.get(f"/design-runs/{run['id']}")["state"] == "stopped"


def test_a_run_whose_service_was_lost_is_told_interrupted(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shop.work.background, "start", lambda _key, _act: None)
    run = shop.post("/design-runs", {"document": document(shop, "gear_pair")})
    assert shop.get(f"/design-runs/{run['id']}")["state"] == "running"
    for _ in range(round(runs.LOST.total_seconds())):
        shop.work.now()  # goes on by a second each time
    assert shop.get(f"/design-runs/{run['id']}")["state"] == "interrupted"


def test_what_cannot_be_computed_is_refused_before_anything_is_stored(shop: Workshop) -> None:
    pair = document(shop, "gear_pair")

    def refused(body: dict[str, Any]) -> Any:
        return shop.client.post(f"{PREFIX}/design-runs", json=body)

    problem_of(refused({}), 422, "design_run_of_what")
    problem_of(refused({"document": pair, "study_id": "x"}), 422, "design_run_of_what")
    problem_of(refused({"study_id": "x"}), 404, "not_found")
    problem_of(refused({"document": pair, "method": "sqp"}), 422, "design_name_unknown")
    problem_of(refused({"document": pair, "kind": "front"}), 422, "design_no_front")
    problem_of(shop.client.get(f"{PREFIX}/design-runs/none/events"), 404, "not_found")
    assert shop.get("/design-runs") == []


def test_no_more_run_at_once_than_may(shop: Workshop, beating: None) -> None:
    body = {"document": document(shop, "flywheel_thresher"), "method": "jaya", "steps": 100_000}
    begun = [shop.post("/design-runs", body)["id"] for _ in range(2)]
    refused = shop.client.post(f"{PREFIX}/design-runs", json=body)
    assert problem_of(refused, 503, "too_many_runs")["advice"]
    assert refused.headers["retry-after"] == "10"
    assert {one["id"] for one in shop.get("/design-runs")} == set(begun)
    shop.work.background.close()
    assert {one["state"] for one in shop.get("/design-runs")} == {"stopped"}
