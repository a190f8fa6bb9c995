"""The schema, through Alembic only."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, text

from db.database import Database
from db.rows import Base

_MIGRATING = 4_672
"""Advisory lock of PostgreSQL."""


def upgrade(database: Database, revision: str = "head") -> None:
    """Bring the schema up to `revision`, keeping the data. Several processes that do it at once wait for each other."""
    with _alone(database) as connection:
        command.upgrade(_config(connection), revision)


def downgrade(database: Database, revision: str) -> None:
    """Take the schema back to `revision`; `base` is before the first table."""
    with _alone(database) as connection:
        command.downgrade(_config(connection), revision)


@contextmanager
def _alone(database: Database) -> Iterator[Connection]:
    """A unit of work for which all others that change the schema wait, and which then sees what they have done."""
    with database.engine.execution_options(begin="IMMEDIATE").begin() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _MIGRATING})
        yield connection


def present_revision(database: Database) -> str | None:
    """The revision the schema is at; None for an empty database."""
    with database.engine.connect() as connection:
        return MigrationContext.configure(connection).get_current_revision()


def newest_revision() -> str:
    """The revision this version of Drumtrue needs."""
    return revisions()[-1]


def is_known(revision: str | None) -> bool:
    """Whether this version of Drumtrue has the migration; a newer version's database is at one it has not."""
    return revision is None or revision in revisions()


@cache
def revisions() -> tuple[str, ...]:
    """All revisions, oldest first, as they were when this process first asked."""
    return tuple(script.revision for script in ScriptDirectory.from_config(_config()).walk_revisions())[::-1]


def drift(database: Database) -> list[object]:
    """Differences between the schema and the tables in `rows`; empty when the migrations are complete."""
    with database.engine.connect() as connection:
        return list(compare_metadata(MigrationContext.configure(connection), Base.metadata))


def revise(database: Database, message: str) -> None:
    """Write a migration from the present schema to the tables in `rows`, numbered after the newest one."""
    number = f"{int(newest_revision()) + 1:04d}"
    with database.engine.begin() as connection:
        command.revision(_config(connection), message, autogenerate=True, rev_id=number)


def _config(connection: Connection | None = None) -> Config:
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations").replace("%", "%%"))
    config.attributes["connection"] = connection
    return config
