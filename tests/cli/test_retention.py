"""Old readings are rolled up beside the service: at once, daily, again after an hour where it failed, until stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from service.cli.support import retention as command
from service.cli.support.retention import AGAIN_S, DAY_S, daily, rolling_up
from service.runtime.context import AppContext
from service.usecases.readings import retention
from tests.api.readings.test_readings import arrival
from tests.support.http.workshop import Workshop


def test_it_is_done_daily_and_sooner_after_a_failure(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    retain, pauses = retention.retain, list[float]()

    def broken(work: AppContext, days: int, stopped: Callable[[], bool]) -> object:
        raise OSError("the database is away")

    def wait(seconds: float) -> bool:
        pauses.append(seconds)
        shop.now.clock.advance(seconds)
        monkeypatch.setattr(retention, "retain", broken if len(pauses) == 2 else retain)
        return len(pauses) == 4

    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    shop.post("/readings", {**arrival(1), "taken_at": shop.now().isoformat()})
    daily(shop.work.acting("retention"), 2, wait, lambda: False)
    assert pauses == [DAY_S, DAY_S, AGAIN_S, DAY_S]
    assert (shop.count("reading"), shop.count("reading_minute")) == (0, 1)
    assert shop.get("/history?limit=1")[0]["actor"] == "retention"


def test_it_runs_for_the_length_of_a_block_if_at_all(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = threading.Event()

    def noted(work: AppContext, days: int, wait: Callable[[float], bool], stopped: Callable[[], bool]) -> None:
        begun.set()
        while not wait(DAY_S):
            raise AssertionError("a day has passed")
        assert stopped()

    monkeypatch.setattr(command, "daily", noted)
    with rolling_up(shop.work, None):
        assert not begun.is_set()
    with rolling_up(shop.work, 30):
        assert begun.wait(30)
    assert not [one for one in threading.enumerate() if one.name == "retention"]
