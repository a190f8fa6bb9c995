"""`serve --can`: whatever ends the reader of a bus, it is started again, and its state is told."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from drivers.bridge.bridge import Bridge
from drivers.bridge.delivery import Backoff
from drivers.can.bus import BusAddress
from drivers.can.mapping_file import standard_mapping
from service import bootstrap
from service.cli.commands.bridge import BusChoice
from service.cli.commands.can_listener import CanListener, listening
from service.settings import Settings


def test_a_reader_that_ends_is_started_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs, again, run = [0], threading.Event(), Bridge.run

    def failing(bridge: Bridge) -> object:
        runs[0] += 1
        if runs[0] < 4:
            raise RuntimeError("the spool is gone")
        again.set()
        return run(bridge)

    monkeypatch.setattr(Bridge, "run", failing)
    pause: Callable[[Backoff], float] = lambda _: 0.0  # noqa: E731
    monkeypatch.setattr(Backoff, "next_s", pause)
    settings = Settings(database_url=f"sqlite:///{tmp_path / 'a.db'}")
    work = bootstrap.build_work(settings)
    with closing(work.database):
        ear = CanListener(
            BusChoice(BusAddress("virtual", "listened"), standard_mapping(("P",))), "shed", tmp_path / "s.db"
        )
        with listening(work, ear):
            assert again.wait(20.0)
            (state,) = work.listeners.states()
            assert (state.source, state.restarts, state.state, state.reason) == ("shed", 3, "listening", None)
        assert work.listeners.states() == ()
