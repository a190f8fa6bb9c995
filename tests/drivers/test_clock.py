from __future__ import annotations

import threading
from datetime import UTC, datetime, timedelta, timezone

import pytest

from drivers.clock import ManualClock, SystemClock
from drivers.errors import InvalidSetting

START = datetime(2026, 7, 1, 12, tzinfo=UTC)


def test_the_system_clock_tells_utc_and_does_not_run_back() -> None:
    clock = SystemClock()
    first, second = clock.now(), clock.now()
    assert first.utcoffset() == timedelta(0)
    assert second >= first


def test_the_system_clock_wakes_for_an_event_and_for_the_end_of_its_time() -> None:
    event = threading.Event()
    assert SystemClock().wait(event, 0.0) is False
    SystemClock().sleep(-1.0)
    event.set()
    assert SystemClock().wait(event, 3600.0) is True


def test_a_manual_clock_moves_only_when_told() -> None:
    clock = ManualClock(START)
    assert clock.now() == clock.now() == START
    clock.sleep(2.5)
    clock.sleep(-10.0)
    assert clock.now() == START + timedelta(seconds=2.5)
    clock.advance(-5.0)
    assert clock.now() == START - timedelta(seconds=2.5)


def test_a_manual_clock_does_not_wait_for_an_event_that_is_set() -> None:
    clock, event = ManualClock(START), threading.Event()
    assert clock.wait(event, 7.0) is False
    event.set()
    assert clock.wait(event, 7.0) is True
    assert clock.now() == START + timedelta(seconds=7.0)


def test_a_manual_clock_takes_any_zone_and_refuses_none() -> None:
    assert ManualClock(START.astimezone(timezone(timedelta(hours=2)))).now().utcoffset() == timedelta(0)
    with pytest.raises(InvalidSetting, match="has no time zone"):
        ManualClock(START.replace(tzinfo=None))
