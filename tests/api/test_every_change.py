"""Every operation that changes something leaves a line of history; every POST sent again under its key is done once.

Both are tried on each operation of the API document, on the walk that records the examples: who adds an operation adds
a step there, so none can be forgotten.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from typing import Any

import pytest

from db.database import Database
from db.queries import access
from service.app import PREFIX
from service.errors import InvalidInput
from service.model.machine import Catalogue, CatalogueItem
from service.runtime import idempotency
from service.runtime.context import AppContext
from service.runtime.idempotency import KEPT, Answer
from service.usecases.stock import catalogues
from tests.api.record_examples import Recorder, walk
from tests.api.test_openapi import operations
from tests.support.http.workshop import Workshop, application, box_body, machine_body, problem_of, workshop
from tests.support.storage.engines import Engine

CHANGES_NOTHING = frozenset(
    {
        "ask_what_if",
        "ask_arrangement_what_if",
        "check_design",
        "evaluate_design",
        "optimise_design",
        "trade_design_off",
        "stop_design_run",  # only asks: the run tells of its end itself
    }
)
"""Operations that are no GET and change nothing that has a history."""
METHODS = {
    operation["operationId"]: method.upper()
    for methods in application().openapi()["paths"].values()
    for method, operation in methods.items()
}
POSTS = sorted(name for name, method in METHODS.items() if method == "POST")
WRITES = sorted(name for name, method in METHODS.items() if method != "GET" and name not in CHANGES_NOTHING)


class Watched(Recorder):
    """Sends every POST twice under one key, and counts the lines of history that each request leaves."""

    def __init__(self, shop: Workshop) -> None:
        super().__init__(shop)
        self.told: dict[str, int] = {}
        self.repeated: dict[str, str] = {}
        self.keys = 0

    def ask(self, method: str, path: str, body: Any = None) -> Any:
        name = self.name(method, path)
        before = self.shop.count("audit")
        answer = self.twice(name, path, body) if method == "POST" else super().ask(method, path, body)
        if method != "GET":
            self.told[name] = self.told.get(name, 0) + self.shop.count("audit") - before
        return answer

    def twice(self, name: str, path: str, body: Any) -> Any:
        self.keys += 1
        client, headers = self.shop.client, {"idempotency-key": f"key-{self.keys}"}
        first = client.post(PREFIX + path, json=body, headers=headers)
        assert first.is_success, first.text
        if name == "start_design_run":  # its end is written by itself
            self.shop.work.background.wait(first.json()["id"])
        rows = self.shop.rows()
        again = client.post(PREFIX + path, json=body, headers=headers)
        other = client.post(f"{PREFIX}/catalogues", json=box_body(f"never {self.keys}"), headers=headers)
        same = (first.status_code, first.content) == (again.status_code, again.content)
        replayed = "idempotent-replayed" in again.headers and "idempotent-replayed" not in first.headers
        refused = problem_of(other, 422, "key_reused")["field"] == "Idempotency-Key"
        untouched = self.shop.rows() == rows
        if same and replayed and refused and untouched:
            self.repeated[name] = "done once"
        else:
            self.repeated[name] = f"{same=} {replayed=} {refused=} {untouched=}"
        return first.json()


@pytest.fixture(scope="module")
def watched(engine: Engine, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Watched]:
    """The walk, watched."""
    url = engine.migrated(tmp_path_factory.mktemp("walk"))
    with workshop(url) as shop:
        yield walk(Watched(shop))
    engine.drop(url)


@pytest.mark.parametrize("name", WRITES)
def test_every_change_leaves_a_line_of_history(watched: Watched, name: str) -> None:
    assert watched.told.get(name, 0) > 0, "no request of this operation left a line of history"


@pytest.mark.parametrize("name", sorted(CHANGES_NOTHING))
def test_what_changes_nothing_leaves_none(watched: Watched, name: str) -> None:
    assert watched.told[name] == 0


@pytest.mark.parametrize("name", POSTS)
def test_every_post_is_done_once_for_a_key(watched: Watched, name: str) -> None:
    assert watched.repeated[name] == "done once"


def test_every_post_says_that_it_takes_a_key() -> None:
    for name, operation in operations(application().openapi()):
        takes = any(p["name"] == "Idempotency-Key" for p in operation.get("parameters", ()))
        assert takes == (METHODS[name] == "POST"), name


def send(shop: Workshop, key: str, name: str = "one") -> Any:
    """A box, asked for under a key."""
    return shop.client.post(f"{PREFIX}/catalogues", json=box_body(name), headers={"idempotency-key": key})


def test_the_answer_under_a_key_is_the_answer_without(shop: Workshop) -> None:
    made = shop.client.post(f"{PREFIX}/machines", json=machine_body(), headers={"idempotency-key": "k"})
    assert made.json() == shop.get(f"/machines/{made.json()['id']}")
    assert made.headers["content-type"] == "application/json"


def test_what_was_refused_may_be_sent_again_under_its_key(shop: Workshop) -> None:
    taken = send(shop, "a").json()["id"]
    body = {"kind": "withdrawn", "pieces": [{"mass_g": 10.0, "pieces": 11}]}
    path, headers = f"{PREFIX}/catalogues/{taken}/stock", {"idempotency-key": "b"}
    problem_of(shop.client.post(path, json=body, headers=headers), 409, "out_of_stock")
    shop.post(f"/catalogues/{taken}/stock", {"kind": "received", "pieces": [{"mass_g": 10.0, "pieces": 1}]})
    assert shop.client.post(path, json=body, headers=headers).status_code == 201
    assert shop.client.post(path, json=body, headers=headers).headers["idempotent-replayed"] == "true"
    assert shop.on_hand(taken)[10.0] == 0


def test_a_key_ends_after_a_day_and_when_enough_came_after_it(shop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(access, "NEWEST_KEYS", 1)
    for key in ("a", "b", "c"):
        send(shop, key, key)
    shop.now.clock.advance(KEPT.total_seconds())
    assert send(shop, "a", "a").headers["idempotent-replayed"] == "true"
    assert send(shop, "d", "d").status_code == 201
    assert send(shop, "a", "again").status_code == 201
    assert shop.count("idempotency") == 2, "d, and a once more"


@pytest.mark.parametrize("by", [-400 * KEPT, -KEPT, 400 * KEPT])
def test_no_key_ends_early_because_the_clock_was_set(shop: Workshop, by: timedelta) -> None:
    send(shop, "before", "one")
    shop.now.clock.advance(by.total_seconds())
    made = send(shop, "meanwhile", "two")
    shop.now.clock.advance(-by.total_seconds())
    for key, name in (("before", "one"), ("meanwhile", "two")):
        assert send(shop, key, name).headers["idempotent-replayed"] == "true"
    assert send(shop, "meanwhile", "two").json() == made.json()
    assert shop.count("catalogue") == 2


def test_keys_belong_to_their_actor(shop: Workshop) -> None:
    def act(acting: AppContext) -> Answer:
        return Answer(200, acting.actor)

    for actor in ("tablet 1", "tablet 2", "tablet 1"):
        assert idempotency.answer(shop.work.acting(actor), "key", "request", act).body == actor
    assert shop.count("idempotency") == 2


@pytest.mark.parametrize("key", ["", "a" * 201, "two words", "µ"])
def test_a_key_that_is_none_is_refused(shop: Workshop, key: str) -> None:
    answer = shop.client.post(
        f"{PREFIX}/catalogues", json=box_body(), headers={b"idempotency-key": key.encode("latin-1")}
    )
    problem_of(answer, 422, "invalid_input")


def test_a_crash_before_the_answer_is_kept_undoes_the_change(shop: Workshop) -> None:
    def act(acting: AppContext) -> Answer:
        shop_box(acting)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        idempotency.answer(shop.work, "key", "request", act)
    assert (shop.count("catalogue"), shop.count("idempotency"), shop.count("audit")) == (0, 0, 0)


def shop_box(work: AppContext) -> str:
    """A box, made by the use case."""
    return catalogues.create(work, Catalogue(name="box", items=(CatalogueItem(mass_g=10.0, count=1),))).id


def test_two_requests_with_one_key_at_once_are_done_once(shop: Workshop) -> None:
    """Both have looked and found no answer kept before either goes on."""
    url = shop.work.database.url.render_as_string(hide_password=False)
    start = threading.Barrier(2)

    def one(_: int) -> Answer:
        database = Database(url)

        def act(acting: AppContext) -> Answer:
            start.wait(timeout=30)
            return Answer(201, shop_box(acting))

        try:
            return idempotency.answer(AppContext(database=database), "key", "request", act)
        finally:
            database.close()

    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(one, range(2)))
    assert len({answer.body for answer in answers}) == 1
    assert sorted(answer.replayed for answer in answers) == [False, True]
    assert shop.count("catalogue") == 1


def test_a_key_claimed_at_once_for_something_else_is_refused(shop: Workshop) -> None:
    def act(acting: AppContext) -> Answer:
        idempotency.answer(shop.work, "key", "first", lambda inner: Answer(200, shop_box(inner)))
        with acting.write():
            pass
        return Answer(200, "second")

    with pytest.raises(InvalidInput, match="another request"):
        idempotency.answer(shop.work, "key", "second", act)
