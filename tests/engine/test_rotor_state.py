"""What is on the rotor and what changes: whatever was stated last counts, and a weighed piece stays the same piece."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

from service.engine.rotor_state import Drum, Mounted, changes, mounted, on_rotor, pieces_of, trial_piece
from service.model.base import read_json
from service.model.machine import Machine
from service.model.plan import Placement
from service.model.run import MassOnRotor
from service.model.session import AsFoundPiece, SessionLog
from service.model.stop import Stop
from tests.support.http.workshop import Workshop, machine_body, mass

MACHINE = read_json(Machine, json.dumps(machine_body()))
NOON = datetime(2026, 3, 1, 12, tzinfo=UTC)
PIECE = Placement(plane="1", position_deg=200.0, hole="10", mass_g=300.0, fastener_g=12.0)
FOUND = AsFoundPiece(plane="2", position_deg=40.0, mass_g=35.0, may="move")


def actions(found: Any) -> list[tuple[str, str, float, float]]:
    return [(c.action, c.placement.plane, c.placement.position_deg, c.placement.mass_g) for c in found]


def test_a_weighed_piece_is_kept_and_not_exchanged_for_its_like() -> None:
    """The page once ordered it off and its like on, while the API said keep."""
    weighed = replace(PIECE, weighed_g=300.4)
    present = pieces_of(MACHINE, (), [MassOnRotor(plane="1", mass_g=312.4, angle_deg=200.0)], (weighed,))
    assert present.on == (weighed,)
    assert actions(changes(MACHINE, (), present, (PIECE,))) == [("keep", "1", 200.0, 300.0)]


def test_a_trial_mass_comes_off_at_any_angle() -> None:
    trial = MassOnRotor(plane="2", mass_g=150.0, angle_deg=47.5)
    found = changes(MACHINE, (), pieces_of(MACHINE, (), [trial], ()), (PIECE,))
    assert actions(found) == [("remove", "2", 47.5, 150.0), ("add", "1", 200.0, 300.0)]
    assert [c.placement.hole for c in found] == ["", "10"]


def test_an_as_found_piece_that_is_off_goes_on_again_where_it_sat() -> None:
    off = MassOnRotor(plane="2", mass_g=-35.0, angle_deg=40.0)
    present = pieces_of(MACHINE, (FOUND,), [off], ())
    assert [piece.mass_g for piece in present.off] == [35.0]
    assert actions(changes(MACHINE, (FOUND,), present, ())) == [("add", "2", 40.0, 35.0)]


def test_removed_material_is_no_piece() -> None:
    present = pieces_of(MACHINE, (), [MassOnRotor(plane="2", mass_g=-8.0, angle_deg=111.0)], ())
    assert present == Mounted(())


def test_two_of_a_kind_in_one_hole_are_alike() -> None:
    found = changes(MACHINE, (), Mounted((PIECE, PIECE)), (PIECE,))
    assert [c.action for c in found] == ["remove", "keep"]


def test_a_mass_stated_with_its_fastener_is_the_piece() -> None:
    present = Mounted((trial_piece(MACHINE.planes[0], 312.03, 200.0),))
    assert [c.action for c in changes(MACHINE, (), present, (PIECE,))] == ["keep"]


def test_what_was_stated_last_is_on_the_rotor(shop: Workshop) -> None:
    session = shop.session()
    shop.learn(session)
    plan = shop.plan(session, shop.correct(session))

    def now() -> Any:
        return shop.get(f"/sessions/{session}")["masses_on_rotor"]

    assert now() == [mass("2", 200.0, 0.0)]
    assert {c["action"] for c in plan["changes"]} == {"remove", "add"}
    shop.fit(plan)
    pieces = [(p["plane"], p["mass_g"]) for p in plan["placements"]]
    assert [(m["plane"], m["mass_g"]) for m in now()] == pieces
    shop.ask("POST", f"/plans/{plan['id']}/unfit")
    assert now() == []


def test_between_two_runs_the_later_change_counts(shop: Workshop) -> None:
    session = shop.session()
    plan = shop.planned(session)
    shop.fit(plan)
    view = shop.get(f"/sessions/{session}")
    log = shop.get(f"/sessions/{session}/log")
    assert view["plans"][-1]["changed_at"] is not None
    drum = _drum(log)
    later = MassOnRotor(plane="1", mass_g=90.0, angle_deg=20.0)
    assert drum.plans[-1].changed_at is not None
    stop = Stop(
        id="s",
        number=1,
        purpose="trial",
        plane="1",
        plan_id=None,
        placements=(),
        runs_before=3,
        begun_at=NOON,
        masses=(later,),
        changed_at=drum.plans[-1].changed_at + timedelta(seconds=5),
        changed_after_run=3,
    )
    assert on_rotor(replace(drum, stops=(stop,))) == (later,)
    earlier = replace(stop, changed_at=drum.plans[-1].changed_at - timedelta(seconds=5))
    assert [m.mass_g for m in on_rotor(replace(drum, stops=(earlier,)))] == [p["mass_g"] for p in plan["placements"]]
    assert mounted(replace(drum, stops=(earlier,))).on == drum.plans[-1].fitted


def _drum(log: Any) -> Drum:

    read = read_json(SessionLog, json.dumps(log))
    return Drum(read.machine, read.runs, read.run_out, read.plans, (), read.on_rotor)
