"""Design studies that are kept: versions, history, and a verification that covers them."""

from __future__ import annotations

from typing import Any

from service.app import PREFIX
from service.usecases import audit
from tests.support.http.workshop import Workshop, problem_of


def gear(shop: Workshop, **design: Any) -> dict[str, Any]:
    document = {**shop.get("/designs/gear_pair")["document"], "published": []}
    return {**document, "design": {**document["design"], **design}}


def put(shop: Workshop, study: str, body: dict[str, Any], seen: int | None = None) -> Any:
    headers = {} if seen is None else {"If-Match": f'"{seen}"'}
    return shop.client.put(f"{PREFIX}/design-studies/{study}", json=body, headers=headers)


def test_a_study_keeps_its_versions_and_each_can_be_read_again(shop: Workshop) -> None:
    first = shop.post("/design-studies", {"name": "Pair", "document": gear(shop), "note": "as published"})
    assert (first["version"], first["study"]) == (1, "gear_pair")
    changed = gear(shop, teeth=19)
    answer = put(shop, first["id"], {"name": "Pair", "document": changed, "note": "more teeth"}, seen=1)
    assert (answer.json()["version"], answer.headers["etag"]) == (2, '"2"')
    same = put(shop, first["id"], {"name": "Pair", "document": changed, "note": "more teeth"})
    assert same.json()["version"] == 2
    third = put(shop, first["id"], {"name": "Other name", "document": changed, "note": "more teeth"}).json()
    assert third["version"] == 3
    versions = shop.get(f"/design-studies/{first['id']}/versions")
    assert [(one["version"], one["name"], one["note"]) for one in versions] == [
        (3, "Other name", "more teeth"),
        (2, "Pair", "more teeth"),
        (1, "Pair", "as published"),
    ]
    assert [one["document"]["design"]["teeth"] for one in versions] == [19, 19, first["document"]["design"]["teeth"]]
    assert shop.get(f"/design-studies/{first['id']}/versions/1")["document"] == first["document"]
    problem_of(shop.client.get(f"{PREFIX}/design-studies/{first['id']}/versions/9"), 404, "design_version_not_found")
    assert [one["id"] for one in shop.get("/design-studies")] == [first["id"]]


def test_a_change_on_an_older_version_is_refused_with_the_present_one(shop: Workshop) -> None:
    study = shop.post("/design-studies", {"name": "Pair", "document": gear(shop)})
    assert put(shop, study["id"], {"name": "B", "document": gear(shop)}, seen=1).status_code == 200
    refused = put(shop, study["id"], {"name": "C", "document": gear(shop)}, seen=1)
    assert refused.status_code == 412
    assert refused.json()["code"] == "version_stale"
    assert refused.json()["current"]["name"] == "B"


def test_a_document_that_breaks_a_rule_is_not_kept(shop: Workshop) -> None:
    bad = gear(shop, teeth=-1)
    answer = shop.client.post(f"{PREFIX}/design-studies", json={"name": "Pair", "document": bad})
    problem_of(answer, 422, "design_out_of_range")
    assert shop.get("/design-studies") == []
    problem_of(shop.client.get(f"{PREFIX}/design-studies/none"), 404, "not_found")


def test_the_verification_covers_studies_and_runs(shop: Workshop) -> None:
    study = shop.post("/design-studies", {"name": "Pair", "document": gear(shop)})
    run = shop.post("/design-runs", {"study_id": study["id"]})
    shop.work.background.wait(run["id"], 60.0)
    assert audit.verify(shop.work).findings == ()
    assert {one["kind"] for one in shop.get("/history")} >= {"design_study", "design_run"}
    with shop.work.database.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE design_study SET study = replace(study, 'Pair', 'Bear')")
        connection.exec_driver_sql("UPDATE design_run SET run = replace(run, 'done', 'gone')")
    assert [one.code for one in audit.verify(shop.work).findings] == ["row_altered", "row_altered"]
