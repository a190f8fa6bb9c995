"""No hot path reads a table from end to end, on either engine: every statement of a session is asked for its plan.

SQLite without statistics takes an index wherever one serves. PostgreSQL would rather read a small table whole, and is
told not to: what still does has no index to take.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from sqlalchemy import Connection, event

from service.app import PREFIX
from service.usecases.readings.retention import retain
from tests.api.readings.test_readings import answer, arrival, at
from tests.api.record_examples import block
from tests.support.http.workshop import Workshop

BOUNDED = frozenset({"source", "token", "login", "alembic_version"})
"""Tables as long as the site has bridges and people: reading them whole is no matter of sessions stored."""
NOON = at(0)


@contextmanager
def listened(shop: Workshop) -> Iterator[list[tuple[str, Any]]]:
    """The statements that are executed in a block, with their parameters, each once."""
    heard: dict[str, Any] = {}

    def hear(_c: Any, _cursor: Any, statement: str, parameters: Any, _context: Any, many: bool) -> None:
        if statement.lstrip().upper().startswith(("SELECT", "UPDATE", "DELETE")):
            heard.setdefault(statement, parameters[0] if many else parameters)

    engine = shop.work.database.engine
    event.listen(engine, "before_cursor_execute", hear)
    found: list[tuple[str, Any]] = []
    try:
        yield found
    finally:
        event.remove(engine, "before_cursor_execute", hear)
        found += heard.items()


def read_whole(connection: Connection, statement: str, parameters: Any) -> list[str]:
    """Tables that this statement reads from end to end."""
    if connection.dialect.name == "sqlite":
        lines = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)
        found = [str(line[3]).split() for line in lines]
        scanned = [words for words in found if words[0] == "SCAN"]
        # In the order of an index or of the rows, to the LIMIT: no further than the page that is asked for.
        paged = "LIMIT" in statement
        ordered = [words for words in scanned if paged and ("INDEX" in words or "WHERE" not in statement)]
        return [words[1] for words in scanned if words not in ordered and words[1] != "CONSTANT"]
    whole: list[str] = []
    for node in nodes_of(connection, statement, parameters):
        sequential = node["Node Type"] in ("Seq Scan", "Parallel Seq Scan")
        unpicked = "Index" in node["Node Type"] and "Index Cond" not in node and "LIMIT" not in statement
        if "Relation Name" in node and (sequential or (unpicked and node["Node Type"] != "Bitmap Heap Scan")):
            whole.append(node["Relation Name"])
    return whole


def nodes_of(connection: Connection, statement: str, parameters: Any) -> Iterator[dict[str, Any]]:
    """The nodes of PostgreSQL's plan."""
    (plan,) = connection.exec_driver_sql(f"EXPLAIN (FORMAT JSON) {statement}", parameters).one()
    nodes = [json.loads(plan)[0]["Plan"] if isinstance(plan, str) else plan[0]["Plan"]]
    while nodes:
        node = nodes.pop()
        nodes += node.get("Plans", [])
        yield node


def sorted_whole(connection: Connection, statement: str, parameters: Any) -> bool:
    """Whether all that a statement finds is read and sorted for the page that it answers; of readings since then."""
    if "LIMIT" not in statement or "taken_at >=" in statement:
        return False
    if connection.dialect.name == "sqlite":
        lines = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)
        return any(line[3] == "USE TEMP B-TREE FOR ORDER BY" for line in lines)
    return any(node["Node Type"] == "Sort" for node in nodes_of(connection, statement, parameters))


