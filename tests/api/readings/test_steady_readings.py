"""Whatever a source says, steady or coarse: a run that was taken from it is read, listed, exported, closed."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from db.database import Database
from service.runtime.context import AppContext
from service.usecases.sessions.log_import import import_one, read_whole_log
from tests.support.http.workshop import Workshop, work_over
from tests.support.storage.engines import Engine

NOON = datetime(2020, 3, 1, 12, tzinfo=UTC)
SIZES = st.floats(1e-9, 1e9, allow_nan=False) | st.floats(0.01, 20.0).map(lambda value: round(value, 2)) | st.just(0.0)
PHASES = st.none() | st.floats(-360.0, 360.0) | st.integers(-360, 360).map(float)
STEPS = st.sampled_from([0.0, 0.01, 0.0078125, 0.1, 1.0])
_sequences = itertools.count(1)
_days = itertools.count()


@st.composite
def steady(draw: st.DrawFn) -> list[tuple[float, float | None]]:
    """2 to 60 readings of one sensor: all the same, or a few steps around a value."""
    count, size, phase, step = draw(st.integers(2, 60)), draw(SIZES), draw(PHASES), draw(STEPS)
    moves = draw(st.lists(st.integers(-2, 2), min_size=count, max_size=count)) if step else [0] * count
    return [(min(max(round(size / (step or 1.0)) * step + m * step, 0.0), 1e9) if step else size, phase) for m in moves]


def sent(shop: Workshop, machine: str, readings: Sequence[tuple[float, float | None]]) -> dict[str, Any]:
    """What to take, once the readings are stored: a day of their own of a source of the machine."""
    source, day = f"source of {machine}", NOON + timedelta(days=next(_days))
    shop.ask("PUT", f"/sources/{source}", {"machine_id": machine})
    moments = [(day + timedelta(seconds=place)).isoformat() for place in range(len(readings))]
    shop.post(
        "/readings",
        [
            {
                "source": source,
                "sequence": next(_sequences),
                "taken_at": at,
                "sensor": "P",
                "amplitude": size,
                "phase_deg": phase,
            }
            for at, (size, phase) in zip(moments, readings, strict=True)
        ],
    )
    return {"source": source, "from": moments[0], "to": moments[-1]}


@pytest.fixture(scope="module")
def elsewhere(engine: Engine, tmp_path_factory: pytest.TempPathFactory) -> Iterator[AppContext]:
    """Another service's storage."""
    url = engine.migrated(tmp_path_factory.mktemp("elsewhere"))
    work = work_over(Database(url))
    yield work
    work.database.close()
    engine.drop(url)


def test_a_run_of_any_steady_readings_is_read_and_exported_and_closed(
    shared_shop: Workshop, elsewhere: AppContext
) -> None:
    shop = shared_shop
    machine, box = shop.machine(), shop.box()

    @settings(max_examples=40)
    @given(readings=steady())
    def holds(readings: list[tuple[float, float | None]]) -> None:
        session = shop.session(machine, box)
        run = shop.post(f"/sessions/{session}/runs", {"kind": "initial", "take": sent(shop, machine, readings)})
        (stored,) = run["readings"]
        assert stored["scatter"] is None or stored["scatter"] >= 1e-12 * stored["amplitude"]
        assert shop.get(f"/sessions/{session}")["runs"] == [run]
        shop.ask("PATCH", f"/sessions/{session}/runs/{run['id']}", {"excluded": True, "reason": "tried"})
        assert shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})["unreadable"] == []
        shop.get(f"/sessions/{session}/report.json")
        log = read_whole_log(json.dumps(shop.get(f"/sessions/{session}/log")))
        assert import_one(elsewhere, log).runs == log.runs

    holds()


@pytest.mark.parametrize("step", [0.1, 0.05, 0.0078125])
def test_the_scatter_of_coarse_readings_is_at_least_what_their_step_leaves_unknown(shop: Workshop, step: float) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    earlier = [(step * k, 0.0) for k in (70, 71, 73, 72, 71, 75)]
    sent(shop, machine, earlier)
    take = sent(shop, machine, [(step * 72, 0.0)] * 20)
    (stored,) = shop.post(f"/sessions/{session}/runs", {"kind": "initial", "take": take})["readings"]
    assert stored["scatter"] >= step / math.sqrt(12) * (1 - 1e-9)
    assert stored["scatter"] < max(step, 7.0 * math.radians(1.0))


def test_a_scatter_is_stated_of_noise_as_before(shop: Workshop) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    take = sent(shop, machine, [(3.0 + 0.01 * math.sin(7.0 * k), 30.0 + 0.1 * math.sin(3.0 * k)) for k in range(40)])
    (stored,) = shop.post(f"/sessions/{session}/runs", {"kind": "initial", "take": take})["readings"]
    assert stored["scatter"] == pytest.approx(0.0063 / math.sqrt(40), rel=0.1)


def test_json_of_the_log_has_no_scatter_below_its_rule(shop: Workshop) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    take = sent(shop, machine, [(3.0, 37.0)] * 5)
    shop.post(f"/sessions/{session}/runs", {"kind": "initial", "take": take})
    assert "e-1" not in json.dumps(shop.get(f"/sessions/{session}/log")["runs"])
