"""Sessions stored from their logs: as they were, once, sealed, and never in place of another."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from db.database import Database
from service.errors import Conflict
from service.model.base import adapter, write_json
from service.model.machine import Catalogue, Machine
from service.model.session import SessionPatch
from service.model.stop import StopRequest
from service.runtime.context import AppContext
from service.usecases import audit
from service.usecases.machines import machines
from service.usecases.sessions import log_import, sessions, stops
from service.usecases.stock import catalogues
from tests.support.http.workshop import Workshop, box_body, machine_body, work_over
from tests.support.storage.engines import ENGINES, Engine, engine_named


@pytest.fixture
def other(engine: Engine, tmp_path: Path) -> Iterator[AppContext]:
    """A service elsewhere, over an empty database of the other engine."""
    (folder := tmp_path / "other").mkdir()
    elsewhere = engine_named(next(name for name in ENGINES if name != engine.name))
    url = elsewhere.migrated(folder)
    with closing(Database(url)) as database:
        yield work_over(database)
    elsewhere.drop(url)


def lived_in(shop: Workshop) -> list[str]:
    """A closed session with everything in it, an open one with a plan fitted, and one with pieces held."""
    machine, box = shop.machine(), shop.box()
    closed, fitted, held = (shop.session(machine, box, technician="A", note="x") for _ in range(3))
    stops.begin(shop.work, closed, StopRequest(purpose="trial", plane="1"))
    shop.fit(shop.planned(closed))
    shop.run(closed, "check", [])
    shop.ask("PATCH", f"/sessions/{closed}", {"state": "closed"})
    shop.fit(shop.planned(fitted))
    shop.post(f"/plans/{shop.planned(held)['id']}/reserve", {})
    return [closed, fitted, held]


def texts(work: AppContext, keys: list[str]) -> list[str]:
    return [write_json(sessions.log(work, key)) for key in keys]


def put(work: AppContext, logs: list[str]) -> log_import.Imported:
    return log_import.import_all(work, map(log_import.read_whole_log, logs))


def test_there_and_back_they_are_what_they_were(
    shop: Workshop, other: AppContext, engine: Engine, tmp_path: Path
) -> None:
    keys = lived_in(shop)
    said = texts(shop.work, keys)
    assert put(other, said) == log_import.Imported(stored=3, known=0)
    verdict = audit.verify(other)
    assert (verdict.findings, verdict.sessions) == ((), 1)
    for key in keys[:2]:
        assert sessions.get(other, key) == sessions.get(shop.work, key)
    there = texts(other, keys)
    assert there[:2] == said[:2]
    assert there[2] != said[2], "nothing is held there"
    assert put(other, said) == log_import.Imported(stored=0, known=3), "imported twice"
    assert put(shop.work, there) == log_import.Imported(stored=0, known=3), "sent home"
    (folder := tmp_path / "third").mkdir()
    url = engine.migrated(folder)
    with closing(Database(url)) as database:
        third = work_over(database)
        assert put(third, there) == log_import.Imported(stored=3, known=0)
        assert texts(third, keys) == there
        assert audit.verify(third).findings == ()
    engine.drop(url)


def test_the_history_tells_of_an_import_and_no_stock_moves(shop: Workshop, other: AppContext) -> None:
    keys = lived_in(shop)
    put(other, texts(shop.work, keys))
    entries = audit.of_session(other, keys[0], 10, 0)
    assert [entry.action for entry in entries] == ["closed", "imported"]
    assert entries[1].changes["state"] == "closed"
    box = catalogues.stock_of(other, sessions.get(other, keys[1]).catalogue_id or "", 10, 0)
    assert (box.movements, box.holds, {item.on_hand for item in box.items}) == ((), (), {0})


def test_an_imported_session_altered_behind_the_service_is_seen(shop: Workshop, other: AppContext) -> None:
    keys = lived_in(shop)
    put(other, texts(shop.work, keys[:1]))
    with other.database.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE session SET note = 'another'")
    assert [finding.code for finding in audit.verify(other).findings] == ["session_altered"]


def test_machine_and_box_are_found_by_name(shop: Workshop, other: AppContext) -> None:
    keys = lived_in(shop)
    names = iter(("its-machine", "its-box"))
    there = replace(other, new_id=lambda: next(names))
    machine = {**machine_body(), "name": shop.get("/machines")[0]["name"]}
    box = {**box_body(), "name": shop.get("/catalogues")[0]["name"]}
    machines.create(there, adapter(Machine).validate_python(machine, strict=False))
    catalogues.create(there, adapter(Catalogue).validate_python(box, strict=False))
    put(there, texts(shop.work, keys))
    view = sessions.get(there, keys[0])
    assert (view.machine_id, view.catalogue_id) == ("its-machine", "its-box")
    assert view.plans[0].inputs.catalogue_id == "its-box"
    assert {item.on_hand for item in catalogues.get(there, "its-box").items} == {10}
    assert put(there, texts(shop.work, keys)).known == 3
    assert audit.verify(there).findings == ()


def test_what_is_closed_stays_closed_and_what_is_open_goes_on(shop: Workshop, other: AppContext) -> None:
    closed, fitted, _held = keys = lived_in(shop)
    put(other, texts(shop.work, keys))
    with pytest.raises(Conflict, match="is closed"):
        sessions.change(other, closed, SessionPatch(note="rewritten"))
    version = sessions.get(other, fitted).version
    assert sessions.change(other, fitted, SessionPatch(note="goes on")).version == version + 1
    with pytest.raises(Conflict, match="another state of it"):
        put(other, texts(shop.work, keys))
    assert audit.verify(other).findings == ()


def test_of_a_file_with_one_bad_session_nothing_is_stored(shop: Workshop, other: AppContext) -> None:
    keys = lived_in(shop)
    first, second = texts(shop.work, keys[:2])
    with pytest.raises(Conflict, match="has an identifier under which something else is stored"):
        put(other, [first, second, second.replace(keys[1], "twin")])
    with other.read() as store:
        assert (store.sessions(10, 0), store.machines(10, 0), store.history(10, 0)) == ([], [], [])
    assert put(other, [first, second]).stored == 2


def test_over_http_the_same_log_changes_nothing_and_another_is_refused(shop: Workshop) -> None:
    keys = lived_in(shop)
    log: Any = None
    for key in keys:
        log = shop.get(f"/sessions/{key}/log")
        before = shop.rows()
        assert shop.post("/sessions/import", log) == shop.get(f"/sessions/{key}")
        assert shop.rows() == before
    log["record"]["note"] = "another story"
    problem = shop.refused("POST", "/sessions/import", log, 409, "session_differs")
    assert problem["value"] == keys[-1]
    shop.refused("POST", "/sessions/import", renamed(log), 409, "identifier_taken")
    log["catalogue"]["items"][0]["mass_g"] += 1.0
    shop.refused("POST", "/sessions/import", renamed(log), 409, "box_differs")


def renamed(log: dict[str, Any]) -> dict[str, Any]:
    """The log under another identifier of the session."""
    plans = [{**plan, "session_id": "another"} for plan in log["plans"]]
    return {**log, "session_id": "another", "plans": plans}


Spoil = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def good(shared_shop: Workshop) -> tuple[Workshop, Any]:
    """A closed session's log, to be spoilt."""
    return shared_shop, shared_shop.get(f"/sessions/{lived_in(shared_shop)[0]}/log")


