"""Raw readings grow old: one row a minute is left of them, and runs keep what they took."""

from __future__ import annotations

import cmath
import math
from datetime import timedelta
from typing import Any

import pytest
from sqlalchemy import select

from db.rows import ReadingMinuteRow
from service.errors import InvalidInput
from service.usecases.audit import verify
from service.usecases.readings import ingest
from service.usecases.readings.retention import retain
from tests.api.readings.test_readings import NOON, arrival, at, take
from tests.support.http.workshop import Workshop

VECTORS = [1.0 + 1.0j, 2.0 + 0.5j, 1.5 - 0.5j]


@pytest.fixture
def machine(shop: Workshop) -> str:
    """A machine with a bridge, and three minutes of readings from long ago."""
    stored = shop.machine()
    shop.ask("PUT", "/sources/bridge", {"machine_id": stored})
    batch = [arrival(n, v, speed_rpm=460.0 + n) for n, v in enumerate(VECTORS)]
    batch += [arrival(3, 4.0 + 0j, "Q", scatter=0.3), {**arrival(70), "phase_deg": None}, arrival(150)]
    shop.post("/readings", batch)
    return stored


def minutes(shop: Workshop) -> list[dict[str, Any]]:
    """What is left, in order."""
    table = ReadingMinuteRow.__table__
    with shop.work.database.engine.connect() as connection:
        found = connection.execute(select(table).order_by(table.c.minute, table.c.sensor)).mappings().all()
    return [dict(row) for row in found]


def later(shop: Workshop, days: float) -> None:
    """So many days go by."""
    shop.now.clock.advance(timedelta(days=days).total_seconds())


def test_a_minute_is_its_mean_vector(shop: Workshop, machine: str) -> None:
    later(shop, 400)
    done = retain(shop.work, 30)
    assert (done.readings, done.minutes) == (6, 4)
    assert shop.count("reading") == 0
    first, second, *_ = minutes(shop)
    assert (first["sensor"], first["readings"], first["last_sequence"]) == ("P", 3, 2)
    mean = sum(VECTORS) / 3
    assert cmath.rect(first["amplitude"], math.radians(first["phase_deg"])) == pytest.approx(mean)
    assert first["scatter"] == pytest.approx(math.sqrt(sum(abs(v - mean) ** 2 for v in VECTORS) / 4))
    assert first["speed_rpm"] == pytest.approx(461.0)
    assert (second["sensor"], second["amplitude"], second["scatter"]) == ("Q", 4.0, 0.3)
    assert [row["phase_deg"] is None for row in minutes(shop)] == [False, False, True, False]


def test_young_readings_stay_and_again_changes_nothing(shop: Workshop, machine: str) -> None:
    assert retain(shop.work, 100_000).readings == 0
    assert shop.count("reading") == 6
    later(shop, 400)
    assert retain(shop.work, 30, lambda: True).readings == 0
    assert shop.count("reading") == 6
    assert retain(shop.work, 30).readings == 6
    assert retain(shop.work, 30).readings == 0
    assert len(minutes(shop)) == 4


def test_lines_of_history_go_with_the_readings_they_tell_of_and_the_chain_stays(shop: Workshop, machine: str) -> None:
    def told(action: str) -> list[Any]:
        kind = "reading" if action == "sent" else "source"
        return [one for one in shop.get(f"/history?kind={kind}") if one["action"] == action]

    later(shop, 400)
    shop.post("/readings", arrival(500))
    assert [one["changes"]["last_sequence"] for one in told("sent")] == [500, 150]
    retain(shop.work, 30)
    assert [one["changes"]["last_sequence"] for one in told("sent")] == [500], "an old reading, but sent today"
    assert told("changed")[0]["changes"]["readings"] == [7, 0]
    assert not verify(shop.work).findings


def test_a_run_keeps_what_it_took_and_none_is_taken_any_more(shop: Workshop, machine: str) -> None:
    session = shop.session(machine)
    took = take(shop, session)
    later(shop, 400)
    retain(shop.work, 30)
    assert shop.get(f"/sessions/{session}")["runs"][0]["readings"] == took
    body = {"kind": "initial", "take": {"source": "bridge", "from": NOON, "to": at(60)}}
    problem = shop.refused("POST", f"/sessions/{session}/runs", body, 409, "readings_rolled_up")
    assert "rolled up" in problem["detail"]


def test_a_source_counts_on_from_what_was_removed(shop: Workshop, machine: str) -> None:
    later(shop, 400)
    retain(shop.work, 30)
    assert ingest.highest_sequence(shop.work, "bridge") == 150


def test_no_days_are_refused(shop: Workshop) -> None:
    with pytest.raises(InvalidInput, match="for at least 1 day"):
        retain(shop.work, 0)
