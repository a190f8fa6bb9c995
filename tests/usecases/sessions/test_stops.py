"""Stops to change masses: nothing is touched unlocked, nothing turns unreleased, no hole is pulled too hard."""

from __future__ import annotations

from typing import Any

import pytest

from service.engine.session_state import under_way
from service.errors import InvalidInput, NotFound, OutOfOrder
from service.model.plan import ActualPlacement
from service.model.run import MassOnRotor
from service.model.stop import StopRequest
from service.usecases.sessions import sessions, stops
from tests.support.http.workshop import Workshop, machine_body, mass

TRIAL = StopRequest(purpose="trial", plane="1")
PIECE = MassOnRotor(plane="1", mass_g=50.0, angle_deg=20.0)


def on_rotor(shop: Workshop, session: str) -> tuple[MassOnRotor, ...]:
    return sessions.get(shop.work, session).masses_on_rotor


def test_masses_are_changed_only_once_locked_and_the_machine_released_only_once_they_are_stated(shop: Workshop) -> None:
    session = shop.session()
    stop = stops.begin(shop.work, session, TRIAL)
    with pytest.raises(OutOfOrder):
        stops.change(shop.work, session, 1, [PIECE])
    with pytest.raises(OutOfOrder):
        stops.release(shop.work, session, 1)
    stops.lock(shop.work, session, stop.number)
    with pytest.raises(OutOfOrder, match="must be stated"):
        stops.release(shop.work, session, 1)
    stops.change(shop.work, session, 1, [PIECE])
    assert on_rotor(shop, session) == (PIECE,)
    released = stops.release(shop.work, session, 1)
    assert released.released_at is not None
    assert released.locked_at is not None
    assert released.locked_at < released.released_at
    assert under_way(stops.of(shop.work, session)) is None


def test_a_stop_is_given_up_before_masses_were_changed_and_finished_after(shop: Workshop) -> None:
    session = shop.session()
    stops.begin(shop.work, session, TRIAL)
    second = stops.begin(shop.work, session, StopRequest(purpose="trial", plane="2"))
    assert [stop.cancelled for stop in stops.of(shop.work, session)] == [True, False]
    with pytest.raises(OutOfOrder, match="was cancelled"):
        stops.lock(shop.work, session, 1)
    stops.lock(shop.work, session, second.number)
    stops.change(shop.work, session, second.number, [PIECE])
    with pytest.raises(OutOfOrder):
        stops.cancel(shop.work, session, 2)
    with pytest.raises(OutOfOrder):
        stops.begin(shop.work, session, TRIAL)


def test_no_hole_is_pulled_harder_than_it_may_be(shop: Workshop) -> None:
    """100 g at 330 mm and 460 r/min: 0.1 kg * 0.33 m * (48.17 rad/s)**2 = 76.6 N."""
    planes = [{**plane, "max_force_n": 76.0} for plane in machine_body()["planes"]]
    session = shop.session(shop.machine(planes=planes))
    stops.begin(shop.work, session, TRIAL)
    stops.lock(shop.work, session, 1)
    two = [MassOnRotor(plane="1", mass_g=50.0, angle_deg=angle) for angle in (20.0, -340.0)]
    with pytest.raises(InvalidInput, match="77 N") as refused:
        stops.change(shop.work, session, 1, two)
    assert refused.value.advice == "mount at most 99.2 g in one hole of this plane"
    assert on_rotor(shop, session) == ()
    apart = [MassOnRotor(plane="1", mass_g=50.0, angle_deg=angle) for angle in (20.0, 40.0)]
    stops.change(shop.work, session, 1, apart)
    assert on_rotor(shop, session) == tuple(apart)


def test_a_later_run_states_what_is_on_the_rotor(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    stops.begin(shop.work, session, TRIAL)
    stops.lock(shop.work, session, 1)
    stops.change(shop.work, session, 1, [PIECE])
    stops.release(shop.work, session, 1)
    shop.run(session, "trial", [mass("2", 70.0, 60.0)])
    assert [m.mass_g for m in on_rotor(shop, session)] == [70.0]


def planned(shop: Workshop, **box: Any) -> tuple[str, str, Any]:
    session_box = shop.box(**box)
    session = shop.session(box=session_box)
    return session, session_box, shop.planned(session)


def test_a_plan_is_fitted_once_however_often_it_is_said(shop: Workshop) -> None:
    session, box, plan = planned(shop)
    before = shop.on_hand(box)
    stops.begin(shop.work, session, StopRequest(purpose="plan", plan_id=plan["id"]))
    with pytest.raises(OutOfOrder, match="locked"):
        stops.fit(shop.work, session, 1, None)
    assert shop.on_hand(box) == before
    stops.lock(shop.work, session, 1)
    # The masses were booked, and the stop was not: as after a crash between the two.
    shop.fit(plan)
    stops.fit(shop.work, session, 1, None)
    taken = sum(before.values()) - sum(shop.on_hand(box).values())
    assert taken == len(plan["placements"])
    assert {m.mass_g for m in on_rotor(shop, session)} == {p["mass_g"] for p in plan["placements"]}


def test_what_was_really_fitted_is_on_the_rotor(shop: Workshop) -> None:
    session, _box, plan = planned(shop)
    stops.begin(shop.work, session, StopRequest(purpose="plan", plan_id=plan["id"]))
    stops.lock(shop.work, session, 1)
    piece = plan["placements"][0]
    actual = ActualPlacement(plane=piece["plane"], position_deg=40.0, mass_g=piece["mass_g"], weighed_g=199.0)
    stops.fit(shop.work, session, 1, (actual,))
    assert on_rotor(shop, session) == (MassOnRotor(plane=piece["plane"], mass_g=199.0, angle_deg=40.0),)
    fitted = shop.get(f"/plans/{plan['id']}")
    assert fitted["predicted"] != plan["predicted"]


def test_unknown_stops_planes_and_plans_are_refused_and_nothing_after_the_end(shop: Workshop) -> None:
    session = shop.session()
    with pytest.raises(NotFound):
        stops.of(shop.work, "none")
    with pytest.raises(NotFound):
        stops.lock(shop.work, session, 7)
    with pytest.raises(InvalidInput):
        stops.begin(shop.work, session, StopRequest(purpose="trial", plane="9"))
    _other, _box, plan = planned(shop)
    with pytest.raises(InvalidInput):
        stops.begin(shop.work, session, StopRequest(purpose="plan", plan_id=plan["id"]))
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    with pytest.raises(OutOfOrder):
        stops.begin(shop.work, session, TRIAL)
