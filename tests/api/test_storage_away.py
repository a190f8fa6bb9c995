"""A database that does not answer is told as such, and asked again it answers."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import pytest
from sqlalchemy import text

from db import database
from tests.api.workshop import Workshop, box_body


def test_a_lock_that_others_hold_too_long(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = shop.work.database
    if not stored.embedded:
        pytest.skip("PostgreSQL has no lock on all of a database")
    monkeypatch.setattr(database, "BUSY_TIMEOUT_MS", 20)
    stored.engine.dispose()
    with closing(sqlite3.connect(str(stored.url.database), isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        problem = shop.refused("POST", "/catalogues", box_body("another"), 503, "unavailable")
        assert "locked" in problem["detail"]
        assert "ask again" in problem["advice"]
    assert shop.box()


def test_a_server_that_ends_the_connection_in_the_middle(shop: Workshop) -> None:
    stored = shop.work.database
    if stored.embedded:
        pytest.skip("SQLite has no server")
    with pytest.raises(Exception, match="does not answer now"), shop.work.write() as store:
        store._session.execute(text("SELECT pg_terminate_backend(pg_backend_pid())"))
    assert shop.box()
