"""What every driver keeps, as tests: subclass `DriverContract` and give it a factory."""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import timedelta
from itertools import islice, pairwise

import pytest

from drivers.errors import DriverClosed
from drivers.protocol import Driver
from drivers.reading import Reading

SOME = 12
"""Readings that each driver under test can give at least, without waiting on the wall clock."""


class DriverContract:
    """Subclasses write `make_driver`: a new, closed driver that can give `SOME` readings."""

    def make_driver(self) -> Driver:
        raise NotImplementedError

    @pytest.fixture
    def driver(self) -> Iterator[Driver]:
        driver = self.make_driver()
        yield driver
        driver.close()

    def test_it_starts_closed_and_empty(self, driver: Driver) -> None:
        health = driver.health()
        assert (health.state, health.delivered, health.refused, health.missed) == ("closed", 0, 0, 0)
        assert health.last_taken_at is None

    def test_reading_a_closed_driver_is_refused_at_once(self, driver: Driver) -> None:
        with pytest.raises(DriverClosed):
            iter(driver)
        with driver:
            pass
        with pytest.raises(DriverClosed):
            iter(driver)

    def test_opening_twice_is_refused_and_leaves_it_open(self, driver: Driver) -> None:
        with driver:
            with pytest.raises(DriverClosed):
                driver.open()
            assert driver.health().state == "open"
            assert next(iter(driver)).source == driver.source

    def test_closing_twice_is_harmless(self, driver: Driver) -> None:
        driver.close()
        driver.open()
        driver.close()
        driver.close()
        assert driver.health().state == "closed"

    def test_an_error_inside_the_block_closes_it_and_passes_on(self, driver: Driver) -> None:
        with pytest.raises(ZeroDivisionError), driver:
            raise ZeroDivisionError
        assert driver.health().state == "closed"

    def test_closing_during_iteration_ends_it(self, driver: Driver) -> None:
        driver.open()
        readings = iter(driver)
        next(readings)
        driver.close()
        assert list(readings) == []

    def test_each_reading_is_a_valid_one(self, driver: Driver) -> None:
        for reading in some(driver):
            assert isinstance(reading, Reading)
            assert reading.source == driver.source != ""
            assert reading.sensor != ""
            assert math.isfinite(reading.amplitude)
            assert reading.amplitude >= 0.0
            assert reading.phase_deg is None or 0.0 <= reading.phase_deg < 360.0
            assert reading.speed_rpm is None or reading.speed_rpm > 0.0
            assert reading.scatter is None or reading.scatter > 0.0

    def test_sequences_strictly_increase(self, driver: Driver) -> None:
        sequences = [reading.sequence for reading in some(driver)]
        assert all(later > earlier for earlier, later in pairwise(sequences))

    def test_times_are_utc_and_never_go_back(self, driver: Driver) -> None:
        times = [reading.taken_at for reading in some(driver)]
        assert all(moment.utcoffset() == timedelta(0) for moment in times)
        assert times == sorted(times)

    def test_a_second_iteration_goes_on_where_the_first_stopped(self, driver: Driver) -> None:
        with driver:
            first = list(islice(driver, 3))
            second = list(islice(driver, 3))
        assert second[0].sequence > first[-1].sequence
        assert second[0].taken_at >= first[-1].taken_at

    def test_sequences_increase_over_opening_again(self, driver: Driver) -> None:
        first = some(driver, 3)
        with driver:
            again = list(islice(driver, 1))
        assert all(reading.sequence > first[-1].sequence for reading in again)

    def test_the_counters_count(self, driver: Driver) -> None:
        readings = some(driver)
        health = driver.health()
        assert health.delivered == len(readings) == SOME
        assert health.refused == 0
        assert health.last_taken_at == readings[-1].taken_at


def some(driver: Driver, count: int = SOME) -> list[Reading]:
    """Open, take so many readings, close."""
    with driver:
        return list(islice(driver, count))
