"""The same requests with few and with many sessions stored: what a session costs must not grow with the others.

The database is filled with copies of one session that the service itself stored, with its runs, correction and plans,
what it taught its machine and its history; the copies are closed, a second apart, and spread over a hundred machines.
They are made by the engine itself, in chunks that are committed, so neither memory nor log grows with their number.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from functools import partial

from rich.console import Console
from sqlalchemy import Connection as SqlConnection
from sqlalchemy import text

from db.database import Database
from db.rows import Base
from service.bench.load.clients import Connection, bodies
from service.bench.load.shop import PLAN, runs
from service.bench.served import served
from service.bench.timing import show, timed

FEW = 1_000
MAX_GROWTH = 1.5
"""A median may be longer by this factor: the noise of a busy machine, far from the growth of a scan."""
BATCHES = 8
REPEATS = 10
"""Requests in a batch; of each path the quietest batch's median counts; batches are spread over the time."""
MACHINES = 100
CHUNK = 2_000
"""Sessions that are copied and committed at once."""
PLANS = 2
"""Plans that each copy has."""
LOOKS = (
    "/sessions",
    "/sessions?machine_id=copy-0",
    "/sessions?state=closed",
    "/sessions?state=open",
    "/history",
    "/history?kind=plan",
    "/influence-statistics?type=drum",
    "/metrics",
)
"""What is asked for whatever the session."""
_EARLIER = {
    "sqlite": "strftime('%Y-%m-%d %H:%M:%f000', {}, '-' || i || ' seconds')",
    "postgresql": "{} - i * interval '1 second'",
}
_SIZE = {
    "sqlite": "SELECT page_count * page_size FROM pragma_page_count(), pragma_page_size()",
    "postgresql": "SELECT pg_database_size(current_database())",
}
_TEMPLATE = (
    "SELECT session.id FROM session JOIN plan ON plan.session_id = session.id "
    "WHERE session.id NOT LIKE 'copy-%' ORDER BY session.created_at LIMIT 1"
)
"""The first session of all, at every size: later ones are those that the paths were measured on."""
_COPY = "'copy-' || CAST(i AS TEXT)"
_ON_MACHINE = f"'copy-' || CAST(i % {MACHINES} AS TEXT)"
_LEARNED = {"id": _COPY, "session_id": _COPY, "machine_id": _ON_MACHINE}
_TOLD = {"session_id": _COPY, "number": "CAST(NULL AS BIGINT)", "hash": "NULL"}
"""Out of the chain: `verify` is to find the service's own entries unbroken."""
_PART = {"id": "CAST(i AS TEXT) || '-' || CAST(number AS TEXT)", "session_id": _COPY}


