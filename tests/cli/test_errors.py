"""What goes wrong on the command line is told in words, with what to do, and ends with status 1."""

from __future__ import annotations

import socket
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import pytest

from service.cli import main
from tests.support.storage.engines import engine_named


def told(arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    """What the command says on its way out."""
    monkeypatch.setattr(sys, "argv", ["drumtrue", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 1
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["migrate", "--database-url", "nonsense"], "sqlite:///PATH"),
        (["migrate", "--database-url", "sqlite:////proc/nowhere/drumtrue.db"], "folder can be written"),
        (["serve", "--port", "0", "--host", "192.0.2.1", "--database-url", "sqlite://"], "cannot listen"),
    ],
    ids=["no address", "folder that cannot be written", "address of another machine"],
)
def test_addresses(
    arguments: list[str], word: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = told(arguments, monkeypatch, capsys)
    assert word in said
    assert "what to do:" in said


def test_a_database_that_is_damaged_is_told_in_the_words_of_its_engine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    url = engine_named("sqlite").migrated(tmp_path)
    file = Path(url.removeprefix("sqlite:///"))
    with closing(sqlite3.connect(file)) as connection:
        (page,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'token'").fetchone()
        (size,) = connection.execute("PRAGMA page_size").fetchone()
    with file.open("r+b") as contents:
        contents.seek((page - 1) * size)
        contents.write(bytes([7]) * size)
    said = told(["token", "list", "--database-url", url], monkeypatch, capsys)
    assert said.startswith("drumtrue: the database failed: database disk image is malformed\n")
    assert "sqlalche.me" not in said


def test_a_port_that_is_taken(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert "choose another --port" in told(["serve", "--port", port], monkeypatch, capsys)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (b"{", "must be JSON"),
        (b"\xff\xfe", "must be JSON"),
        (b"[]", "the log: Input should be an object"),
        (b"{}", "machine: Field required"),
        (b'{"machine": NaN, "runs": []}', "machine: Input should be an object"),
        (b'{"machine": {"name": "drum", "service_speed_rpm": NaN}}', "machine.service_speed_rpm"),
        (b'{"machine": null, "runs": [{"kind": "initial", "readings": [null]}]}', "machine"),
        (b"[" * 100_000, "must be JSON"),
    ],
    ids=["no JSON", "no text", "a list", "nothing", "nan", "nan in the machine", "null", "too deep"],
)
def test_a_file_that_is_no_log(
    text: bytes, word: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "log.json"
    file.write_bytes(text)
    said = told(["solve", str(file)], monkeypatch, capsys)
    assert word in said
    assert "docs/reference/log.md" in said or "GET /sessions/{id}/log" in said