def the_whole_day(shop: Workshop) -> None:
    """Everything that is asked for while a drum is balanced."""
    machine, box = shop.machine(type="drum"), shop.box()
    shop.ask("PUT", "/sources/bridge", {"machine_id": machine})
    session = shop.session(machine, box)
    shop.post("/readings", arrival(1))
    shop.post("/readings", [arrival(n) for n in range(12)])
    shop.post("/balancer-answers", answer(20))
    shop.post("/blocks", block({"source": "bridge", "taken_at": at(20)}))
    shop.get(f"/sessions/{session}/now")
    shop.get(f"/sources/bridge/readings?from={NOON[:19]}Z")
    shop.post(
        f"/sessions/{session}/runs", {"kind": "initial", "take": {"source": "bridge", "from": NOON, "to": at(60)}}
    )
    plan = shop.planned(session)
    shop.post(f"/plans/{plan['id']}/reserve", {})
    shop.fit(plan)
    shop.post(f"/machines/{machine}/influence", {"session_id": session})
    for path in ("", "/log", "/report.json", "/trial-masses", "/history", "/balancer-answers"):
        shop.get(f"/sessions/{session}{path}")
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    shop.get(f"/plans/{plan['id']}")
    shop.get(f"/plans/{plan['id']}/front")
    shop.post(f"/plans/{plan['id']}/what-if", {"missing": [{"mass_g": 50.0}]})
    for path in (f"/sessions?machine_id={machine}", "/sessions", "/sessions?state=closed", "/machines", "/catalogues"):
        shop.get(path)
    for query in ("", "?kind=session", "?kind=reading&key=bridge", "?actor=local"):
        shop.get(f"/history{query}")
    assert shop.client.get(f"{PREFIX}/influence-statistics?type=drum").status_code == 404  # of one machine
    shop.get(f"/catalogues/{box}")
    shop.get(f"/machines/{machine}/influence")
    shop.get("/health")
    assert "drumtrue_source_lag_seconds{" in shop.client.get("/metrics").text
    shop.now.clock.advance(400 * 86_400.0)
    assert retain(shop.work, 30).readings > 0


def test_no_table_is_read_from_end_to_end_nor_sorted_for_a_page(shop: Workshop) -> None:
    with listened(shop) as statements:
        the_whole_day(shop)
    assert len(statements) > 20
    with shop.work.database.engine.connect() as connection:
        if not shop.work.database.embedded:
            connection.exec_driver_sql("SET enable_seqscan = off")
        whole = {
            (table, statement)
            for statement, parameters in statements
            for table in read_whole(connection, statement, parameters)
            if table not in BOUNDED
        }
        if not shop.work.database.embedded:
            connection.exec_driver_sql("SET enable_bitmapscan = off")
            connection.exec_driver_sql("SET enable_sort = off")
        paged = [statement for statement, parameters in statements if sorted_whole(connection, statement, parameters)]
    assert not whole, "\n\n".join(f"{table}: {statement}" for table, statement in whole)
    assert not paged, "\n\n".join(paged)


@pytest.mark.parametrize("statement", ["SELECT * FROM plan", "SELECT * FROM run WHERE run.run = 'x'"])
def test_a_scan_is_seen(shop: Workshop, statement: str) -> None:
    with shop.work.database.engine.connect() as connection:
        if not shop.work.database.embedded:
            connection.exec_driver_sql("SET enable_seqscan = off")
        assert read_whole(connection, statement, ()) == [statement.split()[3]]


def test_a_sort_is_seen(shop: Workshop) -> None:
    with shop.work.database.engine.connect() as connection:
        statement = "SELECT id FROM session WHERE state = 'closed' ORDER BY {} DESC LIMIT 9"
        if not shop.work.database.embedded:
            connection.exec_driver_sql("SET enable_bitmapscan = off")
            connection.exec_driver_sql("SET enable_sort = off")
        assert not sorted_whole(connection, statement.format("created_at"), ())
        assert sorted_whole(connection, statement.format("closed_at"), ())


def test_open_sessions_are_found_past_any_number_of_closed_ones(shop: Workshop) -> None:
    with listened(shop) as statements, shop.work.read() as store:
        assert store.open_sessions(shop.machine()) == []
    (statement, parameters) = next(one for one in statements if "<> 'closed'" in one[0])
    explain = "EXPLAIN QUERY PLAN" if shop.work.database.embedded else "EXPLAIN"
    with shop.work.database.engine.connect() as connection:
        if not shop.work.database.embedded:
            connection.exec_driver_sql("SET enable_seqscan = off")
        plan = str(connection.exec_driver_sql(f"{explain} {statement}", parameters).all())
    assert "ix_session_not_closed" in plan
