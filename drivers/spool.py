"""What waits for the service: on disk, in order, until it is acknowledged.

One file, one bridge. What was put once is never put again, nor is what was acknowledged and came again meanwhile:
the highest number of each source is kept. The oldest is kept: when the spool is full, new readings are refused.
"""

from __future__ import annotations

import sqlite3
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Generic, Protocol, Self, TypeVar

from drivers.checks import require
from drivers.errors import SpoolFull, SpoolUnusable
from drivers.reading import Answer, Entry
from drivers.wire import answer_to_json, reading_to_json

PAGE_BYTES = 4096
LEAST_BYTES = 32 * PAGE_BYTES
FORMAT = 1
READING, ANSWER = 0, 1

_SCHEMA = """
CREATE TABLE IF NOT EXISTS kept (
    id INTEGER PRIMARY KEY AUTOINCREMENT, kind INTEGER NOT NULL, source TEXT NOT NULL, sequence INTEGER NOT NULL,
    body TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS aside (
    id INTEGER PRIMARY KEY, kind INTEGER NOT NULL, source TEXT NOT NULL, sequence INTEGER NOT NULL,
    body TEXT NOT NULL, reason TEXT NOT NULL
);
CREATE TABLE IF NOT EXISTS highest (
    kind INTEGER NOT NULL, source TEXT NOT NULL, sequence INTEGER NOT NULL, PRIMARY KEY (kind, source)
) WITHOUT ROWID;
"""

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Spooled:
    """One entry of the spool: its place, whether it is an answer, and its JSON."""

    id: int
    kind: int
    source: str
    sequence: int
    body: str


class Keeper(Protocol, Generic[Item]):
    """Where readings wait: on disk beside the drum, in memory beside the database."""

    def put(self, entries: Sequence[Entry]) -> int:
        """Keep entries, all or none, those kept before only once; returns how many were new. Raises `SpoolFull`."""
        ...

    def first(self, most: int) -> Sequence[Item]:
        """The oldest that wait."""
        ...

    def done(self, items: Sequence[Item]) -> None:
        """Forget what was acknowledged; items: as `first` gave them."""
        ...

    def set_aside(self, item: Item, reason: str) -> None:
        """Take out of the way what the service will never take."""
        ...

    def waiting(self) -> int:
        """How many wait."""
        ...


