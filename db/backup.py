"""A backup is an SQLite file with the tables of Drumtrue, whatever the engine it was taken from.

From SQLite it is taken by SQLite's own online backup, from PostgreSQL row by row in one REPEATABLE READ snapshot: each
sees one moment and holds no one up. No program of the server's version is needed (pg_dump must be as new as its
server), the file can be looked into, and it goes back into either engine.
"""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, MetaData, Table, Text, func, insert, select, text

from db import migrate
from db.database import Database
from db.rows import Base
from db.types import Document

BATCH = 1_000
"""Rows in memory at once."""


class NotEmpty(Exception):
    """The database that was to be restored holds rows; the message names the first table that does."""


class NotABackup(Exception):
    """The file is a database, but none of Drumtrue, or a damaged one; the message says what is wrong with it."""


class Damaged(Exception):
    """The database that was to be backed up is damaged; the message says what its copy lacks."""


class TooNew(Exception):
    """The backup is of a newer version; the message is its schema's revision."""


def back_up(database: Database, path: Path) -> dict[str, int]:
    """Write the database as of one moment to a new file; rows of each table.

    Until it is whole, and was checked, the file has another name, so that what bears the name is a backup. Raises
    Damaged for what `restore` would refuse, FileExistsError, OSError.
    """
    if path.exists():
        raise FileExistsError(path)
    unfinished = path.with_name(path.name + ".unfinished")
    remove(unfinished)
    try:
        if database.embedded:
            _copy_file(database.engine, unfinished)
        else:
            _copy_rows_out(database, unfinished)
        rows = _counted(unfinished)
        unfinished.rename(path)
    except sqlite3.DatabaseError as wrong:
        if _is_damage(wrong):
            raise Damaged(str(wrong)) from wrong
        raise
    finally:
        remove(unfinished)
    return rows


def remove(path: Path) -> None:
    """Remove an SQLite file that no one has open, and what SQLite put beside it."""
    for beside in ("", "-journal", "-wal", "-shm"):
        path.with_name(path.name + beside).unlink(missing_ok=True)


def damage(database: Database) -> str | None:
    """What is wrong with the structure of an SQLite database; None where all is whole. Every page is read."""
    with database.engine.connect() as connection:
        try:
            return _damage(_driver(connection))
        except sqlite3.DatabaseError as wrong:
            if _is_damage(wrong):
                return str(wrong)
            raise


def _is_damage(error: sqlite3.DatabaseError) -> bool:
    return getattr(error, "sqlite_errorcode", 0) & 0xFF in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def restore(path: Path, opened: Callable[[], Database]) -> dict[str, int]:
    """Put the rows of a backup into a database of this version that holds none; rows of each table.

    opened: opens the database, which is closed again; asked only for a file that is a backup. The file is left as it
    is: one of an older version is brought up to date in a copy. All or nothing is stored. Raises NotABackup, TooNew,
    NotEmpty, sqlite3.Error for a file that is no database, and what `opened` raises.
    """
    with tempfile.TemporaryDirectory() as folder:
        copy = Database(f"sqlite:///{Path(folder) / 'copy.db'}")
        try:
            _copy_of(path, copy)
            with closing(opened()) as database:
                return _restore(copy, database)
        finally:
            copy.close()


def _copy_of(path: Path, copy: Database) -> None:
    """The backup in a copy, brought up to date and found whole: nothing is opened for one that cannot be read."""
    # Reading a file that keeps a log, SQLite makes one beside it, unless it is told that nobody writes.
    alone = "" if path.with_name(f"{path.name}-wal").exists() else "&immutable=1"
    address = f"{path.absolute().as_uri()}?mode=ro{alone}"
    with closing(sqlite3.connect(address, uri=True)) as source, copy.engine.connect() as held:
        source.backup(_driver(held))
    revision = migrate.present_revision(copy)
    if revision is None:
        raise NotABackup("it holds no tables of Drumtrue")
    if not migrate.is_known(revision):
        raise TooNew(revision)
    migrate.upgrade(copy)
    with copy.engine.connect() as connection:
        _require_whole(connection)


