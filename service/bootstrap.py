"""The only place that builds things."""

from __future__ import annotations

from pathlib import Path

from db import migrate
from db.database import Database
from service.errors import Conflict
from service.settings import Settings
from service.usecases.work import Work


def open_database(settings: Settings) -> Database:
    """The database, its schema up to date: an empty or older SQLite file is migrated, a PostgreSQL must be already.

    Raises Conflict for a PostgreSQL whose schema is not the one this version needs.
    """
    database = Database(settings.database_url)
    if database.embedded:
        if database.url.database:
            Path(database.url.database).expanduser().parent.mkdir(parents=True, exist_ok=True)
        migrate.upgrade(database)
        return database
    present, newest = migrate.present_revision(database), migrate.newest_revision()
    if present != newest:
        database.close()
        raise Conflict(
            f"the database's schema is at revision {present}, this version needs {newest}",
            code="schema_out_of_date",
            field="database_url",
            value=present,
            advice="run `drumtrue migrate` with the same database address, then start again",
        )
    return database


def build_work(settings: Settings) -> Work:
    """Everything the use cases need."""
    return Work(database=open_database(settings), max_readings=settings.max_readings)
