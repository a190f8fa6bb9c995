"""The fewest masses that meet a limit, or why none do, judged by trying everything."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.support.http.every_selection import BOX, tiny_machine
from tests.support.http.tiny_bench import ALL, EVERYTHING, SAME, Bench, bench_on, pieces_of_none, tiny_box
from tests.support.http.workshop import Workshop


class TestFewest:
    @pytest.mark.parametrize(("objective", "norm"), ALL[:3] + ALL[4:])
    def test_the_fewest_that_meet_the_limit(self, bench: Bench, objective: str, norm: str | None) -> None:
        # A mode of its own measures the residual by the worst sensor where no norm is stated.
        values = EVERYTHING.values(objective, norm or "max")
        for share in (0.0, 0.05, 0.3, 0.7, 1.5):
            limit = float(values.min() + share * (values[pieces_of_none()] - values.min())) * (1.0 + 1e-6)
            within = values <= limit
            fewest = EVERYTHING.pieces[within].min()
            plan = bench.plan(objective=objective, norm=norm, mode="fewest", limit=limit)
            assert plan["status"] == "optimal"
            assert len(plan["placements"]) == fewest
            best = values[within & (EVERYTHING.pieces == fewest)].min()
            assert plan["objective_value"] == pytest.approx(best, rel=SAME)
            assert plan["lower_bound"] <= best * (1.0 + SAME)
            said = {0: "the limit is met without any piece", 1: "1 piece meets the limit"}
            assert said.get(int(fewest), f"{fewest} pieces meet the limit") in plan["message"]

    def test_every_sensor_within_its_own_limit(self, shared_shop: Workshop) -> None:
        """Without a limit of its own the mode asks for that: here the limits allow it with three pieces."""
        values, pieces = EVERYTHING.values("residual_vibration", "max"), EVERYTHING.pieces
        three = values[pieces == 3].min() * 0.2 * (1.0 + 1e-6)
        machine = shared_shop.machine(**tiny_machine(), sensors=[{"name": s, "limit": three} for s in "PQ"])
        session = shared_shop.session(machine, tiny_box(shared_shop, dict(BOX)))
        shared_shop.learn(session)
        plan = shared_shop.plan(
            session, shared_shop.correct(session), mode="fewest", method="certified", max_masses_per_plane=None
        )
        fewest = pieces[values * 0.2 <= three].min()
        assert (plan["status"], len(plan["placements"])) == ("optimal", fewest)
        assert all(vector["amplitude"] <= three for vector in plan["predicted"])

    def test_a_limit_that_nothing_meets(self, bench: Bench) -> None:
        plan = bench.plan(mode="fewest")  # every sensor within 0.2 mm/s: not with this box
        nearest = EVERYTHING.best("residual_vibration", "max")
        assert nearest > 1.0
        assert (plan["status"], plan["placements"], plan["objective_value"]) == ("infeasible", [], None)
        assert (plan["changes"], plan["predicted"], plan["alternatives"], plan["gap"]) == ([], [], [], None)
        assert f"leaves {nearest:.4g}, the limit is 1" in plan["reason"]
        assert "no single change is enough" in plan["reason"]
        problem = bench.shop.refused("POST", f"/plans/{plan['id']}/fitted", {}, 409, "plan_infeasible")
        assert plan["reason"] in problem["detail"]
        answer = bench.what_if(plan)
        assert (answer["offer"]["status"], answer["worse_by"]) == ("infeasible", None)
        assert answer["offer"]["reason"] == plan["reason"]

    def test_what_would_help_does_help(self, bench: Bench) -> None:
        """Every piece that the reason would buy, bought, meets the limit; every other does not."""
        limit = EVERYTHING.best("residual_vibration", "max") * 0.98
        plan = bench.plan(mode="fewest", limit=limit)
        assert plan["status"] == "infeasible"
        for grams in BOX:
            said = f"one more {grams:g} g piece" in plan["reason"]
            meets = EVERYTHING.but(box={**BOX, grams: BOX[grams] + 1}).best("residual_vibration", "max") <= limit
            assert said == meets
            offer = bench.what_if(plan, bought=[{"mass_g": grams}])["offer"]
            assert (offer["status"] == "optimal") == meets
        assert ("one more piece in each plane" in plan["reason"]) == (
            EVERYTHING.but(most=(3, 3)).best("residual_vibration", "max") <= limit
        )

    @pytest.mark.parametrize(
        ("request_", "field"),
        [
            ({"method": "modified_jaya"}, "method"),
            ({"objective": "components"}, "limit"),
            ({"objective": "bearing_force"}, "limit"),
            ({"norm": "sum"}, "limit"),
            ({"norm": "rms"}, "limit"),
            ({"limit": 0.0}, "limit"),
            ({"limit": -1.0}, "limit"),
            ({"limit": math.nan}, "limit"),
            ({"alternatives": 1, "limit": 1.0}, "alternatives"),
            ({"slack": 1.0, "limit": 1.0}, "slack"),
        ],
    )
    def test_what_cannot_be_proved_or_meant(self, bench: Bench, request_: Any, field: str) -> None:
        body = {"correction_id": bench.correction["id"], "objective": "residual_vibration", "mode": "fewest"}
        path = f"/sessions/{bench.session}/plans"
        if isinstance(request_.get("limit"), float) and math.isnan(request_["limit"]):
            text = f'{{"correction_id": "{body["correction_id"]}", "objective": "components", "limit": NaN}}'
            problem = bench.shop.refused("POST", path, text.encode(), 422, "invalid_input")
        else:
            problem = bench.refused(**{**body, **request_})
        assert problem["field"] == field

    @pytest.mark.parametrize(
        ("request_", "field"),
        [
            ({"method": "modified_jaya", "alternatives": 1}, "alternatives"),
            ({"method": "modified_jaya", "slack": 1.0}, "slack"),
            ({"limit": 1.0}, "limit"),
        ],
    )
    def test_what_the_method_or_mode_would_ignore(self, bench: Bench, request_: Any, field: str) -> None:
        assert bench.refused(**request_)["field"] == field

    def test_as_few_masses_are_all_that_is_spoken_of(self, bench: Bench) -> None:
        """More masses may be better: no plan of this mode, and no point of a front, says otherwise."""
        values = EVERYTHING.values("components")
        plan = bench.plan(objective="components", mode="fewest", limit=float(values.min() * 30.0))
        assert plan["objective_value"] > values.min() * (1.0 + SAME)
        assert plan["message"].endswith("proved: no selection of as few pieces is better")
        for point in bench.front(bench.plan(objective="components"))[:-1]:
            assert point["offer"]["message"] == "proved: no selection of as few pieces is better"

    def test_pieces_that_stay_are_told_apart(self, shop: Workshop) -> None:
        one = bench_on(shop)
        shop.fit(one.plan(max_masses_per_plane=1))
        values = EVERYTHING.values("residual_vibration", "max")
        plan = one.plan(base="present", mode="fewest", limit=float(values.min() * 3.0))
        assert plan["status"] == "optimal"
        chosen_now = len(plan["placements"]) - 2
        assert plan["message"].startswith(f"{chosen_now} piece")
        assert plan["message"].endswith("(pieces besides the 2 that stay)")
