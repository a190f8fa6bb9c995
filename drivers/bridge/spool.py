"""Durable FIFO of readings awaiting acknowledgement (SQLite).

One file, one bridge. What was put once is never put again, nor is what was acknowledged and came again meanwhile:
the highest number of each source is kept. The oldest is kept: when the spool is full, new readings are refused.
How far the counters of the source's frames were is kept with them, so that a later bridge can tell what it missed.
"""

from __future__ import annotations

import json
import sqlite3
import threading
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from drivers.checks import require
from drivers.closeable import Openable
from drivers.errors import SpoolFull, SpoolUnusable
from drivers.reading import Answer, Counter, Entry, Mark
from drivers.reading_json import answer_from_json, answer_to_json, reading_to_json
from drivers.reading_rules import reading_from_dict

PAGE_BYTES = 4096
MIN_BYTES = 32 * PAGE_BYTES
FORMAT = 2
READING, ANSWER = 0, 1
MAX_HELD = 100_000
"""Entries that are held in memory besides, so that what is sent soon need not be read back."""

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
CREATE TABLE IF NOT EXISTS counter (
    source TEXT NOT NULL, name TEXT NOT NULL, count INTEGER NOT NULL, at REAL NOT NULL, period_s REAL,
    mark INTEGER NOT NULL DEFAULT 0, PRIMARY KEY (source, name)
) WITHOUT ROWID;
"""
_FROM_FORMAT_1 = "ALTER TABLE counter ADD COLUMN mark INTEGER NOT NULL DEFAULT 0;"


class Spooled(NamedTuple):
    """One entry of the spool: its place, whether it is an answer, its JSON, and itself where it is still at hand."""

    id: int
    kind: int
    source: str
    sequence: int
    body: str
    held: Entry | None = None

    def entry(self) -> Entry:
        """The reading or answer itself."""
        if self.held is not None:
            return self.held
        return answer_from_json(self.body) if self.kind == ANSWER else reading_from_dict(json.loads(self.body))


class Spool(Openable):
    """The spool in an SQLite file; open within a with block or between `open` and `close`. Safe between threads."""

    def __init__(self, path: Path, *, max_bytes: int = 256 * 1024 * 1024, most_held: int = MAX_HELD) -> None:
        require(max_bytes >= MIN_BYTES, f"max_bytes {max_bytes} of the spool", f"be {MIN_BYTES} or more")
        self.path = path
        self._max_bytes, self._most_held = max_bytes, most_held
        self._lock = threading.RLock()
        self._db: sqlite3.Connection | None = None
        self._file: tuple[int, int] | None = None
        self._waiting = self._last_id = 0
        self._held: deque[Spooled] | None = None
        """All that waits, in order; None where more waits than is held."""
        self._owed: tuple[int, int] | None = None
        """What is acknowledged and still on disk, from id to id: a full one could not forget it yet."""

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
            if not 0 <= version <= FORMAT:
                raise SpoolUnusable(
                    f"spool {self.path} is of format {version}, this version reads {FORMAT}: move it away"
                )
            older = _FROM_FORMAT_1 if version == 1 else ""
            # A spool as it should be is not written to: its disk may be full.
            change = f"{older} {_SCHEMA} PRAGMA user_version={FORMAT};" if version != FORMAT else ""
            self._db.executescript(f"BEGIN EXCLUSIVE; {change} COMMIT;")
            (self._waiting,) = self._db.execute("SELECT count(*) FROM kept").fetchone()
            self._held = None if self._waiting else deque()
            self._last_id = self._newest_id()
            opened = self.path.stat()
            self._file = (opened.st_dev, opened.st_ino)
        except (sqlite3.Error, OSError) as error:
            self.close()
            if isinstance(error, SpoolUnusable):
                raise
            advice = "make room" if _is_full(error) else "is another bridge using it, may this user write there?"
            raise SpoolUnusable(f"spool {self.path} cannot be used ({error}): {advice}") from error

    def is_in_place(self) -> bool:
        """Whether the open file is still the one at its path: what is kept in a deleted one goes with the process."""
        try:
            found = self.path.stat()
        except OSError:
            return False
        return self._file in (None, (found.st_dev, found.st_ino))

    def close(self) -> None:
        """Let go of the file; harmless when closed."""
        with self._lock:
            database, self._db = self._db, None
            if database is not None:
                database.close()

    # ------------------------------------------------------------ in
    def put(self, entries: Sequence[Entry | Mark]) -> int:
        """Keep entries, all or none, on disk when this returns; returns how many were new. Of marks the last is kept.

        Numbers of a source increase: what is not above its highest was kept before. Raises `SpoolFull`.
        """
        try:
            return self._put(entries)
        except SpoolFull:
            with self._lock:
                self._make_room()
            return self._put(entries)

    def _put(self, entries: Sequence[Entry | Mark]) -> int:
        with self._lock:
            last, marks = self._last_id, {}
            with _Transaction(self._connection, self.path) as db:
                highest = {(kind, source): top for kind, source, top in db.execute("SELECT * FROM highest")}
                fresh = []
                for entry in entries:
                    if isinstance(entry, Mark):
                        marks[entry.source] = entry
                        continue
                    kind = ANSWER if isinstance(entry, Answer) else READING
                    if entry.sequence > highest.get((kind, entry.source), -1):
                        highest[kind, entry.source] = entry.sequence
                        body = answer_to_json(entry) if isinstance(entry, Answer) else reading_to_json(entry)
                        last += 1
                        fresh.append(Spooled(last, kind, entry.source, entry.sequence, body, entry))
                if fresh:
                    db.executemany("INSERT INTO kept VALUES (?, ?, ?, ?, ?)", [one[:-1] for one in fresh])
                    tops = [(kind, source, top) for (kind, source), top in highest.items()]
                    db.executemany("INSERT OR REPLACE INTO highest VALUES (?, ?, ?)", tops)
                for mark in marks.values():
                    counters = [
                        (mark.source, c.name, c.count, c.at.timestamp(), c.period_s, mark.number) for c in mark.counters
                    ]
                    db.executemany("INSERT OR REPLACE INTO counter VALUES (?, ?, ?, ?, ?, ?)", counters)
            self._last_id = last
            self._waiting += len(fresh)
            if self._held is not None:
                self._held.extend(fresh)
                if len(self._held) > self._most_held:
                    self._held = None
        return len(fresh)

    # ------------------------------------------------------------ out
    def first(self, most: int) -> Sequence[Spooled]:
        """The oldest that wait, in the order they came."""
        query = "SELECT id, kind, source, sequence, body FROM kept WHERE id > ? ORDER BY id LIMIT ?"
        with self._lock:
            database = self._connection
            if self._held is not None:
                return list(islice(self._held, most))
            with _Transaction(database, self.path) as db:
                return [Spooled(*row) for row in db.execute(query, (self._owed[1] if self._owed else 0, most))]

    def done(self, items: Sequence[Spooled]) -> None:
        """Forget the oldest, up to the last of `items`; on a full disk in memory first, and there with the next."""
        if items:
            with self._lock:
                first, last = items[0].id, items[-1].id
                self._forget(len(items), first, last)
                self._owed = (self._owed[0] if self._owed else first, last)
                try:
                    self._settle()
                except SpoolFull:
                    self._make_room()

    def set_aside(self, item: Spooled, reason: str) -> None:
        """Keep an entry apart, with what the service said to it: it is not sent again. Raises `SpoolFull`."""
        try:
            self._set_aside(item, reason)
        except SpoolFull:
            with self._lock:
                self._make_room()
            self._set_aside(item, reason)

    def _set_aside(self, item: Spooled, reason: str) -> None:
        with self._lock:
            with _Transaction(self._connection, self.path) as db:
                row = (item.id, item.kind, item.source, item.sequence, item.body, reason)
                db.execute("INSERT OR REPLACE INTO aside VALUES (?, ?, ?, ?, ?, ?)", row)
                gone = db.execute("DELETE FROM kept WHERE id = ?", (item.id,)).rowcount
            self._forget(gone, item.id, item.id)

    def send_again(self) -> int:
        """Put what was set aside back in its place; returns how many."""
        with self._lock:
            with _Transaction(self._connection, self.path) as db:
                db.execute("INSERT INTO kept SELECT id, kind, source, sequence, body FROM aside")
                back = int(db.execute("DELETE FROM aside").rowcount)
            self._waiting += back
            self._held = self._held if not back else None
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

    def mark(self, source: str) -> Mark | None:
        """How far the counters of a source's frames were with the last that was kept; None where none ever was."""
        query = "SELECT name, count, at, period_s, mark FROM counter WHERE source = ?"
        with self._lock, _Transaction(self._connection, self.path) as db:
            rows = db.execute(query, (source,)).fetchall()
        if not rows:
            return None
        counters = (
            Counter(name, count, datetime.fromtimestamp(at, UTC), period) for name, count, at, period, _ in rows
        )
        return Mark(source, max(row[-1] for row in rows), tuple(counters))

    def _forget(self, gone: int, first: int, last: int) -> None:
        """Take this many, from id `first` to `last`, out of what is held."""
        self._waiting -= gone
        if not self._waiting:
            self._held = deque()
        elif self._held is not None and self._held[0].id == first:
            while self._held and self._held[0].id <= last:
                self._held.popleft()
        elif self._held is not None:
            self._held = deque(one for one in self._held if not first <= one.id <= last)

    def _newest_id(self) -> int:
        (newest,) = self._connection.execute("SELECT max(seq) FROM sqlite_sequence WHERE name = 'kept'").fetchone()
        return int(newest or 0)

    @property
    def _connection(self) -> sqlite3.Connection:
        if self._db is None:
            raise SpoolUnusable(f"spool {self.path} is not open: open it first")
        return self._db

    def _settle(self) -> None:
        """Delete what is acknowledged. Raises `SpoolFull` where the disk cannot even take that."""
        if self._owed is not None:
            with _Transaction(self._connection, self.path) as db:
                db.execute("DELETE FROM kept WHERE id BETWEEN ? AND ?", self._owed)
            self._owed = None

    def _make_room(self) -> None:
        """What can be done about a full disk from here; the put that follows says whether it was enough."""
        emptied = settled = False
        with suppress(sqlite3.Error):
            # The journal may be what hit the limit, and it can be emptied into the file.
            self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            emptied = True
        with suppress(SpoolFull):
            self._settle()
            settled = True
        if not self._waiting and not (emptied and settled):
            self._begin_anew()

    def _begin_anew(self) -> None:
        """Write the file anew with the little that it must know, as all that fills the disk is acknowledged."""
        database = self._connection
        if database.execute("SELECT 1 FROM aside").fetchone():
            return  # that is in no other place
        known = {name: database.execute(f"SELECT * FROM {name}").fetchall() for name in ("highest", "counter")}  # noqa: S608
        self.close()
        for suffix in ("-wal", "-shm", ""):
            Path(f"{self.path}{suffix}").unlink(missing_ok=True)
        self.open()
        self._owed = None
        with _Transaction(self._connection, self.path) as db:
            for name, rows in known.items():
                for row in rows:
                    db.execute(f"INSERT INTO {name} VALUES ({', '.join('?' * len(row))})", row)  # noqa: S608


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
        if _is_full(error):
            return SpoolFull(
                f"spool {self._path} or its disk is full ({error}): nothing new is kept until the service has taken "
                "some of what waits, or there is room"
            )
        return SpoolUnusable(f"spool {self._path} cannot be used ({error}): check the file")


def _is_full(error: BaseException) -> bool:
    """Whether SQLite says that its disk has no room; a file that may not grow is told as an error of the disk."""
    return getattr(error, "sqlite_errorcode", 0) & 0xFF in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR)
