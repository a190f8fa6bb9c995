"""The only place that builds things."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError, DatabaseError, NoSuchModuleError, OperationalError

from db import migrate
from db.database import Database, is_read_only, lacks_room
from service.errors import Conflict, InvalidInput, Unavailable
from service.messages import Message
from service.runtime.context import AppContext, storage_full, storage_read_only
from service.runtime.solver_slots import SolverSlots
from service.settings import Settings


def migrate_database(settings: Settings) -> tuple[str | None, str | None]:
    """Bring the schema up to date; returns its revision before and after."""
    database = _database(settings)
    try:
        with _answering(settings):
            before = migrate.present_revision(database)
            _require_known(before)
            migrate.upgrade(database)
            return before, migrate.present_revision(database)
    finally:
        database.close()


def open_database(settings: Settings, *, create: bool = True, patience_s: float | None = None) -> Database:
    """The database, its schema up to date: an empty or older SQLite file is migrated, a PostgreSQL must be already.

    patience_s: as of `Database`.

    Raises Conflict for a PostgreSQL whose schema is not the one this version needs, and for any database that a newer
    version has migrated; Unavailable for an SQLite file that is not there, unless it may be created.
    """
    if not create:
        _require_file(settings)
    database = _database(settings, patience_s)
    try:
        with _answering(settings):
            _make_current(database)
    except BaseException:
        database.close()
        raise
    return database


def _make_current(database: Database) -> None:
    present, newest = migrate.present_revision(database), migrate.newest_revision()
    _require_known(present)
    if present == newest:
        return
    if database.embedded:
        migrate.upgrade(database)
        return
    raise Conflict(
        Message("schema_out_of_date.older", present=present, newest=newest), field="database_url", value=present
    )


def _database(settings: Settings, patience_s: float | None = None) -> Database:
    try:
        database = Database(settings.database_url, patience_s)
    except (ArgumentError, NoSuchModuleError, ModuleNotFoundError) as wrong:
        raise InvalidInput(
            Message("invalid_input.database_address", database=settings.shown, reason=wrong),
            field="database_url",
            value=settings.shown,
        ) from wrong
    if database.embedded and database.url.database:
        with _answering(settings):
            Path(database.url.database).parent.mkdir(parents=True, exist_ok=True)
    return database


def _require_file(settings: Settings) -> None:
    """Refuse a file that does not exist: an empty new database would verify as sound."""
    path = make_url(settings.database_url).database if settings.database_url.startswith("sqlite") else None
    if path and not Path(path).exists():
        raise Unavailable(
            Message("unavailable.no_database", database=settings.shown), field="database_url", value=settings.shown
        )


def _require_known(revision: str | None) -> None:
    if not migrate.is_known(revision):
        raise Conflict(Message("schema_out_of_date.newer", revision=revision), field="database_url", value=revision)


@contextmanager
def _answering(settings: Settings) -> Iterator[None]:
    try:
        yield
    except (DatabaseError, OSError) as broken:
        if isinstance(broken, DatabaseError) and not isinstance(broken, OperationalError):
            raise InvalidInput(
                Message("invalid_input.database_unreadable", database=settings.shown, reason=broken.orig),
                field="database_url",
                value=settings.shown,
            ) from broken
        if isinstance(broken, OperationalError) and lacks_room(broken):
            raise storage_full(broken) from broken
        if isinstance(broken, OperationalError) and is_read_only(broken):
            raise storage_read_only(broken) from broken
        reason = broken.orig if isinstance(broken, DatabaseError) else broken
        raise Unavailable(
            Message("unavailable.database", database=settings.shown, reason=reason),
            field="database_url",
            value=settings.shown,
        ) from broken


def build_work(settings: Settings, *, create: bool = True, patience_s: float | None = None) -> AppContext:
    """Everything the use cases need.

    create: an SQLite file that is not there becomes a new one. patience_s: as of `Database`.
    """
    database = open_database(settings, create=create, patience_s=patience_s)
    return AppContext(
        database=database,
        max_readings=settings.max_readings,
        max_ahead_s=settings.max_ahead_s,
        turns=SolverSlots(settings.solves),
    )