def _require_whole(connection: Connection) -> None:
    """Raise NotABackup for a damaged page, a row that breaks a rule of its table, or a table that is not there."""
    for table in _plain_tables():
        connection.execute(select(table).limit(1))
    if found := _damage(_driver(connection)):
        raise NotABackup(f"it is damaged: {found}")


def _damage(connection: sqlite3.Connection) -> str | None:
    """The first damaged page, or row that breaks a rule of its table; None where all is whole."""
    (found,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
    if found != "ok":
        return str(found)
    orphan = connection.execute("PRAGMA foreign_key_check").fetchone()
    return None if orphan is None else f"a row of table {orphan[0]} lacks its row of table {orphan[2]}"


def _restore(copy: Database, database: Database) -> dict[str, int]:
    engine = database.engine.execution_options(begin="IMMEDIATE")
    with copy.engine.connect() as source_rows, engine.begin() as target:
        return _copy_rows_in(source_rows, target)


def _copy_file(engine: Engine, path: Path) -> None:
    with closing(sqlite3.connect(path)) as target, engine.connect() as held:
        # In one step: in several it would begin again whenever another process has written.
        _driver(held).backup(target, pages=-1)
        target.execute("PRAGMA journal_mode=DELETE")  # one file, without a log beside it


def _copy_rows_out(database: Database, path: Path) -> None:
    target = Database(f"sqlite:///{path}")
    snapshot = database.engine.execution_options(isolation_level="REPEATABLE READ")
    try:
        migrate.upgrade(target, migrate.present_revision(database) or "base")
        with snapshot.connect() as source, target.engine.begin() as rows:
            source.execute(text("SET TRANSACTION READ ONLY"))
            _copy(source, rows)
        with target.engine.connect() as connection:
            connection.execution_options(isolation_level="AUTOCOMMIT")
            _driver(connection).execute("PRAGMA wal_checkpoint(TRUNCATE)")
            _driver(connection).execute("PRAGMA journal_mode=DELETE")
    finally:
        target.close()


def _copy_rows_in(source: Connection, target: Connection) -> dict[str, int]:
    for table in _plain_tables():
        if target.execute(select(table).limit(1)).first() is not None:
            raise NotEmpty(table.name)
    copied = _copy(source, target)
    if target.dialect.name == "postgresql":
        for table in _plain_tables():
            _count_on(target, table)
    return copied


def _copy(source: Connection, target: Connection) -> dict[str, int]:
    copied = {}
    for table in _plain_tables():
        copied[table.name] = 0
        found = source.execution_options(yield_per=BATCH).execute(select(table))
        for batch in found.mappings().partitions():
            target.execute(insert(table), [dict(row) for row in batch])
            copied[table.name] += len(batch)
    return copied


def _plain_tables() -> Iterable[Table]:
    """The tables, parents first, documents as the text they are: a backup judges none."""
    plain = MetaData()
    for table in Base.metadata.sorted_tables:
        mine = table.to_metadata(plain)
        for column in mine.columns:
            if isinstance(column.type, Document):
                column.type = Text()
    return plain.sorted_tables


def _count_on(target: Connection, table: Table) -> None:
    """Let a key that PostgreSQL numbers go on after the highest that was put in."""
    (key, *more) = table.primary_key.columns
    if not more and key.autoincrement is True:
        sequence = func.pg_get_serial_sequence(table.name, key.name)
        highest = select(func.max(key)).scalar_subquery()
        target.execute(select(func.setval(sequence, func.coalesce(highest, 1), highest.is_not(None))))


def _counted(path: Path) -> dict[str, int]:
    """Rows of each table of a file that is whole. Raises Damaged."""
    with closing(sqlite3.connect(path)) as connection:
        if found := _damage(connection):
            raise Damaged(found)
        names = [table.name for table in Base.metadata.sorted_tables]
        return {n: connection.execute(f"SELECT count(*) FROM {n}").fetchone()[0] for n in names}  # noqa: S608


def _driver(connection: Connection) -> Any:
    """sqlite3's own connection."""
    return connection.connection.driver_connection
