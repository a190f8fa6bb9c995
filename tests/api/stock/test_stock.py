"""The ledger of a box: what is held for a plan nobody else can have, and the balances are the sum of the movements."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from sqlalchemy.exc import IntegrityError

from service.model.stock import ReserveRequest
from service.runtime.context import AppContext
from service.usecases.plans import reservations
from tests.api.test_two_tablets import at_once, fitting
from tests.support.http.workshop import Workshop, workshop

HOUR_S = 3600.0


def stock(shop: Workshop, box: str) -> Any:
    """Balances, holds and movements."""
    return shop.get(f"/catalogues/{box}/stock?limit=200")


def balances(shop: Workshop, box: str, mass_g: float) -> tuple[int, int, int]:
    """On hand, reserved, available."""
    item = next(item for item in stock(shop, box)["items"] if item["mass_g"] == mass_g)
    return item["on_hand"], item["reserved"], item["available"]


def reserve(shop: Workshop, plan: Any, minutes: int = 60) -> Any:
    """The plan, its pieces held."""
    return shop.post(f"/plans/{plan['id']}/reserve", {"minutes": minutes})


def contested(shop: Workshop, count: int = 1) -> tuple[str, list[Any]]:
    """A box and two plans of two sessions that want the same last pieces."""
    machine, box = shop.machine(), shop.box(count=count)
    sessions = [shop.session(machine, box, technician=f"Technician {n}") for n in (1, 2)]
    plans = [shop.planned(session) for session in sessions]
    assert plans[0]["placements"] == plans[1]["placements"]
    return box, plans


def taken(plan: Any) -> Counter[float]:
    """Pieces of each mass that a plan takes."""
    return Counter(p["mass_g"] for p in plan["placements"])


def test_what_is_held_for_a_plan_nobody_else_can_fit(shop: Workshop) -> None:
    box, (first, second) = contested(shop)
    held = reserve(shop, first)
    problem = shop.refused("POST", f"/plans/{second['id']}/fitted", {}, 409, "stock_reserved")
    mass_g = min(taken(second))
    assert problem["value"] == sorted(taken(second))
    for told in (f"1 of {mass_g:g} g", "held by Technician 1", first["session_id"], held["reserved_until"][:19]):
        assert told in problem["detail"]
    assert balances(shop, box, mass_g) == (1, 1, 0)
    shop.fit(first)
    assert balances(shop, box, mass_g) == (0, 0, 0)
    problem = shop.refused("POST", f"/plans/{second['id']}/fitted", {}, 409, "out_of_stock")
    assert "last mounted by Technician 1" in problem["detail"]


def test_a_hold_ends_by_itself(shop: Workshop) -> None:
    box, (first, second) = contested(shop)
    reserve(shop, first, minutes=60)
    shop.refused("POST", f"/plans/{second['id']}/reserve", {}, 409, "stock_reserved")
    shop.now.clock.advance(HOUR_S)
    assert balances(shop, box, min(taken(first))) == (1, 0, 1)
    assert stock(shop, box)["holds"] == []
    shop.fit(second)
    shop.refused("POST", f"/plans/{first['id']}/fitted", {}, 409, "out_of_stock")


def test_a_new_plan_sees_only_what_is_available(shop: Workshop) -> None:
    _box, (first, second) = contested(shop)
    reserve(shop, first)
    again = shop.plan(second["session_id"], shop.correct(second["session_id"]))
    assert not taken(again).keys() & taken(first).keys()
    own = shop.plan(first["session_id"], shop.correct(first["session_id"]))
    assert taken(own) == taken(first), "what a session holds is there for itself"


def test_a_session_holds_one_plan_at_a_time(shop: Workshop) -> None:
    box, (first, _) = contested(shop)
    other = shop.plan(first["session_id"], shop.correct(first["session_id"]), max_masses_per_plane=2)
    reserve(shop, first)
    reserve(shop, other)
    holds = stock(shop, box)["holds"]
    assert {hold["plan_id"] for hold in holds} == {other["id"]}
    assert Counter({hold["mass_g"]: hold["pieces"] for hold in holds}) == taken(other)
    assert shop.get(f"/plans/{first['id']}")["reserved_until"] is None


@pytest.mark.parametrize("end", ["release", "close", "another box"])
def test_a_hold_is_let_go(shop: Workshop, end: str) -> None:
    box, (first, second) = contested(shop)
    session = first["session_id"]
    reserve(shop, first)
    if end == "release":
        shop.ask("POST", f"/plans/{first['id']}/release")
    elif end == "close":
        shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    else:
        shop.ask("PATCH", f"/sessions/{session}", {"catalogue_id": shop.box()})
    assert stock(shop, box)["holds"] == []
    assert shop.get(f"/plans/{first['id']}")["reserved_until"] is None
    shop.fit(second)


def test_only_the_pieces_that_are_not_on_the_drum_yet_are_held(shop: Workshop) -> None:
    box, (first, _) = contested(shop)
    shop.fit(first)
    trim = shop.plan(first["session_id"], shop.correct(first["session_id"]))
    assert taken(trim) == taken(first)
    reserve(shop, trim)
    assert stock(shop, box)["holds"] == []


def test_fitting_what_is_held_differently_lets_the_rest_go(shop: Workshop) -> None:
    box, (first, _) = contested(shop, count=2)
    reserve(shop, first)
    piece = {"plane": "1", "position_deg": 20.0, "mass_g": 10.0}
    shop.fit(first, actual=[piece])
    assert stock(shop, box)["holds"] == []
    assert balances(shop, box, 10.0) == (1, 0, 1)
    assert {balances(shop, box, mass_g) for mass_g in taken(first)} == {(2, 0, 2)}


def test_a_fitted_a_stale_and_an_impossible_plan_are_not_held(shop: Workshop) -> None:
    _box, (first, second) = contested(shop, count=2)
    shop.run(second["session_id"], "initial")
    shop.refused("POST", f"/plans/{second['id']}/reserve", {}, 409, "plan_stale")
    shop.fit(first)
    shop.refused("POST", f"/plans/{first['id']}/reserve", {}, 409, "plan_fitted")
    session = shop.session()
    shop.learn(session)
    every = [{"plane": p, "position_deg": 20.0 * hole} for p in "12" for hole in range(18)]
    impossible = shop.plan(session, shop.correct(session), mode="fewest", blocked=every)
    assert impossible["status"] == "infeasible"
    shop.refused("POST", f"/plans/{impossible['id']}/reserve", {}, 409, "plan_infeasible")


def test_pieces_are_booked_by_hand(shop: Workshop) -> None:
    box = shop.box(count=5, masses=(10.0, 20.0))

    def book(kind: str, pieces: int) -> Any:
        return shop.post(f"/catalogues/{box}/stock", {"kind": kind, "pieces": [{"mass_g": 10.0, "pieces": pieces}]})

    for kind, pieces, after in (("received", 3, 8), ("returned", 1, 9), ("withdrawn", 2, 7), ("counted", 6, 6)):
        assert book(kind, pieces)["items"][0]["on_hand"] == after
    assert [m["pieces"] for m in stock(shop, box)["movements"] if m["mass_g"] == 10.0] == [-1, -2, 1, 3, 5]
    body = {"kind": "withdrawn", "pieces": [{"mass_g": 10.0, "pieces": 7}]}
    assert shop.refused("POST", f"/catalogues/{box}/stock", body, 409, "out_of_stock")["field"] == "pieces"
    body = {"kind": "received", "pieces": [{"mass_g": 11.0, "pieces": 7}]}
    shop.refused("POST", f"/catalogues/{box}/stock", body, 422, "invalid_input")


def test_held_pieces_cannot_be_withdrawn_but_may_be_counted_away(shop: Workshop) -> None:
    box, (first, _) = contested(shop)
    reserve(shop, first)
    mass_g = min(taken(first))
    body = {"kind": "withdrawn", "pieces": [{"mass_g": mass_g, "pieces": 1}]}
    shop.refused("POST", f"/catalogues/{box}/stock", body, 409, "stock_reserved")
    shop.post(f"/catalogues/{box}/stock", {"kind": "counted", "pieces": [{"mass_g": mass_g, "pieces": 0}]})
    assert balances(shop, box, mass_g) == (0, 1, 0)
    shop.refused("POST", f"/plans/{first['id']}/fitted", {}, 409, "out_of_stock")


def reserving(plan_id: str) -> Callable[[AppContext], object]:
    """Reserve this plan."""
    return lambda work: reservations.reserve(work, plan_id, ReserveRequest()).state


def test_the_last_piece_is_reserved_by_exactly_one(shop: Workshop) -> None:
    _box, plans = contested(shop)
    ended = at_once(shop, [reserving(plan["id"]) for plan in plans])
    assert sorted(map(str, ended)) == ["proposed", "stock_reserved"]
    winner = plans[ended.index("proposed")]
    assert at_once(shop, [fitting(p["id"]) for p in plans]).count("fitted") == 1
    assert shop.get(f"/plans/{winner['id']}")["state"] == "fitted"


def test_the_engine_itself_refuses_less_than_nothing(shop: Workshop) -> None:
    box = shop.box(count=1, masses=(10.0,))
    entry = {"catalogue_id": box, "item": 0, "kind": "withdrawn", "pieces": -2, "at": shop.now()}
    with pytest.raises(IntegrityError, match="on_hand"), shop.work.write() as store:
        store.move_stock([entry])
    assert balances(shop, box, 10.0) == (1, 0, 1)
    assert len(stock(shop, box)["movements"]) == 1


class Ledger(RuleBasedStateMachine):
    """Two sessions and a store-keeper do what they like: the sums always agree with a model of the box."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = tempfile.TemporaryDirectory()
        self.entered = workshop(f"sqlite:///{self.folder.name}/ledger.db")
        self.shop = self.entered.__enter__()
        self.box, self.plans = contested(self.shop, count=1)
        self.mass_g = min(taken(self.plans[0]))
        self.on_hand = 1
        self.fitted: set[int] = set()
        self.held: dict[int, float] = {}
        self.clock = 0.0

    def teardown(self) -> None:
        self.entered.__exit__(None, None, None)
        self.folder.cleanup()

    def ask(self, path: str, body: object) -> bool:
        answer = self.shop.client.post(f"/api/v1{path}", json=body)
        assert answer.status_code in (200, 201, 409), answer.text
        return answer.is_success

    @property
    def live(self) -> set[int]:
        return {who for who, until in self.held.items() if until > self.clock}

    @rule(who=st.integers(0, 1))
    def fit(self, who: int) -> None:
        free = self.on_hand - len(self.live - {who})
        done = self.ask(f"/plans/{self.plans[who]['id']}/fitted", {})
        assert done == (who not in self.fitted and free >= 1)
        if done:
            self.fitted.add(who)
            self.held.pop(who, None)
            self.on_hand -= 1

    @rule(who=st.integers(0, 1))
    def unfit(self, who: int) -> None:
        if self.ask(f"/plans/{self.plans[who]['id']}/unfit", None):
            assert who in self.fitted
            self.fitted.remove(who)
            self.on_hand += 1

    @rule(who=st.integers(0, 1), minutes=st.sampled_from([30, 60, 90]))
    def reserve(self, who: int, minutes: int) -> None:
        free = self.on_hand - len(self.live - {who})
        done = self.ask(f"/plans/{self.plans[who]['id']}/reserve", {"minutes": minutes})
        assert done == (who not in self.fitted and free >= 1)
        if done:
            self.held[who] = self.clock + minutes

    @rule(who=st.integers(0, 1))
    def release(self, who: int) -> None:
        assert self.ask(f"/plans/{self.plans[who]['id']}/release", None)
        self.held.pop(who, None)

    @rule(pieces=st.integers(0, 2))
    def count(self, pieces: int) -> None:
        body = {"kind": "counted", "pieces": [{"mass_g": grams, "pieces": pieces} for grams in taken(self.plans[0])]}
        assert self.ask(f"/catalogues/{self.box}/stock", body)
        self.on_hand = pieces

    @precondition(lambda self: self.held)
    @rule()
    def wait(self) -> None:
        """Until some holds end, a quarter of an hour from any of their ends: the seconds of the clock do not matter."""
        self.clock += 45.0
        self.shop.now.clock.advance(45.0 * 60.0)

    @invariant()
    def balances_agree(self) -> None:
        found = balances(self.shop, self.box, self.mass_g)
        reserved = len(self.live)
        assert found == (self.on_hand, reserved, max(self.on_hand - reserved, 0))
        movements = [m for m in stock(self.shop, self.box)["movements"] if m["mass_g"] == self.mass_g]
        assert sum(m["pieces"] for m in movements) == self.on_hand


TestLedger = Ledger.TestCase
TestLedger.settings = settings(max_examples=6, stateful_step_count=20)
