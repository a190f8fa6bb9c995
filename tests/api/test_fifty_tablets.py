"""Fifty tablets and one box of two hundred pieces: over real HTTP, all at once, two hundred are fitted and no more."""

from __future__ import annotations

import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, TypeVar

import httpx2
import pytest
from sqlalchemy import inspect

from db.rows import Base, CorrectionRow, PlanRow, SessionRow
from service.app import PREFIX
from service.cli.commands.serve import serving
from service.runtime.context import require
from service.settings import Settings
from tests.support.http.workshop import Workshop, mass

Row = TypeVar("Row", bound=Base)

TABLETS = 50
PIECES = 200
EACH = 5
GRAMS = 100.0
PLACES = [("1", 20.0), ("1", 40.0), ("1", 60.0), ("2", 20.0), ("2", 40.0)]


def prepared(shop: Workshop) -> tuple[str, list[str]]:
    """The box, and for each tablet a session with a plan of five pieces; all but one are copies of the first."""
    box = shop.box(count=PIECES, masses=(GRAMS,))
    session = shop.session(box=box)
    masses = [mass("1", 300.0, 40.0), mass("2", 200.0, 20.0)]
    correction = shop.correct(session, source="balancer", masses=masses)
    key = shop.plan(session, correction, objective="components")["id"]
    plans = [str(key)]
    with shop.work.write() as store:
        plan = require(store, PlanRow, key)
        piece = plan.plan.placements[0]
        placements = tuple(replace(piece, plane=p, position_deg=at, hole=f"{at / 20:g}") for p, at in PLACES)
        plan.plan = replace(plan.plan, placements=placements)
        for tablet in range(1, TABLETS):
            here, there, own = f"session-{tablet}", f"correction-{tablet}", f"plan-{tablet}"
            opened = require(store, SessionRow, session)
            store.add(copied(opened, id=here, technician=f"Technician {tablet}"))
            store.add(copied(require(store, CorrectionRow, correction["id"]), id=there, session_id=here))
            asked = replace(plan.plan, id=own, session_id=here, correction_id=there)
            store.add(copied(plan, id=own, session_id=here, plan=asked))
            plans.append(own)
    return box, plans


def copied(row: Row, **changes: Any) -> Row:
    """A new row like this one."""
    return type(row)(**{column.key: getattr(row, column.key) for column in inspect(type(row)).columns} | changes)


def at_once(address: str, requests: list[tuple[str, dict[str, Any]]]) -> list[httpx2.Response]:
    """The answers to requests of as many tablets, all sent together."""
    start = threading.Barrier(len(requests))

    def one(request: tuple[str, dict[str, Any]]) -> httpx2.Response:
        with httpx2.Client(base_url=address + PREFIX, timeout=60.0, verify=False) as client:
            start.wait(timeout=60)
            return client.post(request[0], json=request[1])

    with ThreadPoolExecutor(len(requests)) as pool:
        return list(pool.map(one, requests))


@pytest.mark.parametrize("reserved", [False, True], ids=["fitted at once", "reserved at once, then fitted at once"])
def test_exactly_what_was_in_the_box_is_fitted(shop: Workshop, reserved: bool) -> None:
    box, plans = prepared(shop)
    url = shop.work.database.url.render_as_string(hide_password=False)
    with serving(Settings(database_url=url)) as address:
        held = at_once(address, [(f"/plans/{plan}/reserve", {}) for plan in plans]) if reserved else []
        answers = at_once(address, [(f"/plans/{plan}/fitted", {}) for plan in plans])
    statuses = Counter(answer.status_code for answer in answers)
    assert statuses == {200: PIECES // EACH, 409: TABLETS - PIECES // EACH}, [a.text for a in answers if a.is_error][:1]
    if reserved:
        assert Counter(answer.status_code for answer in held) == statuses
        assert [a.status_code for a in held] == [a.status_code for a in answers], "who holds five pieces fits them"
    for problem in (answer.json() for answer in (*held, *answers) if answer.status_code == 409):
        assert (problem["code"], problem["value"]) in (("out_of_stock", [GRAMS]), ("stock_reserved", [GRAMS]))
        assert f"{EACH} of {GRAMS:g} g needed" in problem["detail"]
        assert problem["advice"]
    assert shop.on_hand(box) == {GRAMS: 0}
    movements = shop.get(f"/catalogues/{box}/stock?limit=200")["movements"]
    assert sum(m["pieces"] for m in movements) == 0
    assert sum(m["held"] for m in movements) == 0
    fitted = [m for m in movements if m["kind"] == "fitted"]
    assert sum(m["pieces"] for m in fitted) == -PIECES
    assert len({m["session_id"] for m in fitted}) == len(fitted) == PIECES // EACH
