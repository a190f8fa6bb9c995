"""The schema changes through migrations: up with data, down again, and no further than the tables say."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import inspect, text

from db import migrate
from db.database import Database
from db.rows import Base
from service import bootstrap
from service.errors import Conflict
from service.settings import Settings
from tests.support.http.workshop import Workshop
from tests.support.storage.filling import counted, fill


@pytest.fixture
def database(empty_url: str) -> Iterator[Database]:
    """A database without any table."""
    opened = Database(empty_url)
    yield opened
    opened.close()


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


def test_every_revision_up_and_down_with_rows_in_every_table(database: Database) -> None:
    """Rows of every table and every revision come through all steps up; steps down keep those of the tables left."""
    revisions = migrate.revisions()
    for revision in revisions:
        migrate.upgrade(database, revision)
        before = counted(database)
        fill(database.engine)
        assert all(rows > before[table] for table, rows in counted(database).items())
    whole = counted(database)
    for revision in reversed(revisions[:-1]):
        before = counted(database)
        migrate.downgrade(database, revision)
        left = counted(database)
        assert left == {table: before[table] for table in left}
    for revision in revisions:
        left = counted(database)
        migrate.upgrade(database, revision)
        now = counted(database)
        for table, rows in left.items():  # an upgrade may tell the history of what it found
            assert now[table] == rows or (table == "audit" and now[table] > rows)
    assert set(counted(database)) == set(whole)
    migrate.downgrade(database, "base")
    assert tables(database) == set()


def test_a_whole_session_comes_through_a_step_down_and_up(shop: Workshop) -> None:
    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    session = shop.session()
    shop.fit(shop.planned(session))
    before = shop.get(f"/sessions/{session}")
    for revision in reversed(migrate.revisions()):
        migrate.downgrade(shop.work.database, revision)
        assert migrate.present_revision(shop.work.database) == revision
    migrate.upgrade(shop.work.database)
    after = shop.get(f"/sessions/{session}")
    # The count of changes is younger than the first tables; what it counted is not.
    assert {**after, "version": 0} == {**before, "version": 0}


def test_migrations_and_tables_do_not_drift_apart(database: Database) -> None:
    migrate.upgrade(database)
    assert migrate.drift(database) == []


def test_drift_is_seen(database: Database) -> None:
    migrate.upgrade(database)
    with database.engine.begin() as connection:
        connection.execute(text("DROP TABLE stock_entry"))
    assert migrate.drift(database) != []


def test_an_empty_embedded_database_is_migrated_when_it_is_opened(tmp_path: Path) -> None:
    opened = bootstrap.open_database(Settings(database_url=f"sqlite:///{tmp_path / 'drumtrue.db'}"))
    assert migrate.present_revision(opened) == migrate.newest_revision()


@pytest.mark.parametrize("older", [False, True], ids=["new", "older"])
def test_several_that_open_a_file_at_once_wait_for_each_other(tmp_path: Path, older: bool) -> None:
    settings = Settings(database_url=f"sqlite:///{tmp_path / 'drumtrue.db'}")
    if older:
        with closing(Database(settings.database_url)) as first:
            migrate.upgrade(first, migrate.revisions()[2])
    start = threading.Barrier(6)

    def opened(_number: int) -> str | None:
        start.wait(10)
        with closing(bootstrap.open_database(settings)) as database:
            return migrate.present_revision(database)

    with ThreadPoolExecutor(6) as threads:
        assert set(threads.map(opened, range(6))) == {migrate.newest_revision()}


def test_several_that_migrate_a_server_at_once_wait_for_each_other(empty_url: str) -> None:
    settings = Settings(database_url=empty_url)
    with ThreadPoolExecutor(3) as threads:
        after = [threads.submit(bootstrap.migrate_database, settings) for _ in range(3)]
        assert {one.result()[1] for one in after} == {migrate.newest_revision()}


def test_a_server_database_that_is_out_of_date_is_refused(empty_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A PostgreSQL is shared: nobody migrates it by starting. An SQLite that is taken for one stands for any server."""
    monkeypatch.setattr(Database, "embedded", False)
    settings = Settings(database_url=empty_url)
    with pytest.raises(Conflict, match="it is at nothing") as refused:
        bootstrap.open_database(settings)
    assert refused.value.code == "schema_out_of_date"
    assert "drumtrue migrate" in (refused.value.advice or "")
    assert bootstrap.migrate_database(settings) == (None, migrate.newest_revision())
    opened = bootstrap.open_database(settings)
    assert migrate.present_revision(opened) == migrate.newest_revision()
    opened.close()


def test_a_schema_newer_than_the_program_is_refused(url: str) -> None:
    database = Database(url)
    with database.engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    database.close()
    with pytest.raises(Conflict) as refused:
        bootstrap.open_database(Settings(database_url=url))
    assert refused.value.code == "schema_out_of_date"
    with pytest.raises(Conflict, match="9999"):
        bootstrap.migrate_database(Settings(database_url=url))


def test_the_folder_of_a_new_file_is_made(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "drumtrue.db"
    bootstrap.open_database(Settings(database_url=f"sqlite:///{path}")).close()
    assert path.is_file()
