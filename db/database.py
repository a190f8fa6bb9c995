"""The engine and its units of work."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry

from db.history import History
from db.pubsub import Notices
from db.store import Store

BUSY_TIMEOUT_MS = 15_000
POOL_S = 2.0
"""How long a unit of work waits for one of the connections to PostgreSQL, where statements have a time-out."""
_DISK_FULL = "53100"
"""PostgreSQL's SQLSTATE."""
_TRY_AGAIN = ("40P01", "40001")
"""PostgreSQL's SQLSTATEs of a deadlock and of a failure to serialise."""
_READING = (sqlite3.SQLITE_IOERR_READ, sqlite3.SQLITE_IOERR_SHORT_READ)
_READ_ONLY = "25006"
"""PostgreSQL's SQLSTATE of a server that is a stand-by, or was set to take no changes."""


class FileGone(Exception):
    """SQLite's file was deleted, moved or replaced while it was open: what is written would be in no file."""


class Undone(Exception):
    """The engine refused a statement, the block caught the error and went on: all of the unit was undone with it.

    Catch around the unit of work, or around `Store.part()`, which is undone by itself.
    """


def lacks_room(error: BaseException) -> bool:
    """Whether the engine, or SQLAlchemy around it, says that the disk takes no more.

    SQLite calls a write that the system refuses, at a quota or a limit of a file's size, an input/output error.
    """
    said = getattr(error, "orig", None) or error
    code = getattr(said, "sqlite_errorcode", 0)
    if code & 0xFF == sqlite3.SQLITE_IOERR:
        return code not in _READING
    return code & 0xFF == sqlite3.SQLITE_FULL or getattr(said, "sqlstate", None) == _DISK_FULL


def is_away(error: OperationalError) -> bool:
    """Whether the engine did not answer in time: its server is gone, or others hold SQLite's lock for too long."""
    # Lost in the middle, or not to be had: psycopg's errors have a state, an empty one where no server gave it.
    if error.connection_invalidated or getattr(error.orig, "sqlstate", "none") is None:
        return True
    code = getattr(error.orig, "sqlite_errorcode", 0) & 0xFF
    starting_or_ending = str(getattr(error.orig, "sqlstate", "")).startswith("57P0")
    return starting_or_ending or code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)


def is_read_only(error: BaseException) -> bool:
    """Whether the engine may only be read: its file or folder cannot be written, or its server takes no changes."""
    said = getattr(error, "orig", None) or error
    code = getattr(said, "sqlite_errorcode", 0) & 0xFF
    return code == sqlite3.SQLITE_READONLY or getattr(said, "sqlstate", None) == _READ_ONLY


def is_deadlock(error: BaseException) -> bool:
    """Whether the engine ended a unit of work because two waited for each other: done again, it goes through."""
    return getattr(getattr(error, "orig", None), "sqlstate", None) in _TRY_AGAIN


