"""`drumtrue backup`, `restore` and `retain`."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from sqlalchemy.exc import DatabaseError

from db import backup
from service import bootstrap
from service.errors import Conflict, InvalidInput
from service.settings import Settings


def back_up_to(path: Path, database_url: str | None) -> None:
    """Write a backup and say what is in it. Raises Conflict where the file is there, else InvalidInput."""
    database = bootstrap.open_database(Settings.from_environment(database_url=database_url), create=False)
    try:
        rows = backup.back_up(database, path)
    except FileExistsError as there:
        raise Conflict(
            f"{path} is there already",
            code="file_exists",
            field="FILE",
            value=str(path),
            advice="name another file: a backup never replaces one",
        ) from there
    except (OSError, sqlite3.Error) as wrong:
        raise InvalidInput(
            f"cannot write {path}: {wrong}",
            field="FILE",
            value=str(path),
            advice="name a file in a folder that can be written and has room",
        ) from wrong
    finally:
        database.close()
    print(f"{path}: {rows['session']} sessions, {rows['reading']} readings, {sum(rows.values())} rows in all")


def restore_from(path: Path, database_url: str | None) -> None:
    """Put a backup into a database that holds nothing yet. Raises Conflict where it does, else InvalidInput."""
    database = bootstrap.open_database(Settings.from_environment(database_url=database_url))
    try:
        rows = backup.restore(path, database)
    except backup.NotEmpty as holds:
        raise Conflict(
            f"the database holds rows already (table {holds})",
            code="database_not_empty",
            field="database_url",
            value=str(holds),
            advice="restore into a new file or an empty PostgreSQL database (after `drumtrue migrate`), then point "
            "the service there",
        ) from holds
    except (sqlite3.Error, DatabaseError) as wrong:
        raise InvalidInput(
            f"{path} is no backup that can be read: {wrong}",
            field="FILE",
            value=str(path),
            advice="nothing was stored; give a file that `drumtrue backup` wrote",
        ) from wrong
    finally:
        database.close()
    print(f"restored {rows['session']} sessions, {rows['reading']} readings, {sum(rows.values())} rows in all")


def retain_for(days: int, database_url: str | None) -> None:
    """Roll up raw readings that are older, and say how many."""
    from service.usecases.retaining import retain

    work = bootstrap.build_work(Settings.from_environment(database_url=database_url), create=False)
    try:
        kept = retain(work, days)
    finally:
        work.database.close()
    print(f"{kept.readings} readings from before {kept.before.isoformat()} rolled up into {kept.minutes} rows")
