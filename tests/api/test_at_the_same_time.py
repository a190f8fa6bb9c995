"""Requests at the same time: one answer is one moment, no change is lost, a name used twice is refused, never 500."""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from typing import Any

import pytest
from sqlalchemy import text
from sqlalchemy.exc import OperationalError

from db.rows import CatalogueRow, MachineRow, SessionRow, SourceRow, TokenRow
from db.store import Store
from service.errors import Conflict, Unavailable
from service.model.base import read_json
from service.model.machine import Catalogue, Machine
from service.model.run import RunPatch
from service.runtime.context import again_after_deadlock
from service.usecases import audit
from service.usecases.access import tokens
from service.usecases.machines import machines
from service.usecases.readings import sources
from service.usecases.sessions import log_import, runs, sessions
from service.usecases.stock import catalogues
from tests.support.http.workshop import Workshop, box_body, machine_body


def while_another(shop: Workshop, begun: Callable[[Store], object], then: Callable[[], Any]) -> Any:
    """What `then` gives that starts while another unit of work, `begun`, is about to commit."""
    with ThreadPoolExecutor(1) as pool:
        with ExitStack() as other:
            begun(other.enter_context(shop.work.write()))
            answer = pool.submit(then)
            until_it_waits(shop, answer)
        return answer.result()


def until_it_waits(shop: Workshop, answer: Future[Any]) -> None:
    """Until PostgreSQL says that somebody waits for a lock; SQLite's writers queue in the process."""
    if shop.work.database.embedded:
        return
    waiting = text("SELECT count(*) FROM pg_locks WHERE NOT granted")
    with shop.work.database.engine.connect() as connection:
        while not answer.done() and not connection.execute(waiting).scalar_one():
            connection.rollback()


def test_all_looks_of_a_unit_see_one_moment(shop: Workshop) -> None:
    session = shop.session()
    run = shop.run(session, "initial")
    with shop.work.read() as store:
        before = store.get(SessionRow, session)
        runs.change(shop.work, session, run["id"], RunPatch(excluded=True, reason="meanwhile"))
        assert [row.run.excluded for row in store.runs(session)] == [False]
        assert before is not None
        assert before.version == run["number"] + 1


def test_several_looks_of_one_answer_see_one_moment(shop: Workshop) -> None:
    session = shop.session()
    run = shop.run(session, "initial")
    with shop.work.one_moment() as one:
        version = sessions.get(one, session).version
        runs.change(shop.work, session, run["id"], RunPatch(excluded=True, reason="meanwhile"))
        again = sessions.get(one, session)
    assert (again.version, again.runs[0].excluded) == (version, False)
    assert sessions.get(shop.work, session).runs[0].excluded


def test_the_name_of_a_machine_is_given_once(shop: Workshop) -> None:
    machine = read_json(Machine, json.dumps(machine_body("one")))

    def begun(store: Store) -> None:
        now = shop.now()
        store.add(MachineRow(id="other", name="one", spec=machine, created_at=now, updated_at=now))

    with pytest.raises(Conflict) as refused:
        while_another(shop, begun, lambda: machines.create(shop.work, machine))
    assert refused.value.code == "name_taken"
    two = shop.machine()

    def renamed(store: Store) -> None:
        row = store.get(MachineRow, "other")
        assert row is not None
        row.name = "two"
        store.flush()

    with pytest.raises(Conflict) as refused:
        while_another(shop, renamed, lambda: machines.change(shop.work, two, {"name": "two"}))
    assert refused.value.code == "name_taken"


def test_the_names_of_boxes_and_tokens_are_given_once(shop: Workshop) -> None:
    box = read_json(Catalogue, json.dumps(box_body("one")))

    def begun(store: Store) -> None:
        store.add(CatalogueRow(id="other", name="one", items=box.items, created_at=shop.now()))

    with pytest.raises(Conflict) as refused:
        while_another(shop, begun, lambda: catalogues.create(shop.work, box))
    assert refused.value.code == "name_taken"

    def made(store: Store) -> None:
        row = TokenRow(id="t", name="tablet", scopes=("read",), digest="d", created_at=shop.now())
        store.add(row)

    with pytest.raises(Conflict) as refused:
        while_another(shop, made, lambda: tokens.create(shop.work, "tablet", ["read"]))
    assert refused.value.code == "name_taken"


def test_a_source_that_is_bound_twice_at_once_is_bound_as_the_later_says(shop: Workshop) -> None:
    first, second = shop.machine(), shop.machine()

    def new(store: Store) -> None:
        store.add(SourceRow(name="bridge", machine_id=first, bound_at=shop.now()))

    def moved(store: Store) -> None:
        row = store.lock(SourceRow, "bridge")
        assert row is not None
        row.machine_id, row.bound_at = second, shop.now()
        store.flush()

    for begun, machine in ((new, second), (moved, first), (moved, second)):
        answer = while_another(shop, begun, partial(sources.bind, shop.work, "bridge", machine))
        assert answer.machine_id == machine
        assert sources.bound(shop.work) == (answer,)
    lines = shop.get("/history?kind=source")
    told = [line["changes"]["bound_at"] for line in lines[:-1]]
    assert [after for _, after in reversed(told)][:-1] == [before for before, _ in reversed(told)][1:]
    assert audit.verify(shop.work).findings == ()


def test_a_session_that_is_imported_twice_at_once_is_known(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    log = log_import.read_whole_log(json.dumps(shop.get(f"/sessions/{session}/log")))
    with shop.work.database.engine.begin() as connection:
        for table in ("run", "session", "stock_entry", "stock_balance", "catalogue", "machine", "audit"):
            connection.execute(text(f"DELETE FROM {table}"))
    done = while_another(
        shop,
        lambda store: log_import._import(store, log, shop.now()),
        lambda: log_import.import_all(shop.work, [log]),
    )
    assert (done.stored, done.known) == (0, 1)
    assert audit.verify(shop.work).findings == ()


class Deadlock(Exception):
    sqlstate = "40P01"


def test_a_deadlock_is_undone_told_as_busy_and_done_again(shop: Workshop) -> None:
    def fail() -> None:
        with shop.work.write():
            raise OperationalError("x", {}, Deadlock())

    with pytest.raises(Unavailable) as refused:
        fail()
    assert (refused.value.code, refused.value.status, refused.value.retry_after_s) == ("deadlock", 503, 1)
    tried: list[int] = []

    @again_after_deadlock
    def act(given: int) -> int:
        tried.append(given)
        if len(tried) < 3:
            fail()
        return given

    assert act(7) == 7
    assert tried == [7, 7, 7]


def test_a_version_is_refused_where_none_is_kept(shop: Workshop) -> None:
    machine, box = shop.machine(), shop.box()
    for method, path, body in (
        ("PATCH", f"/machines/{machine}", {"name": "other"}),
        ("PATCH", f"/catalogues/{box}", {"name": "other"}),
        ("POST", f"/catalogues/{box}/stock", {"kind": "received", "pieces": [{"mass_g": 10.0, "pieces": 1}]}),
        ("PUT", "/sources/bridge", {"machine_id": machine}),
        ("GET", f"/machines/{machine}", None),
    ):
        answer = shop.client.request(method, f"/api/v1{path}", json=body, headers={"if-match": '"77"'})
        assert (answer.status_code, answer.json()["code"]) == (412, "version_unknown"), path
        assert shop.client.request(method, f"/api/v1{path}", json=body, headers={"if-match": "*"}).is_success
