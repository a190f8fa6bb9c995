"""A database that does not answer is told as such, and asked again it answers."""

from __future__ import annotations

import socket
import sqlite3
from contextlib import closing

import pytest
from sqlalchemy import text

from db import database
from db.database import Database
from service.errors import Unavailable
from service.runtime.context import AppContext
from tests.support.http.workshop import Workshop, box_body


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
