"""Two tablets at once, on one database: what is taken is taken once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from db.database import Database
from drivers.reading import Reading
from service.errors import Conflict
from service.model.plan import FittedRequest
from service.model.run import RunReading, RunRequest
from service.runtime.context import AppContext
from service.usecases.plans import plans
from service.usecases.readings import ingest
from service.usecases.sessions import runs
from tests.support.http.workshop import DRUM, Workshop

TABLETS = 6


def at_once(shop: Workshop, steps: list[Callable[[AppContext], object]]) -> list[object]:
    """What each step answers or raises, all begun together, each with connections of its own."""
    start = threading.Barrier(len(steps))

    def one(step: Callable[[AppContext], object]) -> object:
        database = Database(shop.work.database.url.render_as_string(hide_password=False))
        start.wait(timeout=30)
        try:
            return step(AppContext(database=database))
        except Conflict as refused:
            return refused.code
        finally:
            database.close()

    with ThreadPoolExecutor(len(steps)) as pool:
        return list(pool.map(one, steps))


def fitting(plan_id: str) -> Callable[[AppContext], object]:
    """Report this plan fitted."""
    return lambda work: plans.fitted(work, plan_id, FittedRequest()).state


def test_the_last_piece_is_fitted_by_exactly_one(shop: Workshop) -> None:
    machine, box = shop.machine(), shop.box(count=1)
    proposed = [shop.planned(shop.session(machine, box)) for _ in range(TABLETS)]
    pieces = len(proposed[0]["placements"])
    ended = at_once(shop, [fitting(plan["id"]) for plan in proposed])
    assert sorted(map(str, ended)) == ["fitted"] + ["out_of_stock"] * (TABLETS - 1)
    assert sum(shop.on_hand(box).values()) == 6 - pieces
    assert min(shop.on_hand(box).values()) == 0
    assert [shop.get(f"/plans/{p['id']}")["state"] for p in proposed].count("fitted") == 1


def test_one_plan_is_fitted_once_however_many_press_the_button(shop: Workshop) -> None:
    box = shop.box(count=10)
    plan = shop.planned(shop.session(box=box))
    ended = at_once(shop, [fitting(plan["id"])] * TABLETS)
    assert sorted(map(str, ended)) == ["fitted"] + ["plan_fitted"] * (TABLETS - 1)
    assert sum(shop.on_hand(box).values()) == 60 - len(plan["placements"])


def test_runs_sent_at_once_are_numbered_one_by_one(shop: Workshop) -> None:
    session = shop.session()
    said = tuple(RunReading(**reading) for reading in DRUM.readings())
    request = RunRequest(kind="initial", readings=said)
    at_once(shop, [lambda work: runs.add(work, session, request)] * TABLETS)
    assert [run["number"] for run in shop.get(f"/sessions/{session}")["runs"]] == list(range(1, TABLETS + 1))


def test_a_batch_sent_twice_at_once_is_stored_once(shop: Workshop) -> None:
    shop.ask("PUT", "/sources/bridge", {"machine_id": shop.machine()})
    moment = shop.now()
    batch = [Reading("bridge", n, moment, "P", 1.0) for n in range(200)]
    receipts = at_once(shop, [lambda work: ingest.ingest(work, batch).accepted] * TABLETS)
    assert sorted(map(str, receipts)) == ["0"] * (TABLETS - 1) + ["200"]
    assert shop.count("reading") == 200
