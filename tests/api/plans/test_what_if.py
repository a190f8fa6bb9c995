"""A plan under other circumstances, judged by trying everything."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.http.every_selection import BOX
from tests.support.http.tiny_bench import EVERYTHING, SAME, Bench, bench_on
from tests.support.http.workshop import Workshop


class TestWhatIf:
    def test_a_piece_that_the_plan_uses_is_missing(self, bench: Bench) -> None:
        plan = bench.plan()
        for grams in {p["mass_g"] for p in plan["placements"]}:
            answer = bench.what_if(plan, missing=[{"mass_g": grams}])
            expected = EVERYTHING.but(box={**BOX, grams: BOX[grams] - 1}).best()
            assert answer["offer"]["objective_value"] == pytest.approx(expected, rel=SAME)
            assert answer["worse_by"] == pytest.approx(expected - plan["objective_value"], abs=SAME)
            assert answer["worse_by"] >= 0.0
            assert (answer["objective_value"], answer["objective_unit"]) == (plan["objective_value"], "1")
            assert answer["offer"]["status"] == "optimal"

    def test_a_piece_is_bought(self, bench: Bench) -> None:
        plan = bench.plan(objective="components")
        for grams in BOX:
            answer = bench.what_if(plan, bought=[{"mass_g": grams, "pieces": 2}])
            expected = EVERYTHING.but(box={**BOX, grams: BOX[grams] + 2}).best("components")
            assert answer["offer"]["objective_value"] == pytest.approx(expected, rel=SAME)
            assert answer["worse_by"] <= SAME
            assert answer["objective_unit"] == "g.mm"

    def test_a_hole_is_blocked(self, bench: Bench) -> None:
        first = bench.plan()["placements"][0]
        already = {"plane": first["plane"], "position_deg": first["position_deg"]}
        plan = bench.plan(blocked=[already])
        for used in plan["placements"]:
            hole = {"plane": used["plane"], "position_deg": used["position_deg"] - 360.0}
            answer = bench.what_if(plan, blocked=[hole])
            taken = frozenset((p["plane"], p["position_deg"]) for p in (already, used))
            assert not taken & {(p["plane"], p["position_deg"]) for p in answer["offer"]["placements"]}
            assert answer["offer"]["objective_value"] == pytest.approx(EVERYTHING.but(taken=taken).best(), rel=SAME)

    def test_everything_at_once_and_nothing_at_all(self, bench: Bench) -> None:
        plan = bench.plan(alternatives=2)
        same = bench.what_if(plan)
        assert (same["offer"]["placements"], same["worse_by"]) == (plan["placements"], 0.0)
        both = bench.what_if(plan, missing=[{"mass_g": 50.0, "pieces": 2}], bought=[{"mass_g": 120.0}])
        expected = EVERYTHING.but(box={50.0: 0, 120.0: 2, 200.0: 2}).best()
        assert both["offer"]["objective_value"] == pytest.approx(expected, rel=SAME)
        nothing = bench.what_if(plan, missing=[{"mass_g": grams, "pieces": many} for grams, many in BOX.items()])
        assert nothing["offer"]["placements"] == []
        assert nothing["offer"]["objective_value"] == pytest.approx(EVERYTHING.but(most=(0, 0)).best(), rel=SAME)

    @pytest.mark.parametrize(
        ("asked", "field"),
        [
            ({"missing": [{"mass_g": 200.0, "pieces": 3}]}, "missing[0].pieces"),
            ({"missing": [{"mass_g": 120.0}, {"mass_g": 120.0}]}, "missing[1].pieces"),
            ({"missing": [{"mass_g": 121.0}]}, "missing[0].mass_g"),
            ({"bought": [{"mass_g": 121.0}]}, "bought[0].mass_g"),
            ({"bought": [{"mass_g": 120.0, "pieces": 0}]}, "bought[0].pieces"),
            ({"blocked": [{"plane": "1", "position_deg": 10.0}]}, "blocked[0].position_deg"),
            ({"blocked": [{"plane": "9", "position_deg": 0.0}]}, "blocked[0].plane"),
        ],
    )
    def test_what_cannot_be(self, bench: Bench, asked: Any, field: str) -> None:
        plan = bench.plan()
        problem = bench.shop.refused("POST", f"/plans/{plan['id']}/what-if", asked, 422, "invalid_input")
        assert problem["field"] == field

    def test_unlimited_items(self, shared_shop: Workshop) -> None:
        one = bench_on(shared_shop, {50.0: None, 200.0: 1})
        plan = one.plan()
        every = EVERYTHING.but(box={50.0: 99, 200.0: 1})
        assert plan["objective_value"] == pytest.approx(every.best(), rel=SAME)
        for change in ({"missing": [{"mass_g": 50.0, "pieces": 7}]}, {"bought": [{"mass_g": 50.0}]}):
            answer = one.what_if(plan, **change)
            assert (answer["offer"]["placements"], answer["worse_by"]) == (plan["placements"], 0.0)

    def test_the_box_is_as_it_was_when_the_plan_was_made(self, shop: Workshop) -> None:
        one = bench_on(shop)
        plan = one.plan()
        asked = {"bought": [{"mass_g": 120.0}]}
        before, front = one.what_if(plan, **asked), one.front(plan)
        shop.fit(plan)
        shop.ask("PATCH", f"/catalogues/{one.box}", {"received": [{"mass_g": 120.0, "pieces": 5}]})
        assert one.what_if(plan, **asked) == before
        assert one.front(plan) == front

    def test_a_plan_from_another_box_is_answered_with_its_own(self, shop: Workshop) -> None:
        """And says so; its masses cannot be had from the session's present box."""
        one = bench_on(shop)
        plan = one.plan()
        asked = {"bought": [{"mass_g": 120.0}]}
        before, front = one.what_if(plan, **asked), one.front(plan)
        assert {before["other_box"], *(point["other_box"] for point in front)} == {None}
        shop.ask("PATCH", f"/sessions/{one.session}", {"catalogue_id": shop.box(masses=(90.0,))})
        name = shop.get(f"/catalogues/{one.box}")["name"]
        assert one.what_if(plan, **asked) == {**before, "other_box": name}
        assert one.front(plan) == [{**point, "other_box": name} for point in front]
        problem = shop.refused(
            "POST", f"/plans/{plan['id']}/what-if", {"bought": [{"mass_g": 90.0}]}, 422, "invalid_input"
        )
        assert problem["field"] == "bought[0].mass_g"
        for verb in ("fitted", "reserve"):
            problem = shop.refused("POST", f"/plans/{plan['id']}/{verb}", {}, 409, "box_changed")
            assert problem["field"] == "catalogue_id"

    def test_nothing_is_stored(self, bench: Bench) -> None:
        plan = bench.plan()
        before = bench.shop.rows()
        bench.what_if(plan, missing=[{"mass_g": 200.0}], bought=[{"mass_g": 50.0}])
        bench.front(plan)
        assert bench.shop.rows() == before

    def test_unknown_plan(self, shared_shop: Workshop) -> None:
        shared_shop.refused("POST", "/plans/none/what-if", {}, 404, "not_found")
        shared_shop.refused("GET", "/plans/none/front", None, 404, "not_found")
