"""Units of work, times and documents as they are stored."""

from __future__ import annotations

import threading
from contextlib import suppress
from datetime import UTC, datetime, timedelta, timezone

import pytest
from sqlalchemy.exc import IntegrityError, StatementError

from db.database import Database, Undone
from db.rows import CatalogueRow, SourceRow
from tests.support.http.workshop import Workshop

NOON = datetime(2026, 3, 1, 12, tzinfo=UTC)


def box(key: str = "box", name: str = "box", at: datetime = NOON) -> CatalogueRow:
    """A box without anything in it."""
    return CatalogueRow(id=key, name=name, items=(), created_at=at)


def test_a_unit_of_work_is_stored_whole_or_not_at_all(shop: Workshop) -> None:
    def store_and_fail() -> None:
        with shop.work.write() as store:
            store.add(box())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        store_and_fail()
    assert shop.count("catalogue") == 0
    with shop.work.write() as store:
        store.add(box())
    assert shop.count("catalogue") == 1


def test_a_refusal_that_is_passed_over_is_told_and_nothing_stored(shop: Workshop) -> None:
    def pass_over() -> None:
        with shop.work.write() as store:
            store.add(box("there"))
            with suppress(IntegrityError):
                store.add(SourceRow(name="bridge", machine_id="there", bound_at=NOON))

    with pytest.raises(Undone, match="nothing was stored"):
        pass_over()
    assert (shop.count("catalogue"), shop.count("audit")) == (0, 0)


def test_a_part_that_is_refused_is_undone_by_itself_and_the_rest_stored_and_told(shop: Workshop) -> None:
    machine = shop.machine()
    with shop.work.database.notices.waiting([machine], (heard := threading.Event()).set), shop.work.write() as store:
        store.add(SourceRow(name="bridge", machine_id=machine, bound_at=NOON))
        with suppress(IntegrityError), store.part():
            store.add(SourceRow(name="other", machine_id="none", bound_at=NOON))
    assert heard.is_set()
    with shop.work.read() as store:
        assert [row.name for row in store.sources()] == ["bridge"]
        assert [entry.key for entry in store.history(10, 0, kind="source")] == ["bridge"], (
            "history of what is not there"
        )


def test_reading_stores_nothing(shop: Workshop) -> None:
    with shop.work.read() as store:
        store.add(box())
    assert shop.count("catalogue") == 0


def test_names_are_given_once(shop: Workshop) -> None:
    with shop.work.write() as store:
        store.add(box())
    with pytest.raises(IntegrityError), shop.work.write() as store:
        store.add(box("other"))


def test_references_are_kept(shop: Workshop) -> None:
    with pytest.raises(IntegrityError), shop.work.write() as store:
        store.add(SourceRow(name="bridge", machine_id="none", bound_at=NOON))


def test_times_come_back_in_utc_whatever_their_zone(shop: Workshop) -> None:
    there = NOON.astimezone(timezone(timedelta(hours=5, minutes=30))) + timedelta(microseconds=1)
    with shop.work.write() as store:
        store.add(box(at=there))
    with shop.work.read() as store:
        found = store.get(CatalogueRow, "box")
        assert found is not None
        assert (found.created_at, found.created_at.tzinfo) == (there, UTC)


def test_a_time_without_a_zone_is_refused(shop: Workshop) -> None:
    with pytest.raises(StatementError, match="no zone"), shop.work.write() as store:
        store.add(box(at=NOON.replace(tzinfo=None)))


def test_a_connection_that_is_in_use_is_closed_once_it_is_handed_back(url: str) -> None:
    database = Database(url)
    held = database.engine.connect()
    raw = held.connection.dbapi_connection
    assert raw is not None
    database.close()
    held.close()
    with pytest.raises(Exception, match=r"closed"):
        raw.cursor().execute("SELECT 1")
