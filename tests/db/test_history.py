"""The history: written with every change or not at all, chained, and closed sessions stay as they were closed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from sqlalchemy import func, select
from sqlalchemy.exc import OperationalError

from db.audit_chain import canonical, digest
from db.history import ClosedForGood
from db.rows import ReadingRow, RunRow, SessionRow
from db.store import Store
from drivers.reading import Reading
from service.errors import Unavailable
from service.model.session import SessionPatch
from service.runtime.context import AppContext, require
from service.usecases import audit
from service.usecases.access import tokens
from service.usecases.readings import ingest
from service.usecases.readings.clocks import Arrival
from service.usecases.sessions import sessions
from tests.support.http.workshop import Workshop

Tamper = Callable[[Workshop, list[str]], list[str]]


def closed(shop: Workshop) -> str:
    """A session that was balanced and closed."""
    session = shop.session(technician="A. Technician")
    shop.fit(shop.planned(session))
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    return session


def sql(shop: Workshop, *statements: str) -> None:
    """What somebody with the password of the database does."""
    with shop.work.database.engine.begin() as connection:
        if shop.work.database.embedded:
            connection.exec_driver_sql("PRAGMA defer_foreign_keys = ON")
        for statement in statements:
            connection.exec_driver_sql(statement)


def found(shop: Workshop, head: str | None = None) -> list[tuple[str, str | None]]:
    """Code and session of every finding."""
    return [(finding.code, finding.session_id) for finding in audit.verify(shop.work, head).findings]


def test_canonical_json_and_its_digest_are_frozen() -> None:
    assert canonical({"b": [1.0, 0.1, None, True], "a": "µ"}) == '{"a":"µ","b":[1.0,0.1,null,true]}'
    assert digest({"a": 1}) == "015abd7f5cc57a2dd94b7590f04ad8084273905ee33ec5cebeae62276a97f862"
    with pytest.raises(ValueError, match="JSON"):
        canonical(float("nan"))


def test_who_when_what(shop: Workshop) -> None:
    session = shop.session(technician="A")
    sessions.change(shop.work.acting("tablet 1"), session, SessionPatch(technician="B"))
    newest, opened = shop.get(f"/sessions/{session}/history")
    assert (newest["actor"], newest["action"], newest["kind"]) == ("tablet 1", "changed", "session")
    assert newest["changes"] == {"technician": ["A", "B"]}
    assert (opened["actor"], opened["action"]) == ("local", "added")
    assert opened["at"] < newest["at"]
    assert [entry["id"] for entry in shop.get("/history?actor=tablet%201")] == [newest["id"]]


def test_fields_of_a_document_are_told_one_by_one(shop: Workshop) -> None:
    plan = shop.planned(shop.session())
    shop.post(f"/plans/{plan['id']}/reserve", {})
    shop.ask("POST", f"/plans/{plan['id']}/release")
    last = shop.get(f"/history?kind=plan&key={plan['id']}")[0]
    assert list(last["changes"]) == ["plan.reserved_until"]
    assert last["changes"]["plan.reserved_until"][1] is None


def test_what_is_undone_leaves_no_trace(shop: Workshop) -> None:
    session = shop.session()
    before = shop.count("audit")

    def change_and_fail() -> None:
        with shop.work.write() as store:
            noted(store, session)
            store.flush()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        change_and_fail()
    assert shop.count("audit") == before


def test_a_secret_is_not_told(shop: Workshop) -> None:
    tokens.create(shop.work, "tablet", ["read"])
    with shop.work.read() as store:
        changes = store.history(1, 0, kind="token")[0].changes
    assert "name" in changes
    assert "digest" not in changes


def noted(store: Store, session: str) -> None:
    require(store, SessionRow, session).note = "later"


def run_excluded(store: Store, session: str) -> None:
    row = store.runs(session)[0]
    row.run = replace(row.run, excluded=True)


def run_added(store: Store, session: str) -> None:
    run = store.runs(session)[0].run
    store.add(RunRow(id="late", session_id=session, number=99, run=run))


@pytest.mark.parametrize("change", [noted, run_excluded, run_added])
def test_a_closed_session_cannot_be_changed_by_any_use_case(
    shop: Workshop, change: Callable[[Store, str], None]
) -> None:
    session = closed(shop)
    with pytest.raises(ClosedForGood), shop.work.write() as store:
        change(store, session)
    assert found(shop) == []


def test_what_is_stored_is_as_the_history_says(shop: Workshop) -> None:
    keys = [closed(shop) for _ in range(2)]
    shop.session()
    verdict = audit.verify(shop.work)
    assert verdict.findings == ()
    assert (verdict.sessions, verdict.entries) == (len(keys), shop.count("audit"))
    shop.session()
    assert found(shop, verdict.head) == [], "what was the end is still on the chain"


def altered_run(shop: Workshop, keys: list[str]) -> list[str]:
    changed = "run = replace(run, '\"excluded\":false', '\"excluded\":true')"
    sql(shop, f"UPDATE run SET {changed} WHERE number = 1 AND session_id = '{keys[1]}'")
    return ["session_altered"]


def altered_session(shop: Workshop, keys: list[str]) -> list[str]:
    sql(shop, f"UPDATE session SET technician = 'Somebody else' WHERE id = '{keys[1]}'")
    return ["session_altered"]


def reopened(shop: Workshop, keys: list[str]) -> list[str]:
    sql(shop, f"UPDATE session SET state = 'checked' WHERE id = '{keys[1]}'")
    return ["session_altered"]


def run_removed(shop: Workshop, keys: list[str]) -> list[str]:
    sql(shop, f"DELETE FROM run WHERE number = 1 AND session_id = '{keys[1]}'")
    return ["session_altered"]


def session_removed(shop: Workshop, keys: list[str]) -> list[str]:
    tables = ("stock_entry", "plan", "correction", "run")
    sql(shop, *(f"DELETE FROM {t} WHERE session_id = '{keys[1]}'" for t in tables))
    sql(shop, f"DELETE FROM session WHERE id = '{keys[1]}'")
    return ["session_missing"]


def session_inserted(shop: Workshop, keys: list[str]) -> list[str]:
    columns = "machine_id, machine_name, machine, state, run_out, on_rotor, created_at, closed_at"
    sql(shop, f"INSERT INTO session (id, {columns}) SELECT 'forged', {columns} FROM session WHERE id = '{keys[1]}'")
    return ["session_inserted"]


def entry_altered(shop: Workshop, keys: list[str]) -> list[str]:
    sql(shop, f"UPDATE audit SET actor = 'nobody' WHERE action = 'closed' AND session_id = '{keys[1]}'")
    return ["entry_altered"]


def entry_removed(shop: Workshop, keys: list[str]) -> list[str]:
    sql(shop, f"DELETE FROM audit WHERE action = 'fitted' AND session_id = '{keys[1]}'")
    return ["entry_missing"]


def entries_reordered(shop: Workshop, keys: list[str]) -> list[str]:
    sql(
        shop,
        "UPDATE audit SET number = -1 WHERE number = 2",
        "UPDATE audit SET number = 2 WHERE number = 3",
        "UPDATE audit SET number = 3 WHERE number = -1",
    )
    return ["entry_altered"] * 3


@pytest.mark.parametrize(
    "tamper",
    [
        altered_run,
        altered_session,
        reopened,
        run_removed,
        session_removed,
        session_inserted,
        entry_altered,
        entry_removed,
        entries_reordered,
    ],
)
def test_what_is_altered_behind_the_service_is_found(shop: Workshop, tamper: Tamper) -> None:
    keys = [closed(shop) for _ in range(3)]
    expected = tamper(shop, keys)
    said = found(shop)
    # A ledger whose movements were removed with a session no longer comes to its balance either.
    assert [code for code, _ in said if code != "balance"] == expected
    named = {session for code, session in said if code.startswith("session_")}
    assert named <= {keys[1], "forged"}


def test_an_end_that_was_cut_off_is_found_by_the_head_kept_elsewhere(shop: Workshop) -> None:
    shop.session()
    head = audit.verify(shop.work).head
    sql(shop, "DELETE FROM audit WHERE number = (SELECT max(number) FROM audit)")
    sql(shop, "DELETE FROM session")
    assert found(shop) == []
    assert found(shop, head) == [("head_missing", None)]


def test_a_balance_that_is_not_the_sum_of_its_movements_is_found(shop: Workshop) -> None:
    box = shop.box(count=3, masses=(10.0,))
    sql(shop, f"UPDATE stock_balance SET on_hand = 2 WHERE catalogue_id = '{box}'")
    findings: tuple[Any, ...] = audit.verify(shop.work).findings
    assert [finding.code for finding in findings] == ["balance"]
    assert "2 of 10 g" in findings[0].detail


def test_requests_that_share_a_unit_are_each_told_under_their_own_name(shop: Workshop) -> None:
    """What small batches of readings do; one of them is refused half-way."""
    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    moment = shop.now()

    def batch(actor: str, first: int, sensor: str = "P") -> tuple[AppContext, list[Reading], Arrival]:
        sent = [Reading("bridge", first + n, moment, "P" if n == 0 else sensor, 1.0) for n in range(2)]
        return shop.work.acting(actor), sent, Arrival(moment)

    ingest.ingest(shop.work.acting("bridge 1"), batch("bridge 1", 0)[1])
    shared = [batch("bridge 1", 10), batch("bridge 2", 20), batch("bridge 3", 30, "none"), batch("bridge 4", 0)]
    ended = ingest._store_few(shared)
    assert [type(one).__name__ for one in ended] == ["Receipt", "Receipt", "InvalidInput", "Receipt"]
    told = [(entry["actor"], entry["changes"]["new"]) for entry in shop.get("/history?kind=reading")]
    assert told == [("bridge 2", 2), ("bridge 1", 2), ("bridge 1", 2)], "what was stored before is no change"


def test_an_engine_that_falls_silent_half_way_is_named_to_every_request(
    shop: Workshop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two batches share a unit, and the engine gives no answer to the second: neither is stored."""
    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    moment = shop.now()
    stored = ingest._Unit.stored

    def silent(unit: ingest._Unit, readings: list[Reading], arrived: Arrival) -> object:
        if readings[0].sequence == 20:
            raise OperationalError("insert", {}, Exception("no answer"), connection_invalidated=True)
        return stored(unit, readings, arrived)

    monkeypatch.setattr(ingest._Unit, "stored", silent)
    monkeypatch.setattr(ingest, "_store_new", lambda *_: False)
    shared = [(shop.work, [Reading("bridge", first, moment, "P", 1.0)], Arrival(moment)) for first in (10, 20)]
    with pytest.raises(Unavailable) as told:
        ingest._store_few(shared)
    assert told.value.retry_after_s
    with shop.work.database.engine.begin() as connection:
        assert connection.scalar(select(func.count()).select_from(ReadingRow)) == 0