@pytest.mark.parametrize(
    ("spoil", "field"),
    [
        (lambda log: log.pop("record"), "record"),
        (lambda log: log.update(session_id="a b"), "session_id"),
        (lambda log: log.update(session_id=None), "session_id"),
        (lambda log: log["record"].update(machine_id="x" * 33), "record.machine_id"),
        (lambda log: log["record"].update(closed_at=None), "record.closed_at"),
        (lambda log: log["record"].update(created_at="0001-01-01T00:00:00+23:00"), "record.created_at"),
        (lambda log: log["record"].update(fitted_plan_id="none"), "record.fitted_plan_id"),
        (lambda log: log["record"].update(catalogue_id=None), "catalogue"),
        (lambda log: log["record"]["stops"][0].update(number=2), "record.stops"),
        (lambda log: log["runs"][1].update(number=7), "runs"),
        (lambda log: log["runs"][1].update(id=log["runs"][0]["id"]), "runs"),
        (lambda log: log["runs"][0].update(taken_at="2026-01-01T00:00:00"), "runs[0].taken_at"),
        (lambda log: log["runs"][1]["masses"][0].update(plane="9"), "runs[1].masses[0].plane"),
        (lambda log: log["corrections"][0]["corrections"][0].update(plane="9"), "corrections[0].corrections"),
        (lambda log: log["plans"][0].update(session_id="x"), "plans[0].session_id"),
        (lambda log: log["plans"][0].update(correction_id="x"), "plans[0].correction_id"),
        (lambda log: log["plans"][0]["inputs"].update(catalogue_id="x"), "plans[0].inputs.catalogue_id"),
        (lambda log: log["plans"][0]["placements"][0].update(plane="9"), "plans[0].placements"),
    ],
)
def test_a_log_that_does_not_fit_together_is_refused(good: tuple[Workshop, Any], spoil: Spoil, field: str) -> None:
    shop, log = good
    spoilt = copy.deepcopy(log)
    spoil(spoilt)
    before = shop.count("audit")
    answer = shop.client.post("/api/v1/sessions/import", json=spoilt)
    assert answer.status_code == 422, answer.text
    assert answer.json()["field"].removeprefix("body.") == field or field in answer.text
    assert shop.count("audit") == before
