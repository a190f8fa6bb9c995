"""What a listening service stores past its spool: readings, answers and their mark together, or nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sqlalchemy.exc import OperationalError

from drivers.errors import DeliveryFailed, DeliveryRefused
from drivers.reading import Answer, Counter, Mark
from service.usecases.readings.local_delivery import IntoDatabase, last_mark
from tests.support.drivers.frames import START, readings
from tests.support.http.workshop import Workshop

SENSOR = dict(zip(sorted({one.sensor for one in readings(4)}), "PQ", strict=False))
SOME = [replace(one, sensor=SENSOR[one.sensor]) for one in readings(20)]
ANSWER = Answer("can", 3, START, (("1", 12.5, 80.0),))


def mark(number: int) -> Mark:
    return Mark("can", number, (Counter("Sensor1", 250 + number, START, 0.01), Counter("Speed", number, START, None)))


@pytest.fixture
def way(shop: Workshop) -> IntoDatabase:
    """The way into the database of a service that knows the source."""
    shop.ask("PUT", "/sources/can", {"machine_id": shop.machine()})
    return IntoDatabase(shop.work)


def test_entries_and_mark_are_stored_together_and_once(shop: Workshop, way: IntoDatabase) -> None:
    assert last_mark(shop.work, "can") is None
    way.store([*SOME[:10], ANSWER], mark(1))
    way.store([*SOME[5:], ANSWER], mark(2))
    way.store([], mark(3))
    way.store(SOME, None)
    assert (shop.count("reading"), shop.count("balancer_answer"), shop.count("source_mark")) == (20, 1, 1)
    assert last_mark(shop.work, "can") == mark(3)
    assert last_mark(shop.work, "another") is None


@pytest.mark.parametrize(
    "spoilt",
    [replace(SOME[-1], sensor="X"), replace(SOME[-1], source="unbound"), Answer("can", 4, START, (("9", 1.0, 0.0),))],
    ids=["unknown sensor", "unbound source", "unknown plane"],
)
def test_what_is_refused_takes_all_of_its_batch_with_it(shop: Workshop, way: IntoDatabase, spoilt: Answer) -> None:
    way.store(SOME[:5], mark(1))
    with pytest.raises(DeliveryRefused, match="what to do"):
        way.store([*SOME[5:19], spoilt], mark(2))
    assert (shop.count("reading"), shop.count("balancer_answer")) == (5, 0)
    assert last_mark(shop.work, "can") == mark(1)


def test_a_database_that_is_away_says_so(shop: Workshop, way: IntoDatabase, monkeypatch: pytest.MonkeyPatch) -> None:
    def away(*_: object) -> None:
        raise OperationalError("BEGIN", None, Exception("database is locked"))

    monkeypatch.setattr(type(shop.work.database), "write", away)
    with pytest.raises(DeliveryFailed, match="does not take them now"):
        way.store(SOME, mark(1))
