"""Publish and subscribe to stored changes: in this process at once, in others by PostgreSQL's NOTIFY.

A notice carries no data, only the key of a machine, session or design run that something was stored of; who is woken
looks for itself. So a notice may be lost (a cut connection, a crash) or come twice: the one costs a delay, the other a
look.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from sqlalchemy import Engine, event, text
from sqlalchemy.orm import Session

CHANNEL = "drumtrue"
MIN_GAP_S = 0.2
"""Other processes are told of a machine's readings no more often: commits that notify queue behind each other."""
RETRY_S = 1.0
LISTEN_S = 0.5
"""How long the listening connection waits before it looks whether to stop."""

_KEYS = ("machine_id", "session_id", "design_run_id")
_ROWS = "topics of rows"
_STREAMS = "topics of streams"

Wake = Callable[[], None]


class Notices:
    """Who waits for which keys, and how they are told."""

    def __init__(self, engine: Engine, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._engine = engine
        self._across = engine.dialect.name == "postgresql"
        self._monotonic = monotonic
        self._lock = threading.Lock()
        self._waiting: dict[str, list[Wake]] = {}
        self._told: dict[str, float] = {}
        self._listener: _Listener | None = None
        self._closed = False

    @contextmanager
    def waiting(self, topics: Iterable[str], wake: Wake) -> Iterator[None]:
        """Call `wake`, from any thread and no longer than a moment, whenever something is stored of these keys."""
        wanted = tuple(topics)
        with self._lock:
            for topic in wanted:
                self._waiting.setdefault(topic, []).append(wake)
            if self._across and self._listener is None and not self._closed:
                self._listener = _Listener(self._engine, self._wake, self._wake_all)
                self._listener.start()
        try:
            yield
        finally:
            with self._lock:
                for topic in wanted:
                    self._waiting[topic].remove(wake)
                    if not self._waiting[topic]:
                        del self._waiting[topic]

    def announce(self, session: Session) -> None:
        """Within the unit of work, before it commits: other processes hear of it when, and only if, it does."""
        session.flush()
        if self._across:
            of_rows = _topics(session, _ROWS)
            for topic in (*sorted(of_rows), *self._due(_topics(session, _STREAMS) - of_rows)):
                session.execute(text("SELECT pg_notify(:channel, :topic)"), {"channel": CHANNEL, "topic": topic})

    def tell(self, session: Session) -> None:
        """After the commit: wake those who wait in this process."""
        for topic in _topics(session, _ROWS) | _topics(session, _STREAMS):
            self._wake(topic)

    def close(self) -> None:
        """Stop listening; no one is woken by other processes any more."""
        with self._lock:
            self._closed, listener, self._listener = True, self._listener, None
        if listener is not None:
            listener.stop()

    def _due(self, topics: Iterable[str]) -> list[str]:
        now = self._monotonic()
        with self._lock:
            due = [topic for topic in sorted(topics) if now - self._told.get(topic, -MIN_GAP_S) >= MIN_GAP_S]
            if due:
                self._told = {key: at for key, at in self._told.items() if now - at < MIN_GAP_S}
                self._told.update(dict.fromkeys(due, now))
        return due

    def _wake(self, topic: str) -> None:
        with self._lock:
            found = tuple(self._waiting.get(topic, ()))
        for wake in found:
            wake()

    def _wake_all(self) -> None:
        with self._lock:
            found = {wake for some in self._waiting.values() for wake in some}
        for wake in found:
            wake()


class _Listener(threading.Thread):
    """A connection of its own that listens; cut off, it connects again and wakes all for what they may have missed."""

    def __init__(self, engine: Engine, wake: Callable[[str], None], wake_all: Wake) -> None:
        super().__init__(name="notices", daemon=True)
        self._engine = engine
        self._wake = wake
        self._wake_all = wake_all
        self._ended = threading.Event()

    def stop(self) -> None:
        """End within about the time of one wait."""
        self._ended.set()
        self.join(timeout=2 * LISTEN_S)

    def run(self) -> None:
        import psycopg  # its libraries take as long to load as all of SQLite's work at a start

        while not self._ended.is_set():
            try:
                self._listen()
            except psycopg.Error:
                self._ended.wait(RETRY_S)

    def _listen(self) -> None:
        import psycopg

        where, how = self._engine.dialect.create_connect_args(self._engine.url)
        with psycopg.connect(*where, **{**how, "autocommit": True}) as connection:
            connection.execute(f"LISTEN {CHANNEL}")
            self._wake_all()
            while not self._ended.is_set():
                for notice in connection.notifies(timeout=LISTEN_S):
                    self._wake(notice.payload)
                    if self._ended.is_set():
                        return


def stream(session: Session, topics: Iterable[str]) -> None:
    """Say that readings are stored of these keys: many times a second, and no mapped row tells."""
    session.info.setdefault(_STREAMS, set()).update(topics)


def _topics(session: Session, kind: str) -> set[str]:
    found: set[str] = session.info.get(kind, set())
    return found


@event.listens_for(Session, "before_flush")
def _notice_rows(session: Session, _context: Any, _instances: Any) -> None:
    """Each row that changes names the machine, session or design run it is of; a session's row is one itself."""
    for row in (*session.new, *session.dirty):
        keys = [getattr(row, name, None) for name in _KEYS]
        if row.__tablename__ in ("session", "machine", "design_run"):
            keys.append(row.id)
        session.info.setdefault(_ROWS, set()).update(key for key in keys if key)
