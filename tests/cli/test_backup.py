"""`drumtrue backup`, `restore`, `retain`, `export` and `import`, as they are typed."""

from __future__ import annotations

import json
import resource
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from db.database import Database
from service import bootstrap
from service.cli.commands.verify import verify_history
from service.errors import Conflict, InvalidInput, NotFound, StorageFull, Unavailable
from service.runtime.context import utc_now
from service.settings import Settings
from service.usecases.access import logins, tokens
from tests.api.readings.test_readings import arrival
from tests.api.test_storage_full import limit_pages
from tests.cli.test_token import ran
from tests.support.http.workshop import workshop
from tests.support.storage.engines import engine_named


@pytest.fixture
def url(tmp_path: Path) -> str:
    return engine_named("sqlite").migrated(tmp_path)


@pytest.fixture
def empty(tmp_path: Path) -> str:
    (folder := tmp_path / "empty").mkdir()
    return engine_named("sqlite").migrated(folder)


@pytest.fixture
def sessions(url: str) -> list[str]:
    """A closed session and an open one, and a reading."""
    with workshop(url) as shop:
        closed, opened = shop.session(), shop.session()
        shop.fit(shop.planned(closed))
        shop.ask("PATCH", f"/sessions/{closed}", {"state": "closed"})
        shop.ask("PUT", "/sources/bridge", {"machine_id": shop.get("/machines")[0]["id"]})
        shop.post("/readings", arrival(1))
    return [closed, opened]


def at(address: str) -> tuple[str, str]:
    return ("--database-url", address)


def test_a_backup_is_written_once_and_restored_into_what_is_empty(
    url: str, empty: str, sessions: list[str], tmp_path: Path
) -> None:
    file = tmp_path / "backup.db"
    assert "2 sessions, 1 reading," in ran("backup", str(file), *at(url))
    with pytest.raises(Conflict, match="exists already"):
        ran("backup", str(file), *at(url))
    with pytest.raises(InvalidInput, match="cannot write"):
        ran("backup", str(tmp_path / "nowhere" / "backup.db"), *at(url))
    assert "restored 2 sessions, 1 reading," in ran("restore", str(file), *at(empty))
    with pytest.raises(Conflict, match="must be empty"):
        ran("restore", str(file), *at(empty))
    (tmp_path / "no.db").write_bytes(b"nothing of the kind" * 100)
    with pytest.raises(InvalidInput, match="must be a backup, it cannot be read"):
        ran("restore", str(tmp_path / "no.db"), *at(empty))
    sqlite3.connect(tmp_path / "other.db").close()
    new = tmp_path / "new" / "drumtrue.db"
    for name in ("no.db", "other.db"):
        with pytest.raises(InvalidInput, match="must be a backup, it cannot be read"):
            ran("restore", str(tmp_path / name), *at(f"sqlite:///{new}"))
    assert not new.parent.exists()


def changed(*statements: str) -> Callable[[Path], None]:
    """Change a backup by statements of SQL."""

    def change(file: Path) -> None:
        with closing(sqlite3.connect(file, isolation_level=None)) as connection:
            for statement in statements:
                connection.execute(statement)

    return change


def zero_the_last_page(file: Path) -> None:
    whole = file.read_bytes()
    file.write_bytes(whole[:-4096] + bytes(4096))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (changed("UPDATE alembic_version SET version_num = '9999'"), "the backup's schema is at revision 9999"),
        (changed("DROP TABLE session"), "no such table"),
        (changed("DELETE FROM machine"), "it is damaged: a row of table"),
        (zero_the_last_page, "it is damaged: "),
        (changed("PRAGMA journal_mode=WAL", "DELETE FROM machine"), "it is damaged: "),
    ],
    ids=["newer", "table gone", "rows gone", "page gone", "with a log"],
)
def test_a_backup_that_cannot_be_restored_makes_no_database(
    url: str, sessions: list[str], tmp_path: Path, change: Callable[[Path], None], words: str
) -> None:
    file, new = tmp_path / "backup.db", tmp_path / "new" / "drumtrue.db"
    ran("backup", str(file), *at(url))
    change(file)
    with pytest.raises((InvalidInput, Conflict), match=words) as refused:
        ran("restore", str(file), *at(f"sqlite:///{new}"))
    assert (refused.value.code == "schema_out_of_date") == ("9999" in words)
    assert "sqlalche.me" not in str(refused.value)
    assert not new.parent.exists()
    assert not list(tmp_path.glob("backup.db-*"))


