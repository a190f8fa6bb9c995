"""The schema, through Alembic only.

Alembic is loaded where the schema is changed: a start that finds it up to date needs the table of its version alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection, inspect, text

from db.database import Database

if TYPE_CHECKING:
    from alembic.config import Config

MIGRATIONS = Path(__file__).parent / "migrations"
_VERSION_TABLE = "alembic_version"

_MIGRATING = 4_672
"""Advisory lock of PostgreSQL."""


def upgrade(database: Database, revision: str = "head") -> None:
    """Bring the schema up to `revision`, keeping the data. Several processes that do it at once wait for each other."""
    from alembic import command

    with _alone(database) as connection:
        command.upgrade(_config(connection), revision)


def downgrade(database: Database, revision: str) -> None:
    """Take the schema back to `revision`; `base` is before the first table."""
    from alembic import command

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
        if not inspect(connection).has_table(_VERSION_TABLE):
            return None
        return connection.execute(text(f"SELECT version_num FROM {_VERSION_TABLE}")).scalar()  # noqa: S608


def newest_revision() -> str:
    """The revision this version of Drumtrue needs."""
    return revisions()[-1]


def is_known(revision: str | None) -> bool:
    """Whether this version of Drumtrue has the migration; a newer version's database is at one it has not."""
    return revision is None or revision in revisions()


@cache
def revisions() -> tuple[str, ...]:
    """All revisions, oldest first, as they were when this process first asked: the numbers of the migrations' files."""
    return tuple(sorted(path.name.partition("_")[0] for path in (MIGRATIONS / "versions").glob("[0-9]*_*.py")))


def drift(database: Database) -> list[object]:
    """Differences between the schema and the tables in `rows`; empty when the migrations are complete."""
    from alembic.autogenerate import compare_metadata
    from alembic.runtime.migration import MigrationContext

    from db.rows import Base

    with database.engine.connect() as connection:
        return list(compare_metadata(MigrationContext.configure(connection), Base.metadata))


def revise(database: Database, message: str) -> None:
    """Write a migration from the present schema to the tables in `rows`, numbered after the newest one."""
    from alembic import command

    number = f"{int(newest_revision()) + 1:04d}"
    with database.engine.begin() as connection:
        command.revision(_config(connection), message, autogenerate=True, rev_id=number)


def _config(connection: Connection | None = None) -> Config:
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config
