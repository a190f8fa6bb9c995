"""Pieces that are on the as-found rotor already: they stay, move or come off, and everybody keeps count of them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from service.engine.logs.replay import read_log, resolve
from tests.support.http.as_found import SAME, actions, assert_done, best, holds, net, opened, piece, planned
from tests.support.http.every_selection import BOX, EverySelection, tiny_machine
from tests.support.http.workshop import DRUM, Workshop, mass, vectors

KEYS = ("placements", "taken_off")
SEVERAL = [
    {"plane": "1", "position_deg": 0.0, "mass_g": 200.0, "may": "remove"},
    {"plane": "2", "position_deg": 50.0, "mass_g": 75.0, "may": "move"},
    {"plane": "2", "position_deg": 180.0, "mass_g": 60.0, "may": "stay"},
]

LAST_TRIAL = ("remove", "2", 0.0, 200.0)
"""The trial mass of the latest run comes off before a plan is mounted."""


class TestStay:
    def test_its_hole_is_taken_and_it_counts(self, shared_shop: Workshop) -> None:
        pieces = [piece("1", 180.0, 200.0, "stay"), piece("2", 300.0, 10.0, "stay")]
        session, _ = opened(shared_shop, pieces)
        plan = planned(shared_shop, session)
        holds(plan, pieces)
        assert [p["plane"] for p in plan["placements"]] == ["1", "2"]
        assert not {("1", 180.0), ("2", 300.0)} & {(p["plane"], p["position_deg"]) for p in plan["placements"]}
        assert plan["taken_off"] == []
        assert {one for one in actions(plan) if one[0] != "add"} == {LAST_TRIAL}

    def test_it_counts_against_the_force_on_its_hole(self, shared_shop: Workshop) -> None:
        """200 g at 330 mm and 460 r/min pull with 153 N: of 200 N there is room for 61 g more."""
        session, _ = opened(
            shared_shop, [piece("1", 180.0, 200.0, "stay")], masses_per_position=2, max_masses=3, max_force_n=200.0
        )
        blocked = [{"plane": "1", "position_deg": angle} for angle in (0.0, 50.0, 130.0, 250.0, 300.0)]
        correction = shared_shop.correct(session)
        request = {"max_masses_per_plane": None, "blocked": blocked}
        in_first = [p for p in shared_shop.plan(session, correction, **request)["placements"] if p["plane"] == "1"]
        assert [p["mass_g"] for p in in_first] == [50.0]
        free, _ = opened(shared_shop, [], masses_per_position=2, max_masses=3, max_force_n=200.0)
        plan = shared_shop.plan(free, shared_shop.correct(free), **request)
        assert max(p["mass_g"] for p in plan["placements"] if p["plane"] == "1") == 200.0

    def test_it_counts_against_the_total_mass(self, shared_shop: Workshop) -> None:
        session, _ = opened(shared_shop, [piece("1", 0.0, 150.0, "stay")], max_total_mass_g=250.0)
        plan = planned(shared_shop, session)
        assert sum(p["mass_g"] for p in plan["placements"] if p["plane"] == "1") <= 100.0

    def test_a_plane_that_is_full(self, shared_shop: Workshop) -> None:
        pieces = [piece("1", 0.0, 10.0, "stay"), piece("1", 50.0, 10.0, "stay"), piece("1", 130.0, 10.0, "stay")]
        session, _ = opened(shared_shop, pieces)
        plan = planned(shared_shop, session)
        assert {p["plane"] for p in plan["placements"]} == {"2"}
        assert plan["objective_value"] == pytest.approx(EverySelection(most=(0, 2)).best(), rel=SAME)


class TestRemove:
    @pytest.mark.parametrize("objective", ["residual_vibration", "components", "bearing_force"])
    def test_it_comes_off_where_that_is_better(self, shared_shop: Workshop, objective: str) -> None:
        pieces = [piece("1", 0.0, 200.0, "remove")]
        session, _ = opened(shared_shop, pieces)
        plan = planned(shared_shop, session, objective=objective)
        holds(plan, pieces, objective)
        off = [(p["plane"], p["position_deg"], p["mass_g"], p["from_box"]) for p in plan["taken_off"]]
        assert off == [("1", 0.0, 200.0, False)]
        assert ("remove", "1", 0.0, 200.0) in actions(plan)

    def test_it_stays_where_that_is_better(self, shared_shop: Workshop) -> None:
        pieces = [piece("1", 250.0, 150.0, "remove")]
        session, _ = opened(shared_shop, pieces)
        plan = planned(shared_shop, session)
        holds(plan, pieces)
        assert plan["taken_off"] == []
        assert ("keep", "1", 250.0, 150.0) in actions(plan)

    def test_it_is_not_exchanged_for_its_like_from_the_box(self, shop: Workshop) -> None:
        """The box holds more 200 g pieces than the rotor does; that is no reason to unbolt one for another."""
        free, _ = opened(shop, [])
        wanted = next(p for p in planned(shop, free)["placements"] if p["mass_g"] == 200.0)
        pieces = [piece(wanted["plane"], wanted["position_deg"], 200.0, "remove")]
        session, box = opened(shop, pieces)
        # Every selection that leaves 200 g in that hole comes once, not once for each of the two pieces.
        plan = planned(shop, session, alternatives=12)
        holds(plan, pieces)
        results = set()
        for offer in (plan, *plan["alternatives"]):
            on = {(p["plane"], p["position_deg"], p["mass_g"]) for p in offer["placements"]}
            off = {(p["plane"], p["position_deg"], p["mass_g"]) for p in offer["taken_off"]}
            assert not on & off
            results.add((frozenset(on), frozenset(off)))
        assert len(results) == 13
        fitted = shop.fit(plan)
        used = [p["mass_g"] for p in fitted["fitted"]]
        assert shop.on_hand(box) == {grams: count - used.count(grams) for grams, count in BOX.items()}

    def test_in_a_hole_for_two_neither_is_exchanged(self, shared_shop: Workshop) -> None:
        session, _ = opened(shared_shop, [piece("1", 180.0, 200.0, "remove")], masses_per_position=2)
        blocked = [{"plane": "1", "position_deg": angle} for angle in (0.0, 50.0, 130.0, 250.0, 300.0)]
        plan = planned(shared_shop, session, alternatives=12, blocked=blocked)
        seen = []
        for offer in (plan, *plan["alternatives"]):
            on, off = ([(p["plane"], p["position_deg"], p["mass_g"]) for p in offer[k]] for k in KEYS)
            assert not set(on) & set(off)
            seen.append((on, off))
        assert [1 for on, off in seen if ("1", 180.0, 200.0) in on and not off]  # both of them
        assert all(one not in seen[:index] for index, one in enumerate(seen))

    def test_its_hole_is_blocked(self, shared_shop: Workshop) -> None:
        pieces = [piece("1", 250.0, 35.0, "remove")]
        session, _ = opened(shared_shop, pieces)
        plan = planned(shared_shop, session, blocked=[{"plane": "1", "position_deg": 250.0}])
        assert [p["position_deg"] for p in plan["taken_off"]] == [250.0]
        assert ("1", 250.0) not in {(p["plane"], p["position_deg"]) for p in plan["placements"]}


class TestMove:
    def test_it_goes_where_it_helps_and_comes_from_no_box(self, shop: Workshop) -> None:
        pieces = [piece("1", 0.0, 210.0, "move")]
        session, box = opened(shop, pieces)
        plan = planned(shop, session)
        holds(plan, pieces)
        moved = [p for p in plan["placements"] if not p["from_box"]]
        assert [(p["mass_g"], p["fastener_g"]) for p in moved] == [(210.0, 0.0)]
        assert [(p["plane"], p["position_deg"], p["mass_g"]) for p in plan["taken_off"]] == [("1", 0.0, 210.0)]
        assert {("remove", "1", 0.0, 210.0), ("add", moved[0]["plane"], moved[0]["position_deg"], 210.0)} <= actions(
            plan
        )
        fitted = shop.fit(plan)
        used = [p["mass_g"] for p in fitted["fitted"] if p["from_box"]]
        assert shop.on_hand(box) == {grams: count - used.count(grams) for grams, count in BOX.items()}
        shop.ask("POST", f"/plans/{plan['id']}/unfit")
        assert shop.on_hand(box) == dict(BOX)

    def test_one_of_a_mass_that_the_box_has_too(self, shop: Workshop) -> None:
        """Two 200 g pieces in the box and one on the rotor: the plan may use three, and takes two at most."""
        pieces = [piece("1", 50.0, 200.0, "move")]
        session, box = opened(shop, pieces)
        plan = planned(shop, session, objective="components")
        holds(plan, pieces, "components")
        fitted = shop.fit(plan)
        used = [p["mass_g"] for p in fitted["fitted"] if p["from_box"]]
        assert shop.on_hand(box) == {grams: count - used.count(grams) for grams, count in BOX.items()}

    def test_what_was_really_fitted_keeps_what_was_moved(self, shop: Workshop) -> None:
        session, _ = opened(shop, [piece("1", 0.0, 210.0, "move")])
        plan = planned(shop, session)
        actual = [{"plane": "2", "position_deg": 0.0, "mass_g": 50.0, "weighed_g": 50.5}]
        fitted = shop.fit(plan, actual=actual)
        assert [p["mass_g"] for p in fitted["fitted"] if not p["from_box"]] == [210.0]
        moved = next(p for p in fitted["fitted"] if not p["from_box"])
        really = [mass("2", 50.5, 0.0), mass("1", -210.0, 0.0), mass(moved["plane"], 210.0, moved["position_deg"])]
        assert vectors(fitted["predicted"]) == pytest.approx(DRUM.vibration(really), abs=1e-9)


class TestTogether:
    @pytest.mark.parametrize("objective", ["residual_vibration", "components", "bearing_force"])
    def test_the_best_of_all(self, shared_shop: Workshop, objective: str) -> None:
        session, _ = opened(shared_shop, SEVERAL)
        holds(planned(shared_shop, session, objective=objective), SEVERAL, objective)

    def test_random_pieces(self, shared_shop: Workshop) -> None:
        rng = np.random.default_rng(7)
        for _ in range(3):
            holes = rng.permutation([(p, a) for p in "12" for a in (0.0, 50.0, 130.0, 180.0, 250.0, 300.0)])[:3]
            pieces = [
                piece(
                    str(p),
                    float(a),
                    float(rng.choice([50.0, 75.0, 200.0])),
                    str(rng.choice(["stay", "move", "remove"])),
                )
                for p, a in holes
            ]
            # More on a plane than it may carry is another matter: see TestStay.
            if max(sum(one["plane"] == plane for one in pieces) for plane in "12") > 2:
                continue
            session, _ = opened(shared_shop, pieces)
            plan = planned(shared_shop, session)
            holds(plan, pieces)
            assert_done(pieces, plan)

    def test_a_check_run_comes_out_as_predicted_and_nothing_is_left_to_do(self, shop: Workshop) -> None:
        session, _ = opened(shop, SEVERAL)
        plan = planned(shop, session)
        assert_done(SEVERAL, plan)
        shop.fit(plan)
        readings = DRUM.readings(net(plan))
        run = shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": readings})
        assert DRUM.vibration(run["masses"]) == pytest.approx(DRUM.vibration(net(plan)), abs=1e-9)
        assert vectors(run["readings"]) == pytest.approx(vectors(plan["predicted"]), abs=1e-9)
        again = planned(shop, session)
        assert again["placements"] == plan["placements"]
        assert {c["action"] for c in again["changes"]} <= {"keep"}
        assert again["objective_value"] == pytest.approx(plan["objective_value"], rel=1e-6)

    def test_more_is_added_to_what_is_on_now(self, shop: Workshop) -> None:
        session, box = opened(shop, SEVERAL)
        first = shop.fit(planned(shop, session, max_masses_per_plane=1))
        before = shop.on_hand(box)
        added = planned(shop, session, base="present")
        assert added["objective_value"] <= first["objective_value"] * (1.0 + SAME)
        kept = {(p["plane"], p["position_deg"], p["mass_g"]) for p in first["fitted"]}
        assert kept <= {(p["plane"], p["position_deg"], p["mass_g"]) for p in added["placements"]}
        off = {(p["plane"], p["position_deg"], p["mass_g"]) for p in first["taken_off"]}
        assert off <= {(p["plane"], p["position_deg"], p["mass_g"]) for p in added["taken_off"]}
        assert {("keep", *one) for one in kept} <= actions(added)
        assert vectors(added["predicted"]) == pytest.approx(DRUM.vibration(net(added)), abs=1e-9)
        shop.fit(added)
        new = [p["mass_g"] for p in added["placements"] if p["from_box"]]
        old = [p["mass_g"] for p in first["fitted"] if p["from_box"]]
        assert shop.on_hand(box) == {g: n + old.count(g) - new.count(g) for g, n in before.items()}
        run = shop.post(f"/sessions/{session}/runs", {"kind": "check", "readings": DRUM.readings(net(added))})
        assert DRUM.vibration(run["masses"]) == pytest.approx(vectors(added["predicted"]), abs=1e-9)

    def test_taking_a_plan_off_puts_everything_back(self, shop: Workshop) -> None:
        session, box = opened(shop, SEVERAL)
        plan = shop.fit(planned(shop, session))
        unfitted = shop.ask("POST", f"/plans/{plan['id']}/unfit")
        assert (unfitted["state"], unfitted["fitted"]) == ("unfitted", None)
        assert shop.on_hand(box) == dict(BOX)
        again = planned(shop, session)
        assert again["placements"] == plan["placements"]
        assert actions(again) == actions(plan) - {LAST_TRIAL}
        assert again["inputs"]["present_off"] == []

    def test_the_log_gives_the_same_answers_again(self, shop: Workshop) -> None:
        session, _ = opened(shop, SEVERAL)
        shop.fit(planned(shop, session, max_masses_per_plane=1, alternatives=2))
        shop.fit(planned(shop, session, base="present"))
        planned(shop, session)
        log = shop.get(f"/sessions/{session}/log")
        again = resolve(read_log(json.dumps(log)), shop.work.monotonic)
        assert again.changed == ()
        for was, now in zip(log["plans"], again.plans, strict=True):
            assert [(c["action"], c["placement"]["hole"]) for c in was["changes"]] == [
                (c.action, c.placement.hole) for c in now.changes
            ]
            assert len(was["taken_off"]) == len(now.taken_off)
            assert was["objective_value"] == pytest.approx(now.objective_value, rel=SAME)
            assert [a["objective_value"] for a in was["alternatives"]] == pytest.approx(
                [a.objective_value for a in now.alternatives], rel=SAME
            )

    def test_front_and_what_if_know_of_them(self, shared_shop: Workshop) -> None:
        session, _ = opened(shared_shop, SEVERAL)
        plan = planned(shared_shop, session)
        points = shared_shop.get(f"/plans/{plan['id']}/front")
        assert points[-1]["offer"]["objective_value"] == pytest.approx(plan["objective_value"], rel=SAME)
        assert len(points[0]["offer"]["taken_off"]) == 2  # nothing but what must stay
        answer = shared_shop.post(f"/plans/{plan['id']}/what-if", {"missing": [{"mass_g": 200.0}]})
        expected = best(SEVERAL, box={**BOX, 200.0: 1})
        assert answer["offer"]["objective_value"] == pytest.approx(expected, rel=SAME)


@pytest.mark.parametrize(
    ("entry", "field"),
    [
        (piece("1", 10.0, 50.0, "stay"), "on_rotor[0].position_deg"),
        (piece("1", 50.01, 50.0, "move"), "on_rotor[0].position_deg"),
        (piece("9", 50.0, 50.0, "stay"), "on_rotor[0].plane"),
        (piece("1", 50.0, 0.0, "stay"), "on_rotor[0].mass_g"),
        (piece("1", 50.0, -5.0, "remove"), "on_rotor[0].mass_g"),
        (piece("1", 400.0, 5.0, "remove"), "on_rotor[0].position_deg"),
        (piece("1", 50.0, 50.0, "vanish"), "on_rotor[0].may"),
    ],
)
def test_what_cannot_be_on_a_rotor(shared_shop: Workshop, entry: dict[str, Any], field: str) -> None:
    machine = shared_shop.machine(**tiny_machine())
    body = {"machine_id": machine, "on_rotor": [entry]}
    assert shared_shop.refused("POST", "/sessions", body, 422, "invalid_input")["field"] == field


def test_360_is_0_for_them_too(shared_shop: Workshop) -> None:
    pieces = [piece("1", 360.0, 200.0, "remove"), piece("2", -310.0, 10.0, "stay")]
    session, _ = opened(shared_shop, pieces)
    plan = planned(shared_shop, session)
    assert [(p["plane"], p["position_deg"]) for p in plan["taken_off"]] == [("1", 0.0)]
    assert ("2", 50.0) not in {(p["plane"], p["position_deg"]) for p in plan["placements"]}