def test_a_damaged_database_gives_no_backup(
    url: str, sessions: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = Path(url.removeprefix("sqlite:///"))
    with closing(sqlite3.connect(file)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        (page,) = connection.execute(
            "SELECT rootpage FROM sqlite_master WHERE name = 'ix_reading_source_taken_at'"
        ).fetchone()
    whole = file.read_bytes()
    end = page * 4096
    for hurt in (
        bytes(4096),
        whole[end - 4096 : end - 64] + bytes(64),
    ):  # no page at all; an entry that is not the row's
        file.write_bytes(whole[: end - 4096] + hurt + whole[end:])
        with pytest.raises(Conflict, match="is damaged: ") as refused:
            ran("backup", str(tmp_path / "backup.db"), *at(url))
        assert refused.value.code == "database_damaged"
        assert not list(tmp_path.glob("backup.db*"))
        assert verify_history(url, None) == 1
        assert "database_damaged: " in capsys.readouterr().out
    file.write_bytes(whole)
    assert verify_history(url, None) == 0
    assert "the file's structure" in capsys.readouterr().out
    assert "2 sessions" in ran("backup", str(tmp_path / "backup.db"), *at(url))


@pytest.fixture
def limit_files() -> Iterator[Callable[[int], None]]:
    """Let no file of this process grow beyond so many bytes, till the test ends."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda most: resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_without_room_neither_a_backup_nor_a_database_is_begun(
    url: str, sessions: list[str], tmp_path: Path, limit_files: Callable[[int], None]
) -> None:
    file, new = tmp_path / "backup.db", tmp_path / "new.db"
    ran("backup", str(file), *at(url))
    limit_files(100_000)
    with pytest.raises(InvalidInput, match="cannot write"):
        ran("backup", str(tmp_path / "more.db"), *at(url))
    with pytest.raises(StorageFull, match="there is no room to restore"):
        ran("restore", str(file), *at(f"sqlite:///{new}"))
    assert not [*tmp_path.glob("more.db*"), *tmp_path.glob("new.db*")]


def test_a_database_that_fills_its_disk_on_the_way_is_removed(
    url: str, sessions: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, new = tmp_path / "backup.db", tmp_path / "new.db"
    ran("backup", str(file), *at(url))
    opened = bootstrap.open_database

    def narrow(settings: Settings) -> Database:
        limit_pages(database := opened(settings), 1)
        return database

    with monkeypatch.context() as patched:
        patched.setattr(bootstrap, "open_database", narrow)
        with pytest.raises(StorageFull, match=r"into sqlite.*is full"):
            ran("restore", str(file), *at(f"sqlite:///{new}"))
    assert not list(tmp_path.glob("new.db*"))
    assert "restored 2 sessions" in ran("restore", str(file), *at(f"sqlite:///{new}"))


def test_a_backup_holds_neither_token_nor_cookie(url: str, tmp_path: Path) -> None:
    with workshop(url) as shop:
        token, text = tokens.create(shop.work, "tablet", ["technician"])
        secrets = (text.rpartition("_")[2], logins.log_in(shop.work, text))
        ran("backup", str(tmp_path / "backup.db"), *at(url))
    stored = (tmp_path / "backup.db").read_bytes()
    assert token.id.encode() in stored
    assert not [secret for secret in secrets if secret.encode() in stored]


def test_old_readings_are_rolled_up(url: str, sessions: list[str]) -> None:
    old = utc_now() - timedelta(days=40)
    with workshop(url) as shop:
        shop.post("/readings", [{**arrival(n), "taken_at": old.isoformat()} for n in range(100, 110)])
    assert "readings from before" in ran("retain", "--days", "30", *at(url))
    with workshop(url) as shop:
        assert shop.count("reading_minute") >= 1
        assert shop.post("/readings", {**arrival(500), "taken_at": utc_now().isoformat()})["accepted"] == 1
    assert ran("retain", "--days", "30", *at(url)).startswith("0 readings")


def test_sessions_go_to_a_file_and_into_another_database(
    url: str, empty: str, sessions: list[str], tmp_path: Path
) -> None:
    every, one = tmp_path / "all.jsonl", tmp_path / "one.json"
    assert "2 sessions" in ran("export", "--all", "--to", str(every), *at(url))
    assert [json.loads(line)["session_id"] for line in every.read_text().splitlines()] == sessions
    assert ": 1 session\n" in ran("export", sessions[0], "--to", str(one), *at(url))
    assert json.loads(ran("solve", str(one), "--json"))["changed"] == []
    listed = f"holds 2 sessions:\n  {sessions[0]} drum 1 2026-.*\n  {sessions[1]} drum 3"
    with pytest.raises(InvalidInput, match=listed) as many:
        ran("solve", str(every))
    assert "--session" in (many.value.advice or "")
    assert json.loads(ran("solve", str(every), "--session", sessions[0], "--json"))["changed"] == []
    for file in (every, one):
        with pytest.raises(InvalidInput, match='"none":\n'):
            ran("solve", str(file), "--session", "none")
    one.write_text(json.dumps(json.loads(one.read_text()), indent=2))
    assert "1 session stored, 0 here already" in ran("import", str(one), *at(empty))
    assert "1 session stored, 1 here already" in ran("import", str(every), *at(empty))
    assert "everything is as it was written" in ran("verify", *at(empty))
    with pytest.raises(Conflict, match="exists already"):
        ran("export", "--all", "--to", str(every), *at(url))
    with pytest.raises(NotFound, match='no session "none"'):
        ran("export", sessions[0], "none", "--to", str(tmp_path / "some"), *at(url))
    assert not list(tmp_path.glob("some*"))


@pytest.mark.parametrize(
    ("second", "words"),
    [
        ("{", "line 2: the log: Invalid JSON"),
        ('{"format": "drumtrue-session"}', "line 2: "),
        ("[]", "line 2: "),
    ],
)
def test_a_file_with_a_bad_line_is_refused_whole(
    url: str, empty: str, sessions: list[str], tmp_path: Path, second: str, words: str
) -> None:
    file = tmp_path / "some.jsonl"
    ran("export", sessions[0], "--to", str(file), *at(url))
    file.write_text(file.read_text() + second + "\n")
    with pytest.raises(InvalidInput, match=words):
        ran("import", str(file), *at(empty))
    with workshop(empty) as shop:
        assert (shop.count("session"), shop.count("audit")) == (0, 0)


@pytest.mark.parametrize(
    "command",
    [["verify"], ["backup", "b.db"], ["export", "--all", "--to", "e.jsonl"], ["retain", "--days", "9"]],
    ids=lambda words: words[0],
)
def test_a_database_that_is_not_there_is_not_found_in_order(tmp_path: Path, command: list[str]) -> None:
    missing = tmp_path / "typo" / "none.db"
    named = [str(tmp_path / part) if part.endswith((".db", ".jsonl")) else part for part in command]
    with pytest.raises(Unavailable, match="there is no database"):
        ran(*named, "--database-url", f"sqlite:///{missing}")
    assert not missing.parent.exists()
