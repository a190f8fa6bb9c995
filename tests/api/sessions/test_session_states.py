"""The session as a state machine, and what each step leaves behind."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.http.workshop import (
    DRUM,
    POSITIONS,
    LinearDrum,
    Workshop,
    machine_body,
    mass,
    on_rotor,
    vector_of,
    vectors,
)

READINGS = DRUM.readings()


class TestOrder:
    def test_a_check_needs_a_fitted_plan(self, shop: Workshop) -> None:
        session = shop.session()
        check = {"kind": "check", "readings": READINGS}
        problem = shop.refused("POST", f"/sessions/{session}/runs", check, 409, "out_of_order")
        assert "as mounted first" in problem["advice"]
        shop.planned(session)
        shop.refused("POST", f"/sessions/{session}/runs", check, 409, "out_of_order")

    def test_a_plan_needs_a_box(self, shop: Workshop) -> None:
        session = str(shop.post("/sessions", {"machine_id": shop.machine()})["id"])
        correction = shop.correct(session, source="balancer", masses=[mass("1", 100.0, 40.0)])
        request = {"correction_id": correction["id"], "objective": "components"}
        problem = shop.refused("POST", f"/sessions/{session}/plans", request, 409, "catalogue_missing")
        assert "PATCH" in problem["advice"]
        shop.ask("PATCH", f"/sessions/{session}", {"catalogue_id": shop.box()})
        assert shop.plan(session, correction, objective="components")["placements"]

    def test_a_plan_is_fitted_once(self, shop: Workshop) -> None:
        plan = shop.planned(shop.session())
        shop.fit(plan)
        shop.refused("POST", f"/plans/{plan['id']}/fitted", {}, 409, "plan_fitted")

    def test_only_the_fitted_plan_comes_off(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.planned(session)
        problem = shop.refused("POST", f"/plans/{plan['id']}/unfit", None, 409, "out_of_order")
        assert problem["field"] == "plan_id"
        shop.fit(plan)
        shop.ask("POST", f"/plans/{plan['id']}/unfit")
        assert shop.state(session) == "planned"
        shop.refused("POST", f"/plans/{plan['id']}/unfit", None, 409, "out_of_order")

    def test_a_plan_without_masses_is_a_plan(self, shop: Workshop) -> None:
        """Nothing in the box is as light as the planes allow: leaving the rotor as found is the best selection."""
        machine = shop.machine(planes=[{**plane, "max_total_mass_g": 1.0} for plane in machine_body()["planes"]])
        session = shop.session(machine)
        plan = shop.planned(session)
        assert (plan["placements"], plan["reason"]) == ([], None)
        assert vectors(plan["predicted"]) == pytest.approx(DRUM.initial, abs=1e-9)
        shop.fit(plan)
        assert shop.state(session) == "fitted"

    def test_the_box_is_not_changed_under_fitted_masses(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.fit(shop.planned(session))
        other = {"catalogue_id": shop.box()}
        shop.refused("PATCH", f"/sessions/{session}", other, 409, "plan_fitted")
        shop.ask("POST", f"/plans/{plan['id']}/unfit")
        assert shop.ask("PATCH", f"/sessions/{session}", other)["catalogue_id"] == other["catalogue_id"]

    def test_a_closed_session_does_not_change(self, shop: Workshop) -> None:
        machine = shop.machine()
        session = shop.session(machine)
        plan = shop.fit(shop.planned(session))
        shop.ask("PUT", "/sources/bridge", {"machine_id": machine})
        run = shop.get(f"/sessions/{session}")["runs"][0]["id"]
        closed = shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
        assert closed["closed_at"] is not None
        arrival = {"source": "bridge", "sequence": 1, "taken_at": "2025-12-01T12:00:00Z", "session_id": session}
        for method, path, body in (
            ("POST", f"/sessions/{session}/runs", {"kind": "initial", "readings": READINGS}),
            ("PATCH", f"/sessions/{session}/runs/{run}", {"excluded": True, "reason": "typo"}),
            ("POST", f"/sessions/{session}/corrections", {"source": "fit"}),
            ("POST", f"/sessions/{session}/plans", {"correction_id": plan["correction_id"], "objective": "components"}),
            ("POST", f"/plans/{plan['id']}/fitted", {}),
            ("POST", f"/plans/{plan['id']}/unfit", None),
            ("PATCH", f"/sessions/{session}", {"note": "late"}),
            ("PATCH", f"/sessions/{session}", {"state": "closed"}),
            ("POST", "/readings", {**arrival, "sensor": "P", "amplitude": 1.0}),
            ("POST", "/balancer-answers", {**arrival, "masses": [mass("1", 1.0, 0.0)]}),
        ):
            problem = shop.refused(method, path, body, 409, "session_closed")
            assert "open a new session" in problem["advice"]
        assert shop.get(f"/sessions/{session}") == closed
        assert shop.get(f"/sessions/{session}/log")["plans"] == closed["plans"]

    def test_every_state_says_what_comes_next(self, shop: Workshop) -> None:
        session = shop.session()
        said = [shop.get(f"/sessions/{session}")["next_step"]]
        shop.learn(session)
        correction = shop.correct(session)
        said.append(shop.get(f"/sessions/{session}")["next_step"])
        plan = shop.plan(session, correction)
        said.append(shop.get(f"/sessions/{session}")["next_step"])
        shop.fit(plan)
        said.append(shop.get(f"/sessions/{session}")["next_step"])
        shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": READINGS})
        said.append(shop.get(f"/sessions/{session}")["next_step"])
        said.append(shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})["next_step"])
        for step, word in zip(said, ("trial run", "plan", "lock", "check run", "trim", "new one"), strict=True):
            assert word in step

    def test_what_is_missing_in_fact_comes_next(self, shop: Workshop) -> None:
        def said() -> Any:
            return shop.get(f"/sessions/{session}")["next_step"]

        session = shop.session()
        shop.run(session, "initial")
        assert said() == 'take a trial run in plane "1" and a trial run in plane "2", then ask for corrections'
        for plane in ("1", "2"):
            last = shop.run(session, "trial", [mass(plane, 200.0, 0.0)])
        assert said() == "ask for corrections"
        plan = shop.plan(session, shop.correct(session))
        further = shop.run(session, "initial")
        shop.ask("PATCH", f"/sessions/{session}/runs/{further['id']}", {"excluded": True, "reason": "a gust"})
        assert plan["state"] == "proposed"
        assert said().startswith("ask for corrections again")
        shop.ask("PATCH", f"/sessions/{session}/runs/{last['id']}", {"excluded": True, "reason": "loose"})
        assert said() == 'take a trial run in plane "2", then ask for corrections'


class TestStale:
    def test_a_new_run_outdates_corrections_and_plans_and_erases_nothing(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.planned(session)
        shop.run(session, "initial")
        stored = shop.get(f"/sessions/{session}")
        assert [c["stale"] for c in stored["corrections"]] == [True]
        assert [p["stale"] for p in stored["plans"]] == [True]
        request = {"correction_id": plan["correction_id"], "objective": "components"}
        shop.refused("POST", f"/sessions/{session}/plans", request, 409, "correction_stale")
        shop.refused("POST", f"/plans/{plan['id']}/fitted", {}, 409, "plan_stale")
        assert shop.fit(plan, accept_stale=True)["state"] == "fitted"

    def test_a_plan_that_was_taken_off_goes_stale_too(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.fit(shop.planned(session))
        shop.ask("POST", f"/plans/{plan['id']}/unfit")
        shop.run(session, "initial")
        shop.refused("POST", f"/plans/{plan['id']}/fitted", {}, 409, "plan_stale")

    def test_a_balancers_answer_does_not_go_stale(self, shop: Workshop) -> None:
        session = shop.session()
        correction = shop.correct(session, source="balancer", masses=[mass("1", 100.0, 40.0)])
        shop.run(session, "initial")
        assert shop.get(f"/sessions/{session}")["corrections"][0]["stale"] is False
        assert shop.plan(session, correction, objective="components")["placements"]

    def test_an_excluded_run_leaves_the_fit_and_comes_back(self, shop: Workshop) -> None:
        session = shop.session()
        shop.learn(session)
        good = shop.correct(session)
        typo = shop.run(session, "initial", drum=LinearDrum({"P": 90.0 + 0j, "Q": 0j}, DRUM.influence))
        assert shop.correct(session)["corrections"] != good["corrections"]
        path = f"/sessions/{session}/runs/{typo['id']}"
        excluded = shop.ask("PATCH", path, {"excluded": True, "reason": "wrong sensor"})
        assert (excluded["excluded"], excluded["reason"]) == (True, "wrong sensor")
        again = shop.correct(session)
        assert (again["corrections"], again["runs"]) == (good["corrections"], [1, 2, 3])
        assert len(shop.get(f"/sessions/{session}")["runs"]) == 4
        assert shop.get(f"/sessions/{session}/report.json")["excluded_runs"] == [4]
        shop.ask("PATCH", path, {"excluded": False, "reason": "it was right"})
        assert shop.correct(session)["runs"] == [1, 2, 3, 4]

    def test_a_run_supersedes_a_mistyped_one(self, shop: Workshop) -> None:
        session = shop.session()
        typo = shop.run(session, "initial", drum=LinearDrum({"P": 90.0 + 0j, "Q": 0j}, DRUM.influence))
        shop.run(session, "initial", supersedes=typo["id"])
        for plane in ("1", "2"):
            shop.run(session, "trial", [mass(plane, 200.0, 0.0)])
        first = shop.get(f"/sessions/{session}")["runs"][0]
        assert (first["excluded"], first["reason"]) == (True, "superseded by run 2")
        correction = shop.correct(session)
        assert correction["runs"] == [2, 3, 4]
        assert vectors(correction["initial"]) == pytest.approx(DRUM.initial, abs=1e-9)


class TestStock:
    def test_pieces_leave_and_come_back(self, shop: Workshop) -> None:
        box = shop.box(count=2)
        plan = shop.planned(shop.session(box=box))
        before = shop.on_hand(box)
        shop.fit(plan)
        taken = [p["mass_g"] for p in plan["placements"]]
        assert shop.on_hand(box) == {grams: 2 - taken.count(grams) for grams in before}
        shop.ask("POST", f"/plans/{plan['id']}/unfit")
        assert shop.on_hand(box) == before
        kinds = [row.split("'")[3] for row in shop.rows()["stock_entry"]]
        assert sorted(set(kinds)) == ["fitted", "received", "returned"]

    def test_two_sessions_and_one_last_piece(self, shop: Workshop) -> None:
        machine, box = shop.machine(), shop.box(count=1)
        sessions = [shop.session(machine, box) for _ in range(2)]
        plans = [shop.planned(session) for session in sessions]
        assert plans[0]["placements"] == plans[1]["placements"]
        shop.fit(plans[0])
        left = shop.on_hand(box)
        problem = shop.refused("POST", f"/plans/{plans[1]['id']}/fitted", {}, 409, "out_of_stock")
        assert problem["value"] == sorted(p["mass_g"] for p in plans[1]["placements"])
        assert "new plan" in problem["advice"]
        assert (shop.on_hand(box), shop.state(sessions[1])) == (left, "planned")
        again = shop.plan(sessions[1], shop.correct(sessions[1]))
        assert not {p["mass_g"] for p in again["placements"]} & {p["mass_g"] for p in plans[0]["placements"]}
        shop.fit(again)

    def test_all_or_none(self, shop: Workshop) -> None:
        box = shop.box(count=1)
        session = shop.session(box=box)
        plan = shop.planned(session)
        pieces = [("1", 20.0, 10.0), ("1", 40.0, 50.0), ("2", 20.0, 50.0)]
        actual = [{"plane": p, "position_deg": at, "mass_g": grams} for p, at, grams in pieces]
        problem = shop.refused("POST", f"/plans/{plan['id']}/fitted", {"actual": actual}, 409, "out_of_stock")
        assert problem["value"] == [50.0]
        assert set(shop.on_hand(box).values()) == {1}

    def test_a_trim_exchanges_only_what_changes(self, shop: Workshop) -> None:
        box = shop.box(count=1)
        session = shop.session(box=box)
        first = shop.fit(shop.planned(session))
        shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": DRUM.readings(on_rotor(first["fitted"]))})
        second = shop.plan(session, shop.correct(session))
        assert [c["action"] for c in second["changes"]] == ["keep"] * len(first["placements"])
        shop.fit(second)
        assert shop.get(f"/plans/{first['id']}")["state"] == "replaced"
        assert sum(shop.on_hand(box).values()) == 6 - len(first["placements"])

    def test_received_and_counted_pieces_are_booked(self, shop: Workshop) -> None:
        box = shop.box(count=2)
        shop.ask("PATCH", f"/catalogues/{box}", {"received": [{"mass_g": 10.0, "pieces": 3}]})
        shop.ask("PATCH", f"/catalogues/{box}", {"counted": [{"mass_g": 20.0, "pieces": 0}]})
        assert shop.on_hand(box) == {10.0: 5, 20.0: 0, 50.0: 2, 100.0: 2, 200.0: 2, 300.0: 2}

    def test_an_unlimited_box_has_no_ledger(self, shop: Workshop) -> None:
        box = shop.box(count=None)
        shop.fit(shop.planned(shop.session(box=box)))
        assert set(shop.on_hand(box).values()) == {None}
        assert shop.count("stock_entry") == 0


class TestFitted:
    def test_a_check_defaults_to_the_fitted_plan(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.fit(shop.planned(session))
        run = shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": READINGS})
        assert run["masses"] == on_rotor(plan["fitted"])
        assert run["masses"]

    def test_what_was_really_fitted_makes_the_prediction_again(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.planned(session)
        actual = [
            {"plane": "1", "position_deg": 360.0, "mass_g": 50.0, "weighed_g": 51.5},
            {"plane": "2", "position_deg": -340.0, "mass_g": 20.0},
        ]
        fitted = shop.fit(plan, actual=actual)
        assert [(p["plane"], p["position_deg"], p["hole"], p["weighed_g"]) for p in fitted["fitted"]] == [
            ("1", 0.0, "18", 51.5),
            ("2", 20.0, "1", None),
        ]
        really = [mass("1", 51.5, 0.0), mass("2", 20.0, 20.0)]
        assert on_rotor(fitted["fitted"]) == really
        assert vectors(fitted["predicted"]) == pytest.approx(DRUM.vibration(really), abs=1e-9)
        assert fitted["placements"] == plan["placements"]
        assert vectors(plan["predicted"]) != pytest.approx(vectors(fitted["predicted"]), abs=1e-3)

    def test_fasteners_count(self, shop: Workshop) -> None:
        items = [{"mass_g": 100.0, "count": 4, "fastener_g": 7.0}]
        box = shop.post("/catalogues", {"name": "with screws", "items": items})["id"]
        session = shop.session(box=box)
        plan = shop.planned(session)
        assert {p["fastener_g"] for p in plan["placements"]} == {7.0}
        assert vectors(plan["predicted"]) == pytest.approx(DRUM.vibration(on_rotor(plan["placements"])), abs=1e-9)
        shop.fit(plan)
        run = shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": READINGS})
        assert {m["mass_g"] for m in run["masses"]} == {107.0}

    def test_blocked_holes_stay_empty(self, shop: Workshop) -> None:
        session = shop.session()
        free = shop.planned(session)
        blocked = [{"plane": p["plane"], "position_deg": p["position_deg"] - 360.0} for p in free["placements"]]
        plan = shop.plan(session, shop.correct(session), blocked=blocked)
        assert plan["placements"]
        assert not holes(plan) & holes(free)

    def test_base_present_keeps_what_is_on(self, shop: Workshop) -> None:
        session = shop.session()
        first = shop.fit(shop.planned(session))
        correction = shop.correct(session)
        added = shop.plan(session, correction, base="present", max_masses_per_plane=2)
        assert holes(first) < holes(added)
        assert {c["action"] for c in added["changes"]} == {"keep", "add"}
        assert vectors(added["predicted"]) == pytest.approx(DRUM.vibration(on_rotor(added["placements"])), abs=1e-9)
        moved = shop.plan(session, correction, blocked=[hole(p) for p in first["placements"]])
        assert "remove" in {c["action"] for c in moved["changes"]}

    def test_a_trim_is_the_total_minus_what_is_on(self, shop: Workshop) -> None:
        session = shop.session()
        plan = shop.fit(shop.planned(session))
        present = on_rotor(plan["fitted"])
        shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": DRUM.readings(present)})
        correction = shop.correct(session)
        totals, trims = (
            {m["plane"]: vector_of(m, "mass_g", "angle_deg") for m in correction[key]}
            for key in ("corrections", "trim")
        )
        for piece in present:
            totals[piece["plane"]] -= vector_of(piece, "mass_g", "angle_deg")
        assert trims == pytest.approx(totals, abs=1e-9)

    def test_360_is_stored_as_0(self, shop: Workshop) -> None:
        machine = shop.machine()
        stored = shop.get(f"/machines/{machine}")["planes"][0]["positions_deg"]
        assert stored == [*POSITIONS[:-1], 0.0]
        turned = [{**plane, "positions_deg": [-20.0, -360.0, 100.0]} for plane in machine_body()["planes"]]
        assert shop.get(f"/machines/{shop.machine(planes=turned)}")["planes"][0]["positions_deg"] == [340.0, 0.0, 100.0]


def hole(placement: dict[str, Any]) -> dict[str, Any]:
    """The position of a placement."""
    return {"plane": placement["plane"], "position_deg": placement["position_deg"]}


def holes(plan: dict[str, Any]) -> set[tuple[str, float]]:
    """The positions that a plan uses."""
    return {(p["plane"], p["position_deg"]) for p in plan["placements"]}
