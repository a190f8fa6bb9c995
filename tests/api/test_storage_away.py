"""A database that does not answer is told as such, and asked again it answers."""

from __future__ import annotations

import os
import re
import shutil
import socket
import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path

import httpx2
import pytest
from sqlalchemy import text

from db import database
from db.database import Database
from service.errors import Unavailable
from service.runtime.context import AppContext
from tests.support.http.workshop import Workshop, box_body
from tests.support.storage.frozen import Link, linked


@pytest.mark.only("sqlite")
def test_a_lock_that_others_hold_too_long(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = shop.work.database
    monkeypatch.setattr(database, "BUSY_TIMEOUT_MS", 20)
    stored.engine.dispose()
    with closing(sqlite3.connect(str(stored.url.database), isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        problem = shop.refused("POST", "/catalogues", box_body("another"), 503, "unavailable")
        assert "locked" in problem["detail"]
        assert "ask again" in problem["advice"]
    assert shop.box()


@pytest.mark.only("postgresql")
def test_a_server_that_ends_the_connection_in_the_middle(shop: Workshop) -> None:
    with pytest.raises(Unavailable, match="does not answer now"), shop.work.write() as store:
        store._session.execute(text("SELECT pg_terminate_backend(pg_backend_pid())"))
    assert shop.box()


def test_a_server_that_is_gone() -> None:
    with closing(socket.create_server(("127.0.0.1", 0))) as free:
        port = free.getsockname()[1]
    with closing(Database(f"postgresql+psycopg://nobody@127.0.0.1:{port}/none")) as gone:
        work = AppContext(gone)
        with pytest.raises(Unavailable, match="does not answer now"), work.read() as store:
            store.ping()


@pytest.fixture
def far(shop: Workshop) -> Iterator[tuple[Link, Database]]:
    """The workshop's service over a link to its PostgreSQL that can be frozen; statements may take 0.2 s."""
    url = shop.work.database.url.render_as_string(hide_password=False)
    state = shop.client.app.state  # type: ignore[attr-defined]
    with linked(url) as link, closing(Database(link.url, patience_s=0.2)) as database:
        state.work = replace(shop.work, database=database)
        yield link, database


def away(answer: httpx2.Response) -> bool:
    """Whether it says that the database is away, and when to ask again."""
    body = answer.json()
    assert (answer.status_code, body["code"]) == (503, "unavailable"), body
    return int(answer.headers["retry-after"]) > 0


@pytest.mark.only("postgresql")
def test_a_server_that_hangs_is_away_in_time_and_back_at_once(shop: Workshop, far: tuple[Link, Database]) -> None:
    link, database = far
    box = shop.box()
    link.freeze()
    assert away(shop.client.get("/api/v1/machines"))
    assert away(shop.client.post("/api/v1/catalogues", json=box_body("another")))
    style = re.findall(r'href="(/static/[^"]*)"', shop.client.get("/login").text)[0]
    for page in ("/health/live", "/login", style, "/openapi.json"):
        assert shop.client.get(page).status_code == 200, page
    assert shop.client.get("/health").status_code == 503
    link.thaw()
    assert [one["id"] for one in shop.get("/catalogues")] == [box]
    assert shop.box()
    assert database.engine.pool.checkedout() == 0  # type: ignore[attr-defined]


@pytest.mark.only("postgresql")
def test_a_statement_that_hangs_ends_its_unit_of_work(shop: Workshop, far: tuple[Link, Database]) -> None:
    """The statement sleeps: to the client that is a server that says nothing."""
    work = AppContext(far[1])
    with pytest.raises(Unavailable, match=r"no answer within 0\.2 s") as hung, work.write() as store:
        store._session.execute(text("SELECT pg_sleep(30)"))
    assert hung.value.retry_after_s
    with work.write() as store:
        store.roll_up_alone()  # which may take its time
        store._session.execute(text("SELECT pg_sleep(0.4)"))
    with pytest.raises(Unavailable), work.read() as store:
        store._session.execute(text("SELECT pg_sleep(30)"))
    assert shop.box()


@pytest.mark.only("postgresql")
def test_a_pool_whose_connections_are_all_in_use_is_away(
    shop: Workshop, far: tuple[Link, Database], monkeypatch: pytest.MonkeyPatch
) -> None:
    pool = far[1].engine.pool
    monkeypatch.setattr(pool, "_timeout", 0.05)
    monkeypatch.setattr(pool, "_max_overflow", 0)
    with ExitStack() as held:
        for _ in range(5):
            held.enter_context(AppContext(far[1]).read()).ping()
        assert away(shop.client.get("/api/v1/machines"))
    assert shop.box()


@pytest.mark.only("postgresql")
def test_a_server_that_takes_no_changes(shop: Workshop) -> None:
    box = shop.box()
    name = shop.work.database.url.database
    with shop.work.database.engine.begin() as connection:
        connection.execute(text(f'ALTER DATABASE "{name}" SET default_transaction_read_only = on'))
    shop.work.database.engine.dispose()
    problem = shop.refused("POST", "/catalogues", box_body("another"), 503, "storage_read_only")
    assert "stand-by" in problem["advice"]
    assert [one["id"] for one in shop.get("/catalogues")] == [box]
    with shop.work.database.engine.begin() as connection:
        connection.execute(text("SET TRANSACTION READ WRITE"))
        connection.execute(text(f'ALTER DATABASE "{name}" RESET default_transaction_read_only'))
    shop.work.database.engine.dispose()
    assert shop.box()


@pytest.mark.only("sqlite")
def test_a_file_that_may_only_be_read(shop: Workshop) -> None:
    box = shop.box()
    with shop.work.database.engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA query_only=ON")
    problem = shop.refused("POST", "/catalogues", box_body("another"), 503, "storage_read_only")
    assert "can only be read" in problem["detail"]
    assert [one["id"] for one in shop.get("/catalogues")] == [box]


@pytest.mark.only("sqlite")
@pytest.mark.parametrize("put_in_place", [False, True], ids=["deleted", "replaced"])
def test_a_file_that_is_gone_takes_nothing_more(shop: Workshop, tmp_path: Path, put_in_place: bool) -> None:
    """What were written would be in a file without a name, and gone with the process."""
    box, path = shop.box(), Path(str(shop.work.database.url.database))
    os.rename(path, tmp_path / "elsewhere")
    if put_in_place:
        shutil.copy(tmp_path / "elsewhere", path)
    problem = shop.refused("POST", "/catalogues", box_body("another"), 503, "storage_gone")
    assert str(path) in problem["detail"]
    assert shop.client.get(f"/api/v1/catalogues/{box}").status_code == 503
    assert put_in_place or not path.exists()
    os.replace(tmp_path / "elsewhere", path)
    assert shop.box()