class Spool:
    """The spool in an SQLite file; open within a with block or between `open` and `close`. Safe between threads."""

    def __init__(self, path: Path, *, max_bytes: int = 256 * 1024 * 1024) -> None:
        require(max_bytes >= LEAST_BYTES, f"max_bytes {max_bytes} of the spool", f"be {LEAST_BYTES} or more")
        self.path = path
        self._max_bytes = max_bytes
        self._lock = threading.RLock()
        self._db: sqlite3.Connection | None = None
        self._waiting = 0

    def open(self) -> None:
        """Open or create the file. Raises `SpoolUnusable`."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(self.path, isolation_level=None, check_same_thread=False, timeout=1.0)
            for pragma in (
                f"page_size={PAGE_BYTES}",
                "locking_mode=EXCLUSIVE",
                "journal_mode=WAL",
                "synchronous=FULL",
                f"max_page_count={self._max_bytes // PAGE_BYTES}",
            ):
                self._db.execute(f"PRAGMA {pragma}")
            (version,) = self._db.execute("PRAGMA user_version").fetchone()
            if version not in (0, FORMAT):
                raise SpoolUnusable(
                    f"spool {self.path} is of format {version}, this version reads {FORMAT}: move it away"
                )
            self._db.executescript(f"BEGIN EXCLUSIVE; {_SCHEMA} PRAGMA user_version={FORMAT}; COMMIT;")
            (self._waiting,) = self._db.execute("SELECT count(*) FROM kept").fetchone()
        except (sqlite3.Error, OSError) as error:
            self.close()
            if isinstance(error, SpoolUnusable):
                raise
            raise SpoolUnusable(
                f"spool {self.path} cannot be used ({error}): is another bridge using it, may this user write there?"
            ) from error

    def close(self) -> None:
        """Let go of the file; harmless when closed."""
        with self._lock:
            database, self._db = self._db, None
            if database is not None:
                database.close()

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # ------------------------------------------------------------ in
    def put(self, entries: Sequence[Entry]) -> int:
        """Keep entries, all or none, on disk when this returns; returns how many were new.

        Numbers of a source increase: what is not above its highest was kept before. Raises `SpoolFull`.
        """
        try:
            return self._put(entries)
        except SpoolFull:
            # The journal may be what hit the limit, and it can be emptied into the file.
            with self._lock:
                self._checkpoint()
            return self._put(entries)

    def _put(self, entries: Sequence[Entry]) -> int:
        with self._lock, _Transaction(self._connection, self.path) as db:
            highest = {(kind, source): top for kind, source, top in db.execute("SELECT * FROM highest")}
            fresh = []
            for entry in entries:
                kind = ANSWER if isinstance(entry, Answer) else READING
                if entry.sequence > highest.get((kind, entry.source), -1):
                    highest[kind, entry.source] = entry.sequence
                    body = answer_to_json(entry) if isinstance(entry, Answer) else reading_to_json(entry)
                    fresh.append((kind, entry.source, entry.sequence, body))
            if fresh:
                db.executemany("INSERT INTO kept (kind, source, sequence, body) VALUES (?, ?, ?, ?)", fresh)
                tops = [(kind, source, top) for (kind, source), top in highest.items()]
                db.executemany("INSERT OR REPLACE INTO highest VALUES (?, ?, ?)", tops)
        self._waiting += len(fresh)
        return len(fresh)

    # ------------------------------------------------------------ out
    def first(self, most: int) -> Sequence[Spooled]:
        """The oldest that wait, in the order they came."""
        query = "SELECT id, kind, source, sequence, body FROM kept ORDER BY id LIMIT ?"
        with self._lock, _Transaction(self._connection, self.path) as db:
            return [Spooled(*row) for row in db.execute(query, (most,))]

    def done(self, items: Sequence[Spooled]) -> None:
        """Forget the oldest, up to the last of `items`. Raises `SpoolFull` where the disk cannot even take that."""
        if items:
            with self._lock, _Transaction(self._connection, self.path) as db:
                gone = db.execute("DELETE FROM kept WHERE id BETWEEN ? AND ?", (items[0].id, items[-1].id)).rowcount
            self._waiting -= gone

    def set_aside(self, item: Spooled, reason: str) -> None:
        """Keep an entry apart, with what the service said to it: it is not sent again."""
        with self._lock, _Transaction(self._connection, self.path) as db:
            row = (item.id, item.kind, item.source, item.sequence, item.body, reason)
            db.execute("INSERT OR REPLACE INTO aside VALUES (?, ?, ?, ?, ?, ?)", row)
            gone = db.execute("DELETE FROM kept WHERE id = ?", (item.id,)).rowcount
        self._waiting -= gone

    def send_again(self) -> int:
        """Put what was set aside back in its place; returns how many."""
        with self._lock, _Transaction(self._connection, self.path) as db:
            db.execute("INSERT INTO kept SELECT id, kind, source, sequence, body FROM aside")
            back = db.execute("DELETE FROM aside").rowcount
        self._waiting += back
        return back

    def waiting(self) -> int:
        """How many wait."""
        return self._waiting

    def aside(self) -> list[tuple[str, int, str]]:
        """What was set aside: source, sequence, reason."""
        with self._lock, _Transaction(self._connection, self.path) as db:
            return list(db.execute("SELECT source, sequence, reason FROM aside ORDER BY id"))

    def highest(self, source: str) -> int:
        """The highest number that was ever kept of a source, of readings or answers; -1 for none."""
        with self._lock, _Transaction(self._connection, self.path) as db:
            (top,) = db.execute("SELECT max(sequence) FROM highest WHERE source = ?", (source,)).fetchone()
        return -1 if top is None else int(top)

    @property
    def _connection(self) -> sqlite3.Connection:
        if self._db is None:
            raise SpoolUnusable(f"spool {self.path} is not open: open it first")
        return self._db

    def _checkpoint(self) -> None:
        try:
            self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        except sqlite3.Error:
            return  # the put that follows says what is wrong


class MemorySpool:
    """A spool that ends with the process: for a listener beside the database, which keeps things itself."""

    def __init__(self, most: int = 200_000) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._entries: deque[Entry] = deque()

    def put(self, entries: Sequence[Entry]) -> int:
        """Keep entries, all or none. Raises `SpoolFull`."""
        with self._lock:
            if len(self._entries) + len(entries) > self._most:
                raise SpoolFull(f"{len(self._entries)} readings wait in memory, {self._most} are the most")
            self._entries.extend(entries)
        return len(entries)

    def first(self, most: int) -> Sequence[Entry]:
        """The oldest that wait."""
        with self._lock:
            return list(islice(self._entries, most))

    def done(self, items: Sequence[Entry]) -> None:
        """Forget the oldest, as many as `items`."""
        with self._lock:
            for _ in items:
                self._entries.popleft()

    def set_aside(self, item: Entry, reason: str) -> None:  # noqa: ARG002
        """Forget the one; the bridge has told why."""
        with self._lock:
            self._entries.remove(item)

    def waiting(self) -> int:
        """How many wait."""
        return len(self._entries)


class _Transaction:
    """All or nothing on the spool's connection; a full disk becomes `SpoolFull`, any other trouble `SpoolUnusable`."""

    def __init__(self, database: sqlite3.Connection, path: Path) -> None:
        self._database, self._path = database, path

    def __enter__(self) -> sqlite3.Connection:
        try:
            self._database.execute("BEGIN")
        except sqlite3.Error as error:
            raise self._told(error) from error
        return self._database

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        failure = error
        if error is None:
            try:
                self._database.execute("COMMIT")
                return
            except sqlite3.Error as refused:
                failure = refused
        if self._database.in_transaction:
            self._database.execute("ROLLBACK")
        if isinstance(failure, sqlite3.Error):
            raise self._told(failure) from failure

    def _told(self, error: sqlite3.Error) -> SpoolFull | SpoolUnusable:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF
        if code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
            return SpoolFull(
                f"spool {self._path} or its disk is full ({error}): nothing new is kept until the service has taken "
                "some of what waits, or there is room"
            )
        return SpoolUnusable(f"spool {self._path} cannot be used ({error}): check the file")
