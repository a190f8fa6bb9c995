"""Units of work, times and documents as they are stored."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import pytest
from sqlalchemy.exc import IntegrityError, StatementError

from db.rows import CatalogueRow, SourceRow
from tests.api.workshop import Workshop

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