def flat_cost(url: str, engine: str, sessions: int, *, markdown: bool) -> bool:
    """Fill the database to 1,000 and to `sessions` sessions, print the medians of the hot paths at both.

    The database holds the session of the load measurement already. True where no path grew.
    """
    counts = (min(FEW, sessions // 2), sessions)
    medians = []
    for stored, count in zip((0, counts[0]), counts, strict=True):
        _fill(url, engine, stored, count)
        with served(url) as service:
            medians.append(_hot_paths(service))
    few, many = medians
    ratios = {path: many[path] / few[path] for path in few}
    lines = [
        (path, *(f"{1e3 * m[path]:.1f} ms" for m in medians), f"{ratio:.2f}", _verdict(ratio))
        for path, ratio in ratios.items()
    ]
    header = (
        "path, median",
        *(f"{count:,} sessions" for count in counts),
        "ratio",
        f"at most {MAX_GROWTH:g}, for noise",
    )
    show(Console(), f"bench load: {engine}", header, lines, markdown=markdown)
    return all(ratio <= MAX_GROWTH for ratio in ratios.values())


def _verdict(ratio: float) -> str:
    return "flat" if ratio <= MAX_GROWTH else "GROWS"


def _hot_paths(service: str) -> dict[str, float]:
    """Median of each request, s; on a machine that a hundredth of all sessions were on."""
    connection = Connection(service)
    (old,) = json.loads(connection.ask("GET", "/sessions?machine_id=copy-0&limit=1"))
    body = {name: old[name] for name in ("machine_id", "catalogue_id")}
    session = connection.post("/sessions", body)["id"]
    other = connection.post("/sessions", body)["id"]  # a run makes its session's correction stale
    path = f"/sessions/{session}"
    for run in runs():
        connection.post(f"{path}/runs", run)
    correction = connection.post(f"{path}/corrections", {"source": "fit"})["id"]
    # A source of this round's own: its numbers were not sent before.
    connection.ask("PUT", f"/sources/{session}", json.dumps({"machine_id": old["machine_id"]}).encode())
    single = iter(bodies(session, 2 * BATCHES * REPEATS, 1))
    paths: dict[str, Callable[[], object]] = {
        "POST sessions": lambda: connection.post("/sessions", body),
        "GET session": lambda: connection.ask("GET", f"/sessions/{old['id']}"),
        "GET session/now": lambda: connection.ask("GET", f"{path}/now"),
        "POST plan": lambda: connection.post(f"{path}/plans", {"correction_id": correction, **PLAN}),
        "POST one reading": lambda: connection.ask("POST", "/readings", next(single)),
        **{f"GET {look}": partial(connection.ask, "GET", look) for look in LOOKS},
        "GET session/history": lambda: connection.ask("GET", f"/sessions/{old['id']}/history"),
        "GET page of a session": lambda: connection.ask("GET", f"/sessions/{old['id']}", prefix=""),
        "GET page of a machine": lambda: connection.ask("GET", "/machines/copy-0", prefix=""),
        "GET page of all sessions": lambda: connection.ask("GET", "/sessions?state=closed", prefix=""),
        "POST run": lambda: connection.post(f"/sessions/{other}/runs", runs()[0]),
    }
    batches = range(BATCHES)
    try:
        rounds = [{name: timed(call, repeats=REPEATS, warm_up=1)[0] for name, call in paths.items()} for _ in batches]
        return {name: min(one[name] for one in rounds) for name in paths}
    finally:
        connection.close()


def _fill(url: str, engine: str, stored: int, count: int) -> None:
    """Copy sessions until there are this many, and say how long it took and how large the database is."""
    database = Database(url)
    began = time.perf_counter()
    try:
        with database.engine.begin() as connection:
            template = str(connection.execute(text(_TEMPLATE)).scalar_one())
            if not stored:
                name = "'copy ' || CAST(i AS TEXT)"
                _copy(connection, "machine", {"id": _COPY, "name": name}, "id", _machine_of(connection), 0, MACHINES)
        for first in range(stored, count, CHUNK):
            with database.engine.begin() as connection:
                _copy_sessions(connection, engine, template, first, min(first + CHUNK, count))
        with database.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.exec_driver_sql("ANALYZE")  # as PostgreSQL does by itself, in its own time
            if engine == "postgresql":  # SQLite does so where its last connection is closed
                connection.exec_driver_sql("CHECKPOINT")
            size = int(connection.execute(text(_SIZE[engine])).scalar_one())
    finally:
        database.close()
    os.sync()  # or every commit that is timed would wait for what was filled in
    took = time.perf_counter() - began
    rate = (count - stored) / took
    print(f"{engine}: {count:,} sessions, {took:.0f} s at {rate:,.0f} sessions/s, {size / 1e6:,.0f} MB", flush=True)


def _copy_sessions(connection: SqlConnection, engine: str, template: str, first: int, last: int) -> None:
    opened, learned = (_EARLIER[engine].format(column) for column in ("created_at", "learned_at"))
    closed = {"id": _COPY, "machine_id": _ON_MACHINE, "state": "'closed'", "created_at": opened}
    _copy(connection, "session", closed, "id", template, first, last)
    for part in ("run", "correction", "plan"):
        _copy(connection, part, _PART, "session_id", template, first, last)
    _copy(connection, "influence", _LEARNED | {"learned_at": learned}, "session_id", template, first, last)
    _copy(connection, "audit", _TOLD, "session_id", template, first, last)


def _machine_of(connection: SqlConnection) -> str:
    return str(connection.execute(text("SELECT id FROM machine LIMIT 1")).scalar_one())


def _copy(
    connection: SqlConnection, table: str, changes: dict[str, str], key: str, value: str, first: int, last: int
) -> None:
    """Rows of a table whose key has this value, copied once for each number; of its plans the first few."""
    names = [c.name for c in Base.metadata.tables[table].columns if (table, c.name) != ("audit", "id")]
    chosen = ", ".join(changes.get(name, name) for name in names)
    few = "" if table != "plan" else f" AND number <= {PLANS}"
    connection.execute(
        text(
            f"INSERT INTO {table} ({', '.join(names)}) "  # noqa: S608 - names of our own tables
            f"WITH RECURSIVE n(i) AS (SELECT {first} UNION ALL SELECT i + 1 FROM n WHERE i + 1 < {last}) "
            f"SELECT {chosen} FROM {table}, n WHERE {table}.{key} = :value{few}"
        ),
        {"value": value},
    )
