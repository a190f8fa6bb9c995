"""`drumtrue verify`: status 0 where everything is as it was written, 1 and the session's name where it is not."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from service.cli.commands.verify import verify_history
from service.cli.support.heads import Heads, key_from
from service.errors import Conflict, InvalidInput
from tests.support.http.workshop import Workshop


def test_it_names_the_session_that_was_altered(shop: Workshop, capsys: pytest.CaptureFixture[str]) -> None:
    url = shop.work.database.url.render_as_string(hide_password=False)
    session = shop.session(technician="A")
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    assert verify_history(url, None) == 0
    printed = capsys.readouterr().out
    assert "1 closed sessions" in printed
    head = printed.partition("head ")[2].split()[0]
    assert verify_history(url, head) == 0
    with shop.work.database.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE session SET technician = 'B'")
    capsys.readouterr()
    assert verify_history(url, head) == 1
    assert f"session {session} was altered" in capsys.readouterr().out


def test_a_head_that_is_none_is_told(shop: Workshop) -> None:
    url = shop.work.database.url.render_as_string(hide_password=False)
    with pytest.raises(InvalidInput, match="must be an entry of the chain"):
        verify_history(url, "7")


def test_a_file_of_heads_shows_that_the_end_was_cut_off(shop: Workshop, tmp_path: Path) -> None:
    url = shop.work.database.url.render_as_string(hide_password=False)
    heads = Heads(tmp_path / "heads.txt", b"k" * 32)
    for _ in range(2):
        shop.session()
        assert verify_history(url, None, heads) == 0
    assert len(heads.path.read_text().splitlines()) == 2
    with shop.work.database.engine.begin() as connection:
        connection.exec_driver_sql("DELETE FROM session WHERE created_at = (SELECT max(created_at) FROM session)")
        connection.exec_driver_sql("DELETE FROM audit WHERE number = (SELECT max(number) FROM audit)")
    assert verify_history(url, None) == 0
    assert verify_history(url, None, heads) == 1
    assert len(heads.path.read_text().splitlines()) == 2, "no head of what is wrong"
    heads.path.write_text(heads.path.read_text().replace("2", "3", 1))
    with pytest.raises(Conflict) as refused:
        verify_history(url, None, heads)
    assert refused.value.code == "head_forged"


def test_a_short_key_and_a_file_that_is_none_are_refused(tmp_path: Path) -> None:
    (tmp_path / "key").write_text("short")
    with pytest.raises(InvalidInput, match="at least 32"):
        key_from(tmp_path / "key")
    with pytest.raises(InvalidInput, match="cannot be read"):
        Heads(tmp_path).last()
    with pytest.raises(InvalidInput, match="cannot be written"):
        Heads(tmp_path / "no" / "folder").append("1:a", datetime(2026, 1, 1, tzinfo=UTC))
