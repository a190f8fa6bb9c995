"""What the template of all drivers refuses, and how it lets go."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone

import pytest

from drivers.base import BaseDriver
from drivers.clock import SystemClock
from drivers.errors import BrokenSource, DriverClosed, InvalidSetting
from drivers.reading import Reading
from drivers.simulator.drum_driver import SimulatedDrum, threshing_drum_example

FIRST = Reading("list", 1, datetime(2026, 7, 1, tzinfo=UTC), "P", 1.0)


class ListDriver(BaseDriver):
    """A source with an end; None stands for the end of what it has."""

    def __init__(self, readings: Iterable[Reading], *, connects: bool = True) -> None:
        super().__init__("list")
        self.readings = iter(readings)
        self.connects = connects
        self.connected = 0
        self.closes_itself = False

    def _connect(self) -> None:
        if not self.connects:
            raise BrokenSource("nothing there")
        self.connected += 1

    def _disconnect(self) -> None:
        self.connected -= 1

    def _next(self) -> Reading | None:
        reading = next(self.readings, None)
        if self.closes_itself:
            self.close()
        return reading


def test_a_source_with_an_end_ends_and_keeps_open() -> None:
    with ListDriver([FIRST, replace(FIRST, sequence=5)]) as driver:
        assert [one.sequence for one in driver] == [1, 5]
        assert list(driver) == []
        assert driver.health().state == "open"


@pytest.mark.parametrize("sequence", [1, 0, -3])
def test_a_sequence_number_used_before_is_not_delivered(sequence: int) -> None:
    with ListDriver([FIRST, replace(FIRST, sequence=sequence)]) as driver:
        readings = iter(driver)
        next(readings)
        with pytest.raises(BrokenSource, match=f"gave sequence {sequence} after 1"):
            next(readings)
        assert driver.health().delivered == 1


@pytest.mark.parametrize("zone", [None, timezone(timedelta(hours=2))])
def test_a_time_that_is_not_utc_is_not_delivered(zone: timezone | None) -> None:
    moment = FIRST.taken_at.replace(tzinfo=zone)
    with ListDriver([replace(FIRST, taken_at=moment)]) as driver, pytest.raises(BrokenSource, match="state it in UTC"):
        next(iter(driver))


def test_a_reading_that_arrives_while_closing_is_not_delivered() -> None:
    with ListDriver([FIRST, replace(FIRST, sequence=2)]) as driver:
        readings = iter(driver)
        next(readings)
        driver.closes_itself = True
        assert list(readings) == []
    assert driver.health().delivered == 1


def test_what_was_connected_is_disconnected_once() -> None:
    driver = ListDriver([])
    for _ in range(2):
        with driver:
            assert driver.connected == 1
        driver.close()
        assert driver.connected == 0


def test_a_source_that_cannot_be_reached_leaves_the_driver_closed() -> None:
    driver = ListDriver([], connects=False)
    with pytest.raises(BrokenSource):
        driver.open()
    assert driver.health().state == "closed"
    with pytest.raises(DriverClosed):
        iter(driver)
    driver.close()


def test_a_source_needs_a_name() -> None:
    with pytest.raises(InvalidSetting, match="empty name"):
        SimulatedDrum(threshing_drum_example(), seed=1, clock=SystemClock(), source="")


def test_closing_wakes_a_reader_that_waits_in_another_thread() -> None:
    drum = SimulatedDrum(threshing_drum_example(), seed=1, clock=SystemClock(), interval_s=3600.0)
    taken: list[Reading] = []
    first_round = threading.Event()

    def read() -> None:
        for reading in drum:
            taken.append(reading)
            if len(taken) == 2:
                first_round.set()

    drum.open()
    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    assert first_round.wait(10.0)
    drum.close()
    reader.join(10.0)
    assert not reader.is_alive()
    assert [one.sensor for one in taken] == ["P", "Q"]
