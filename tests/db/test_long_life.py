"""What each version stored is migrated, verified, read and solved by this one; a migration that is killed recovers."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from sqlalchemy import event

from db import backup, migrate
from db.database import Database
from drivers.files.readings import Recorder, read_recording
from service.cli.commands.transfer import export_sessions, import_sessions
from service.engine.logs.replay import read_log, resolve
from service.usecases import audit
from service.usecases.repair import repair
from tests.support.http.workshop import Workshop, work_over, workshop
from tests.support.storage.engines import Engine
from tests.support.storage.record_version import VERSIONS

RECORDED = sorted(folder.name for folder in VERSIONS.iterdir())


def recorded(version: str, folder: Path) -> Path:
    """The database of a version, as it left it."""
    path = folder / f"{version}.db"
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript((VERSIONS / version / "drumtrue.sql").read_text(encoding="utf-8"))
    return path


@contextmanager
def upgraded(version: str, engine: Engine, folder: Path) -> Iterator[Workshop]:
    """A workshop over what a version left: its own file, or its backup restored into a server."""
    path = recorded(version, folder)
    if engine.name == "sqlite":
        with workshop(f"sqlite:///{path}") as shop:
            yield shop
        return
    url = engine.migrated(folder)
    backup.restore(path, lambda: Database(url))
    try:
        with workshop(url) as shop:
            yield shop
    finally:
        engine.drop(url)


@pytest.mark.parametrize("version", RECORDED)
def test_what_a_version_stored_is_read_verified_and_exported(engine: Engine, version: str, tmp_path: Path) -> None:
    with upgraded(version, engine, tmp_path) as shop:
        assert audit.verify(shop.work).findings == ()
        assert repair(shop.work).unreadable == ()
        sessions = shop.get("/sessions")
        assert len(sessions) == 3
        for session in sessions:
            for path in ("", "/log", "/report.json", "/history"):
                shop.get(f"/sessions/{session['id']}{path}")
        url = shop.work.database.url.render_as_string(hide_password=False)
        assert export_sessions([], tmp_path / "all.jsonl", url) == 0
        import_sessions(tmp_path / "all.jsonl", f"sqlite:///{tmp_path / 'elsewhere.db'}")
        for session in sessions:
            if session["state"] != "closed":
                shop.ask("PATCH", f"/sessions/{session['id']}", {"state": "closed"})
        assert audit.verify(shop.work).findings == ()


@pytest.mark.only("sqlite")
@pytest.mark.parametrize("version", RECORDED)
def test_the_logs_of_a_version_give_their_answers_again_and_can_be_imported(
    engine: Engine, version: str, tmp_path: Path
) -> None:
    logs = VERSIONS / version / "logs.jsonl"
    for line in logs.read_text(encoding="utf-8").splitlines():
        assert resolve(read_log(line)).changed == ()
    import_sessions(logs, f"sqlite:///{tmp_path / 'elsewhere.db'}")


@pytest.mark.only("sqlite")
@pytest.mark.parametrize("version", RECORDED)
def test_the_recording_of_a_version_is_read_written_again_and_stored(
    engine: Engine, version: str, tmp_path: Path
) -> None:
    recording = VERSIONS / version / "recording.jsonl"
    readings = list(read_recording(recording))
    assert [one.sequence for one in readings] == list(range(1, len(readings) + 1))
    assert {one.source for one in readings} == {"pickup 5 mm"}
    with Recorder(tmp_path / "again.jsonl") as again:
        again.write(readings)
    assert (tmp_path / "again.jsonl").read_bytes() == recording.read_bytes()
    with upgraded(version, engine, tmp_path) as shop:
        shop.ask("PUT", "/sources/pickup%205%20mm", {"machine_id": shop.machine()})
        sent = [json.loads(line) for line in recording.read_text(encoding="utf-8").splitlines()]
        assert shop.post("/readings", sent)["accepted"] == len(readings)


class Killed(BaseException):
    """The process ends here."""


@contextmanager
def killed_after(database: Database, statements: int) -> Iterator[Callable[[], int]]:
    """Lose the connection before a statement; gives how many there were."""
    seen = 0

    def count(connection: object, cursor: object, *_more: object) -> None:
        nonlocal seen
        seen += 1
        if seen > statements:
            raw = getattr(cursor, "connection", None)
            assert raw is not None
            raw.close()  # what was not committed is gone, as it is when a process is killed
            raise Killed

    event.listen(database.engine, "before_cursor_execute", count)
    try:
        yield lambda: seen
    finally:
        event.remove(database.engine, "before_cursor_execute", count)


def test_a_migration_that_is_killed_at_any_statement_recovers(engine: Engine, tmp_path: Path) -> None:
    """From what 0.1.0 left, whose scatter is mended and whose rows are attested on the way."""
    statements = 0
    while True:
        folder = tmp_path / str(statements)
        folder.mkdir()
        url = at_first_revision(engine, folder)
        database = Database(url)
        before = migrate.present_revision(database)
        try:
            with killed_after(database, statements):
                migrate.upgrade(database)
            return
        except Killed:
            database.engine.dispose()
            assert migrate.present_revision(database) in migrate.revisions()[migrate.revisions().index(before or "") :]
            migrate.upgrade(database)
            assert migrate.present_revision(database) == migrate.newest_revision()
            assert audit.verify(work_over(database)).findings == ()
        finally:
            database.close()
            engine.drop(url)
        statements += 1 + statements // 4  # each of the first, then ever longer steps: the later are alike


def at_first_revision(engine: Engine, folder: Path) -> str:
    """Address of a database with what 0.1.0 left, at the revision it left it at."""
    path = recorded(RECORDED[0], folder)
    if engine.name == "sqlite":
        return f"sqlite:///{path}"
    url = engine.migrated(folder)
    backup.restore(path, lambda: Database(url))
    database = Database(url)
    migrate.downgrade(database, "0010")
    database.close()
    return url