class Database:
    """Units of work over one engine.

    `write()` commits when its block ends and rolls back when it raises; what it could not commit raises `Undone`. On
    SQLite it takes the write lock at once, so that two writers queue instead of failing half-way. `read()` never
    commits.

    Threads of one process queue for SQLite's write lock here: SQLite itself would have them sleep and try again, up to
    a tenth of a second at a time, in the order they came.

    patience_s: how long PostgreSQL may take for one statement before the unit of work fails; None: as long as it takes.
    A service has one; commands that migrate, check or back up wait for statements that take long.
    """

    def __init__(self, url: str, patience_s: float | None = None) -> None:
        self.url = make_url(url)
        self.engine = _engine(url, patience_s)
        self.notices = Notices(self.engine)
        self._writer = threading.Lock()
        self._file: tuple[int, int] | None = None

    @property
    def embedded(self) -> bool:
        """True for SQLite."""
        return self.engine.dialect.name == "sqlite"

    @contextmanager
    def write(self, actor: str, now: Callable[[], datetime]) -> Iterator[Store]:
        """A unit of work that commits at its end, its history with it; actor: who acts; now: the clock."""
        engine = self.engine.execution_options(begin="IMMEDIATE")
        self._require_file()
        with Session(engine, expire_on_commit=False) as session:
            with self._queue(), session.begin():
                history = History(session, actor, now)
                yield Store(session, history)
                _require_alive(session)
                history.finish()
                self.notices.announce(session)
            self.notices.tell(session)

    def _require_file(self) -> None:
        """Raise FileGone unless SQLite's file is the one that was first opened; a new one would be made silently."""
        if not self.embedded or self.url.database in (None, "", ":memory:"):
            return
        try:
            found = Path(str(self.url.database)).stat()
        except FileNotFoundError:
            if self._file is None:
                return  # it is about to be made
            raise FileGone(f"{self.url.database} is not there any more") from None
        seen = (found.st_dev, found.st_ino)
        self._file = self._file or seen
        if seen != self._file:
            raise FileGone(f"{self.url.database} is another file than the one that was opened")

    @contextmanager
    def _queue(self) -> Iterator[None]:
        # Past the time-out SQLite is asked all the same, and says itself that it is busy.
        held = self.embedded and self._writer.acquire(timeout=BUSY_TIMEOUT_MS / 1e3)
        try:
            yield
        finally:
            if held:
                self._writer.release()

    @contextmanager
    def read(self) -> Iterator[Store]:
        """A unit of work that only looks, at one moment: all its statements see the same."""
        self._require_file()
        engine = self.engine if self.embedded else self.engine.execution_options(isolation_level="REPEATABLE READ")
        with Session(engine) as session:
            yield Store(session)
            session.rollback()

    def close(self) -> None:
        """Close all connections, those that are in use as soon as they are handed back."""
        self.notices.close()
        # A thread that still has one hands it back to a pool that is not disposed of again.
        event.listen(self.engine.pool, "checkin", _close_at_once)
        self.engine.dispose()


def _close_at_once(connection: object, record: ConnectionPoolEntry) -> None:
    if connection is not None:
        record.invalidate()


def _require_alive(session: Session) -> None:
    """Raise Undone where nothing can be committed: PostgreSQL takes COMMIT for ROLLBACK then, silently."""
    alive = session.is_active
    if alive and session.get_bind().dialect.name == "postgresql":
        driver: Any = session.connection().connection.driver_connection
        alive = driver.info.transaction_status.name != "INERROR"
    if not alive:
        raise Undone("a statement of this unit of work was refused, and all of it undone: nothing was stored")


def _engine(url: str, patience_s: float | None) -> Engine:
    parsed = make_url(url)
    if parsed.get_backend_name() != "sqlite":
        return _server_engine(parsed, patience_s)
    engine = create_engine(parsed, connect_args={"check_same_thread": False})
    event.listen(engine, "connect", _prepare_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _server_engine(url: URL, patience_s: float | None) -> Engine:
    """An engine over PostgreSQL, which tries a connection that was idle before it hands it out."""
    if patience_s is None:
        return create_engine(url, pool_pre_ping=True)
    from db.bounded_connection import CONNECT_S, PING_S, BoundedConnection  # psycopg, which SQLite does not need

    engine = create_engine(url, pool_pre_ping=True, pool_timeout=POOL_S)
    ping = engine.dialect.do_ping

    def connect(_dialect: object, _record: object, where: list[Any], how: dict[str, Any]) -> BoundedConnection:
        limits = {"connect_timeout": CONNECT_S, "tcp_user_timeout": int(1e3 * patience_s), "keepalives_idle": 5}
        made = BoundedConnection.connect(*where, **{**limits, **how})
        made.patience_s = patience_s
        return made

    def ping_briefly(dbapi_connection: Any) -> bool:
        dbapi_connection.patience_s = min(PING_S, patience_s)
        try:
            return ping(dbapi_connection)
        finally:
            dbapi_connection.patience_s = patience_s

    event.listen(engine, "do_connect", connect)
    engine.dialect.do_ping = ping_briefly  # type: ignore[method-assign]
    return engine


def _prepare_sqlite(connection: Any, _record: object) -> None:
    # The driver's own idea of when a transaction begins would defeat BEGIN IMMEDIATE.
    connection.isolation_level = None
    # First of all how long to wait: another process may be making the file at this moment.
    for pragma in (f"busy_timeout={BUSY_TIMEOUT_MS}", "journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON"):
        connection.execute(f"PRAGMA {pragma}")


def _begin_sqlite(connection: Connection) -> None:
    connection.exec_driver_sql(f"BEGIN {connection.get_execution_options().get('begin', 'DEFERRED')}")
