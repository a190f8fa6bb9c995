"""Notices: who waits hears of what is stored, here and in other processes, and of nothing that was rolled back."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import aclosing, closing, contextmanager
from datetime import UTC, datetime

import pytest
from sqlalchemy import text
from sqlalchemy.exc import IntegrityError

from db.database import Database
from db.rows import SourceRow
from drivers.reading import Reading
from service.runtime.change_feed import news
from service.usecases.readings.ingest import ingest
from service.usecases.readings.sources import bind
from tests.support.http.workshop import Workshop

SOON_S = 20.0
"""More than any notice takes on a busy machine; a test that waits so long has failed."""
NOON = datetime(2026, 3, 1, 12, tzinfo=UTC)


@contextmanager
def heard(database: Database, topic: str) -> Iterator[threading.Event]:
    """Whether something was heard of the topic."""
    event = threading.Event()
    with database.notices.waiting([topic], event.set):
        yield event


def listening(database: Database) -> None:
    """Return once the database listens: everybody is woken then, and later only by what is stored from now on."""
    with heard(database, "nobody's") as event:
        assert database.embedded or event.wait(SOON_S)


@contextmanager
def other_process(shop: Workshop) -> Iterator[Database]:
    """The same database as another process sees it: by an engine and connections of its own."""
    with closing(Database(shop.work.database.url.render_as_string(hide_password=False))) as opened:
        yield opened


def test_who_waits_for_a_machine_hears_of_what_is_stored_of_it(shop: Workshop) -> None:
    machine, other = shop.machine(), "another drum"
    listening(shop.work.database)
    with heard(shop.work.database, machine) as of_it, heard(shop.work.database, other) as of_the_other:
        bind(shop.work, "bridge", machine)
        assert of_it.is_set()
        assert not of_the_other.is_set()
    of_it.clear()
    bind(shop.work, "another bridge", machine)
    assert not of_it.is_set(), "heard after it had left"


def test_a_run_is_announced_to_its_session(shop: Workshop) -> None:
    session = shop.session()
    with heard(shop.work.database, session) as event:
        shop.run(session, "initial")
        assert event.is_set()


def test_readings_are_announced_though_no_row_is_mapped(shop: Workshop) -> None:
    machine = shop.machine()
    bind(shop.work, "bridge", machine)
    with heard(shop.work.database, machine) as event:
        ingest(shop.work, [Reading("bridge", 1, NOON, "P", 1.0, 0.0, 460.0)])
        assert event.is_set()


def test_nothing_is_heard_of_what_was_rolled_back(shop: Workshop) -> None:
    machine = shop.machine()
    listening(shop.work.database)

    def bind_twice() -> None:
        with shop.work.write() as store:
            store.add(SourceRow(name="bridge", machine_id=machine, bound_at=NOON))
            store.add(SourceRow(name="bridge", machine_id="none", bound_at=NOON))

    with heard(shop.work.database, machine) as event:
        with pytest.raises(IntegrityError):
            bind_twice()
        assert not event.is_set()
        bind(shop.work, "bridge", machine)
        assert event.is_set()


def test_other_processes_over_one_postgresql_hear_of_it(shop: Workshop) -> None:
    machine = shop.machine()
    with other_process(shop) as there, heard(there, machine) as event:
        if there.embedded:
            bind(shop.work, "bridge", machine)
            assert not event.is_set(), "an SQLite file tells nobody: who waits looks by himself from time to time"
            return
        assert event.wait(SOON_S), "everybody is woken when listening begins"
        event.clear()
        bind(shop.work, "bridge", machine)
        assert event.wait(SOON_S)


def test_a_listener_whose_connection_was_cut_listens_again(shop: Workshop) -> None:
    machine = shop.machine()
    with other_process(shop) as there, heard(there, machine) as event:
        if there.embedded:
            return
        assert event.wait(SOON_S)
        for attempt in range(2):
            event.clear()
            with shop.work.database.engine.connect() as connection:
                cut = "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE query LIKE 'LISTEN%'"
                assert connection.execute(text(cut)).scalar() == 1
            assert event.wait(SOON_S), "everybody is woken when listening begins again"
            event.clear()
            bind(shop.work, f"bridge {attempt}", machine)
            assert event.wait(SOON_S)


def test_news_comes_with_a_word_and_without_one(shop: Workshop) -> None:
    machine = shop.machine()

    async def turns() -> None:
        async with aclosing(news(shop.work, [machine], soonest_s=0.0, latest_s=SOON_S)) as of_it:
            turn = asyncio.ensure_future(anext(of_it))
            await asyncio.sleep(0)
            await asyncio.to_thread(bind, shop.work, "bridge", machine)
            await asyncio.wait_for(turn, SOON_S / 2)
        async with aclosing(news(shop.work, [machine], soonest_s=0.0, latest_s=0.01)) as of_nothing:
            await asyncio.wait_for(anext(of_nothing), SOON_S)

    asyncio.run(turns())
