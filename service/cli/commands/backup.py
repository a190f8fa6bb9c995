"""`drumtrue backup`, `restore` and `retain`."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy.engine import make_url
from sqlalchemy.exc import DatabaseError

from db import backup
from db.database import lacks_room
from service import bootstrap
from service.cli.support.files import counted, writing
from service.errors import Conflict, InvalidInput, StorageFull
from service.messages import Message
from service.settings import Settings


def back_up_to(path: Path, database_url: str | None) -> None:
    """Write a backup and say what is in it.

    Raises Conflict where the file is there or the database is damaged, else InvalidInput.
    """
    settings = Settings.from_environment(database_url=database_url)
    database = bootstrap.open_database(settings, create=False)
    try:
        with writing(path, "backup"):
            rows = backup.back_up(database, path)
    except backup.Damaged as wrong:
        raise Conflict(
            Message("database_damaged", database=settings.shown, reason=wrong), field="database_url", value=str(wrong)
        ) from wrong
    finally:
        database.close()
    print(f"{path}: {_in_words(rows)}")


def restore_from(path: Path, database_url: str | None) -> None:
    """Put a backup into a database that holds nothing yet.

    Raises Conflict where it does, or where the backup is of a newer version, StorageFull where there is no room for
    it, else InvalidInput.
    """
    settings = Settings.from_environment(database_url=database_url)
    try:
        with _room(path, settings):
            # Opened, and made, only for a file that is a backup.
            rows = backup.restore(path, lambda: bootstrap.open_database(settings))
    except backup.NotEmpty as holds:
        raise Conflict(Message("database_not_empty", table=holds), field="database_url", value=str(holds)) from holds
    except backup.TooNew as newer:
        raise Conflict(Message("schema_out_of_date.backup", revision=newer), field="FILE", value=str(newer)) from newer
    except (backup.NotABackup, sqlite3.Error, DatabaseError) as wrong:
        # The engine's own words: around them SQLAlchemy sets the statement, and a link to its pages.
        reason = wrong.orig if isinstance(wrong, DatabaseError) else wrong
        raise InvalidInput(
            Message("invalid_input.backup_unreadable", path=path, reason=reason), field="FILE", value=str(path)
        ) from wrong
    print(f"restored {_in_words(rows)}")


@contextmanager
def _room(path: Path, settings: Settings) -> Iterator[None]:
    """Leave no half-written database behind where the disk has no room. Raises StorageFull."""
    url = make_url(settings.database_url)
    file = Path(url.database) if url.get_backend_name() == "sqlite" and url.database else None
    is_new = file is not None and not file.exists()
    try:
        yield
    except (StorageFull, sqlite3.Error, DatabaseError) as wrong:
        if not isinstance(wrong, StorageFull) and not lacks_room(wrong):
            raise
        if file is not None and is_new:
            backup.remove(file)
        reason = wrong.__cause__ if isinstance(wrong, StorageFull) else wrong
        raise StorageFull(
            Message(
                "storage_full.restore",
                path=path,
                database=settings.shown,
                reason=getattr(reason, "orig", reason),
                folder=tempfile.gettempdir(),
            ),
            field="database_url",
            value=settings.shown,
        ) from wrong


def retain_for(days: int, database_url: str | None) -> None:
    """Roll up raw readings that are older, and say how many."""
    from service.usecases.readings.retention import retain

    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    try:
        kept = retain(work, days)
    finally:
        work.database.close()
    rolled = f"{counted(kept.readings, 'reading')} from before {kept.before.isoformat()}"
    print(f"{rolled} rolled up into {counted(kept.minutes, 'row')}")


def _in_words(rows: Mapping[str, int]) -> str:
    parts = counted(rows["session"], "session"), counted(rows["reading"], "reading")
    return f"{', '.join(parts)}, {counted(sum(rows.values()), 'row')} in all"
