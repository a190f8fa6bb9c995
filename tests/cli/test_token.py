"""`drumtrue token`, and that `serve` stays shut to strangers until there is one."""

from __future__ import annotations

import re
import socket
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from fastapi.testclient import TestClient
from typer.testing import CliRunner

from service.app import create_app
from service.cli import app
from service.cli.commands.serve import serve_until_stopped
from service.cli.commands.token import expiry
from service.errors import Conflict, InvalidInput, NotFound, Unavailable
from service.settings import Settings

TOKEN = re.compile(r"dt_[0-9a-z]{8}_[0-9a-z]{32}")
NOW = datetime(2026, 3, 1, tzinfo=UTC)


def ran(*arguments: str) -> str:
    """What a command prints; what it raises is raised."""
    return CliRunner().invoke(app, arguments, catch_exceptions=False).stdout


@pytest.fixture
def url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'drumtrue.db'}"


def test_a_token_is_shown_once_listed_without_its_secret_and_revoked(url: str) -> None:
    at = ("--database-url", url)
    shown = ran("token", "create", "bridge 1", "--scope", "bridge", "--expires", "90d", *at)
    text = TOKEN.search(shown)
    assert text is not None
    assert "scope bridge, good until" in shown
    quiet = ran("token", "create", "tablet", "--scope", "technician", "--scope", "bridge", "--quiet", *at)
    assert TOKEN.fullmatch(quiet.strip())
    listed = ran("token", "list", *at)
    assert "bridge 1" in listed
    assert "technician" in listed
    assert text.group().rpartition("_")[2] not in listed
    assert "'tablet' revoked at" in ran("token", "revoke", "tablet", *at)
    assert "'bridge 1' revoked at" in ran("token", "revoke", text.group().split("_")[1], *at)


@pytest.mark.parametrize(
    ("name", "scope", "expires", "words"),
    [
        ("x", "boss", "", 'no scope "boss"'),
        ("", "read", "", "the name must have 1 to 100"),
        ("a\nb", "read", "", "the name must have 1 to 100"),
        ("x", "read", "soon", 'a duration, got "soon"'),
        ("x", "read", "2001-01-01", "must lie in the future"),
    ],
)
def test_what_cannot_be_is_refused_and_makes_no_database(
    url: str, tmp_path: Path, name: str, scope: str, expires: str, words: str
) -> None:
    with pytest.raises(InvalidInput, match=words):
        ran("token", "create", name, "--scope", scope, "--expires", expires, "--database-url", url)
    for looking in (("list",), ("revoke", "x")):
        with pytest.raises(Unavailable, match="there is no database"):
            ran("token", *looking, "--database-url", url)
    assert not list(tmp_path.iterdir())


def test_a_name_is_used_once_and_an_unknown_one_told(url: str) -> None:
    ran("token", "create", "x", "--scope", "read", "--database-url", url)
    ran("token", "revoke", "x", "--database-url", url)
    with pytest.raises(Conflict, match='must differ from all before it, got "x" again'):
        ran("token", "create", "x", "--scope", "read", "--database-url", url)
    with pytest.raises(NotFound, match='no token "y"'):
        ran("token", "revoke", "y", "--database-url", url)


def test_times_in_words() -> None:
    assert expiry("", NOW) is None
    assert expiry("90d", NOW) == NOW + timedelta(days=90)
    assert expiry("12h", NOW) == NOW + timedelta(hours=12)
    assert expiry("2027-01-31", NOW) == datetime(2027, 1, 31, tzinfo=UTC)
    assert expiry("2027-01-31T12:00+02:00", NOW) == datetime(2027, 1, 31, 10, tzinfo=UTC)


def test_beyond_this_machine_it_starts_only_with_a_token(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.cli.commands.serve.signal.signal", lambda *_: None)
    started: list[Settings] = []

    class Server:
        def run(self, sockets: list[socket.socket]) -> None:
            assert sockets[0].getsockname()[0] == "0.0.0.0"

    def server(settings: Settings, *_: object, **__: object) -> Server:
        started.append(settings)
        return Server()

    monkeypatch.setattr("service.cli.commands.serve._server", server)
    with pytest.raises(Conflict, match="no token was created") as refused:
        serve_until_stopped("0.0.0.0", 0, Settings(database_url=url))
    assert "drumtrue token create" in (refused.value.advice or "")
    assert started == []
    token = ran("token", "create", "tablet", "--scope", "read", "--quiet", "--database-url", url).strip()
    serve_until_stopped("0.0.0.0", 0, Settings(database_url=url))
    assert not started[0].loopback
    with TestClient(create_app(started[0])) as client:
        assert client.get("/health").status_code == 200
        assert client.get("/api/v1/machines", headers={"host": "localhost"}).status_code == 401
        answer = client.get("/api/v1/machines", headers={"authorization": f"Bearer {token}"})
        assert (answer.status_code, answer.json()) == (200, [])
