"""A backup is one moment of the database, taken while it is written to, and goes back into either engine."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest

from db import backup
from db.database import Database
from service.usecases import audit
from service.usecases.readings import ingest
from tests.api.readings.test_readings import arrival
from tests.support.http.workshop import Workshop, workshop
from tests.support.storage.engines import ENGINES, engine_named
from tests.support.storage.filling import counted

BATCH = 10


@pytest.fixture(params=ENGINES)
def other(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Address of an empty database to restore into."""
    (folder := tmp_path / "other").mkdir()
    engine = engine_named(request.param)
    url = engine.migrated(folder)
    yield url
    engine.drop(url)


def test_a_backup_goes_back_into_either_engine(shop: Workshop, other: str, tmp_path: Path) -> None:
    session = shop.session(shop.machine())
    shop.fit(shop.planned(session))
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    path = tmp_path / "backup.db"
    rows = backup.back_up(shop.work.database, path)
    paths = (f"/sessions/{session}", "/machines", "/catalogues", f"/sessions/{session}/log")
    said = [shop.get(one) for one in paths]
    assert rows == counted(shop.work.database)
    database = Database(other)
    assert backup.restore(path, lambda: Database(other)) == rows
    with pytest.raises(backup.NotEmpty):
        backup.restore(path, lambda: Database(other))
    assert counted(database) == rows
    database.close()
    with workshop(other) as restored:
        assert [restored.get(one) for one in paths] == said
        assert audit.verify(restored.work).findings == ()
        assert restored.ask("PUT", "/sources/bridge", {"machine_id": said[0]["machine_id"]})
        assert restored.post("/readings", arrival(1)) == {"accepted": 1, "duplicates": 0}


def test_a_backup_taken_during_writes_is_one_moment(shop: Workshop, tmp_path: Path) -> None:
    """Every batch whole or not at all, none before an earlier one of its source, and every reference kept."""
    sources = ("a", "b")
    machine = shop.machine()
    for source in sources:
        shop.ask("PUT", f"/sources/{source}", {"machine_id": machine})
    stop, written = threading.Event(), threading.Semaphore(0)

    def write(source: str) -> int:
        sent = 0
        while not stop.is_set():
            body = [{**arrival(n), "source": source} for n in range(sent, sent + BATCH)]
            shop.post("/readings", body)
            sent += BATCH
            written.release()
        return sent

    with ThreadPoolExecutor(len(sources)) as threads:
        writers = [threads.submit(write, source) for source in sources]
        paths = [tmp_path / f"{n}.db" for n in range(3)]
        try:
            for path in paths:
                assert written.acquire(timeout=30)
                backup.back_up(shop.work.database, path)
        finally:
            stop.set()
        sent = [writer.result() for writer in writers]
    stored = 0
    for path in paths:
        with closing(sqlite3.connect(path)) as connection:
            assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
            assert connection.execute("PRAGMA foreign_key_check").fetchall() == []
            for source, most in zip(sources, sent, strict=True):
                query = "SELECT count(*), coalesce(max(sequence) + 1, 0) FROM reading WHERE source = ?"
                count, above = connection.execute(query, (source,)).fetchone()
                assert count == above <= most
                assert count % BATCH == 0
            total = connection.execute("SELECT count(*) FROM reading").fetchone()[0]
        assert total >= max(stored, BATCH)
        stored = total
    assert ingest.highest_sequence(shop.work, "a") == sent[0] - 1


def test_no_file_is_replaced(shop: Workshop, tmp_path: Path) -> None:
    path = tmp_path / "there"
    path.write_text("precious")
    with pytest.raises(FileExistsError):
        backup.back_up(shop.work.database, path)
    assert path.read_text() == "precious"
    assert [one.name for one in tmp_path.iterdir() if "unfinished" in one.name] == []
