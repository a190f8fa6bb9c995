"""`drumtrue verify`: status 0 where everything is as it was written, 1 and the session's name where it is not."""

from __future__ import annotations

import pytest

from service.cli.commands.verify import verify_history
from service.errors import InvalidInput
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
    with pytest.raises(InvalidInput, match="no entry of the chain"):
        verify_history(url, "7")
