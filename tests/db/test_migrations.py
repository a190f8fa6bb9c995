"""The schema changes through migrations: up with data, down again, and no further than the tables say."""

from __future__ import annotations

from pathlib import Path

import pytest
from sqlalchemy import inspect, text

from db import migrate
from db.database import Database
from db.rows import Base
from service import bootstrap
from service.errors import Conflict
from service.settings import Settings
from tests.api.workshop import workshop

FIRST = "0001"
"""The revision that a database of the first release is at."""


@pytest.fixture
def database(empty_url: str) -> Database:
    """A database without any table."""
    return Database(empty_url)


def tables(database: Database) -> set[str]:
    """Names of the tables there are."""
    return set(inspect(database.engine).get_table_names()) - {"alembic_version"}


def test_up_and_down(database: Database) -> None:
    assert migrate.present_revision(database) is None
    migrate.upgrade(database)
    assert migrate.present_revision(database) == migrate.newest_revision()
    assert tables(database) == {table.name for table in Base.metadata.sorted_tables}
    migrate.downgrade(database, "base")
    assert tables(database) == set()
    migrate.upgrade(database)
    assert tables(database) == {table.name for table in Base.metadata.sorted_tables}


def test_every_step_down_and_up_again_keeps_what_it_can(empty_url: str) -> None:
    """With a whole session stored: each migration above the first is undone and done again over its rows."""
    with workshop(empty_url) as shop:
        shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
        session = shop.session()
        shop.fit(shop.planned(session))
        before = shop.get(f"/sessions/{session}")
        rows = {table.name: shop.count(table.name) for table in Base.metadata.sorted_tables}
        migrate.downgrade(shop.work.database, FIRST)
        assert migrate.present_revision(shop.work.database) == FIRST
        migrate.upgrade(shop.work.database)
        assert {table.name: shop.count(table.name) for table in Base.metadata.sorted_tables} == rows
        assert shop.get(f"/sessions/{session}") == before


def test_down_to_nothing_with_data_in_the_tables(empty_url: str) -> None:
    with workshop(empty_url) as shop:
        shop.fit(shop.planned(shop.session()))
        migrate.downgrade(shop.work.database, "base")
        assert tables(shop.work.database) == set()


def test_migrations_and_tables_do_not_drift_apart(database: Database) -> None:
    migrate.upgrade(database)
    assert migrate.drift(database) == []


def test_drift_is_seen(database: Database) -> None:
    migrate.upgrade(database)
    with database.engine.begin() as connection:
        connection.execute(text("DROP TABLE stock_entry"))
    assert migrate.drift(database) != []


def test_an_empty_embedded_database_is_migrated_when_it_is_opened(empty_url: str) -> None:
    opened = bootstrap.open_database(Settings(database_url=empty_url))
    assert migrate.present_revision(opened) == migrate.newest_revision()


def test_a_server_database_that_is_out_of_date_is_refused(empty_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A PostgreSQL is shared: nobody migrates it by starting. Here any engine stands for it."""
    monkeypatch.setattr(Database, "embedded", False)
    settings = Settings(database_url=empty_url)
    with pytest.raises(Conflict, match="revision None") as refused:
        bootstrap.open_database(settings)
    assert refused.value.code == "schema_out_of_date"
    assert "drumtrue migrate" in (refused.value.advice or "")
    assert bootstrap.migrate_database(settings) == (None, migrate.newest_revision())
    assert migrate.present_revision(bootstrap.open_database(settings)) == migrate.newest_revision()


def test_a_schema_newer_than_the_program_is_refused(database: Database, empty_url: str) -> None:
    migrate.upgrade(database)
    with database.engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(Conflict) as refused:
        bootstrap.open_database(Settings(database_url=empty_url))
    assert refused.value.code == "schema_out_of_date"
    with pytest.raises(Conflict, match="9999"):
        bootstrap.migrate_database(Settings(database_url=empty_url))


def test_the_folder_of_a_new_file_is_made(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "drumtrue.db"
    bootstrap.open_database(Settings(database_url=f"sqlite:///{path}")).close()
    assert path.is_file()
