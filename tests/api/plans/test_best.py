"""The best plan with its proof, and fewer masses within a slack of it, judged by trying everything."""

from __future__ import annotations

import cmath

import numpy as np
import pytest

from tests.support.http.tiny_bench import ALL, EVERYTHING, SAME, Bench, answer_of, bench_on, chosen
from tests.support.http.workshop import LinearDrum, Workshop, vector_of


class TestBest:
    @pytest.mark.parametrize(("objective", "norm"), ALL)
    def test_certified_is_the_best_of_all(self, bench: Bench, objective: str, norm: str | None) -> None:
        plan = bench.plan(objective=objective, norm=norm, method="certified")
        assert plan["status"] == "optimal"
        assert chosen(plan) in EVERYTHING.all
        assert plan["objective_value"] == pytest.approx(EVERYTHING.best(objective, norm), rel=SAME)
        assert plan["objective_value"] == pytest.approx(EVERYTHING.value_of(plan["placements"], objective, norm))
        assert plan["lower_bound"] == pytest.approx(plan["objective_value"], rel=SAME)
        assert plan["gap"] == pytest.approx(plan["objective_value"] - plan["lower_bound"])
        first, exact = plan["per_method"]
        assert (first["method"], exact["method"]) == ("modified_jaya", "exact")
        assert (first["status"], first["lower_bound"]) == ("heuristic", None)
        assert first["objective_value"] >= EVERYTHING.best(objective, norm) * (1.0 - SAME)
        assert (exact["status"], exact["objective_value"]) == ("optimal", plan["objective_value"])
        assert plan["evaluations"] == first["evaluations"] + exact["evaluations"]
        alone = bench.plan(objective=objective, norm=norm)
        assert (alone["placements"], len(alone["per_method"])) == (plan["placements"], 1)

    @pytest.mark.parametrize(("objective", "norm"), ALL[:2])
    def test_modified_jaya_alone_proves_nothing(self, bench: Bench, objective: str, norm: str | None) -> None:
        plan = bench.plan(objective=objective, norm=norm, method="modified_jaya")
        assert (plan["status"], plan["lower_bound"], plan["gap"]) == ("heuristic", None, None)
        assert "nothing is proved" in plan["message"]
        assert chosen(plan) in EVERYTHING.all
        assert plan["objective_value"] >= EVERYTHING.best(objective, norm) * (1.0 - SAME)
        assert plan["objective_value"] == pytest.approx(EVERYTHING.value_of(plan["placements"], objective, norm))
        assert [part["method"] for part in plan["per_method"]] == ["modified_jaya"]
        assert answer_of(bench.plan(objective=objective, norm=norm, method="modified_jaya")) == answer_of(plan)

    def test_other_drums(self, shared_shop: Workshop) -> None:
        rng = np.random.default_rng(4)
        for _ in range(2):
            initial = {s: cmath.rect(rng.uniform(0.5, 6.0), rng.uniform(0.0, 6.28)) for s in "PQ"}
            influence = {
                (s, p): cmath.rect(rng.uniform(0.01, 0.02) if near else rng.uniform(0.001, 0.008), rng.uniform(0, 6.28))
                for s, p, near in (("P", "1", True), ("P", "2", False), ("Q", "1", False), ("Q", "2", True))
            }
            drum = LinearDrum(initial, influence)
            one, every = bench_on(shared_shop, drum=drum), EVERYTHING.but(drum=drum)
            for objective, norm in ALL[:3] + ALL[4:]:
                plan = one.plan(objective=objective, norm=norm)
                assert plan["objective_value"] == pytest.approx(every.best(objective, norm), rel=1e-7), drum
                assert plan["status"] == "optimal"

    def test_weights_multiply_the_shares_of_the_limit(self, bench: Bench) -> None:
        even, twice = bench.plan(), bench.plan(weights=[2.0, 2.0])
        assert twice["objective_value"] == pytest.approx(2.0 * even["objective_value"])
        assert twice["placements"] == even["placements"]
        one_sided = bench.plan(weights=[1e3, 1e-3])
        at_p = [abs(vector_of(plan["predicted"][0])) for plan in (one_sided, even)]
        assert at_p[0] < at_p[1]

    def test_misplaced_pieces_can_do_no_more_than_is_said(self, bench: Bench) -> None:
        plan = bench.plan(angle_tolerance_deg=3.0)
        rng = np.random.default_rng(1)
        for off in rng.uniform(-3.0, 3.0, (200, len(plan["placements"]))):
            moved = [{**p, "position_deg": p["position_deg"] + d} for p, d in zip(plan["placements"], off, strict=True)]
            change = EVERYTHING.value_of(moved, "residual_vibration") - plan["objective_value"]
            assert abs(change) <= plan["placement_spread"] + SAME
        assert bench.plan()["placement_spread"] is None


@pytest.mark.arithmetic
class TestSlack:
    @pytest.mark.parametrize(("objective", "norm"), ALL[:3])
    def test_fewer_pieces_then_less_mass_within_it(self, bench: Bench, objective: str, norm: str | None) -> None:
        values = EVERYTHING.values(objective, norm)
        best = bench.plan(objective=objective, norm=norm)
        for slack in (0.02 * values.min(), 0.5 * values.min(), 3.0 * values.min()):
            plan = bench.plan(objective=objective, norm=norm, slack=float(slack))
            within = values <= (values.min() + slack) * (1.0 + SAME)
            fewest = EVERYTHING.pieces[within].min()
            lightest = EVERYTHING.grams[within & (EVERYTHING.pieces == fewest)].min()
            assert len(plan["placements"]) == fewest
            assert sum(p["mass_g"] for p in plan["placements"]) == pytest.approx(lightest)
            assert plan["objective_value"] == pytest.approx(EVERYTHING.value_of(plan["placements"], objective, norm))
            assert plan["lower_bound"] == pytest.approx(best["objective_value"], rel=SAME)
            assert plan["gap"] == pytest.approx(plan["objective_value"] - best["objective_value"], abs=SAME)
        assert fewest < len(best["placements"])

    def test_none_changes_nothing(self, bench: Bench) -> None:
        plain, none = bench.plan(), bench.plan(slack=0.0)
        assert answer_of(none) == answer_of(plain)

    @pytest.mark.parametrize("limit_s", [2e-6, 2e-5, 5e-5, 1e-4, 2e-4, 1e-3])
    def test_without_time_to_use_it_the_plan_says_so(self, bench: Bench, limit_s: float) -> None:
        """The tests' stop-watch goes on by a microsecond whenever it is read."""
        values = EVERYTHING.values("components")
        slack = 3.0 * float(values.min())
        plan = bench.plan(objective="components", slack=slack, time_limit_s=limit_s)
        if plan["status"] == "optimal":
            assert plan["objective_value"] <= (values.min() + slack) * (1.0 + SAME)
        if plan["slack_proved"]:
            within = values <= (plan["lower_bound"] + slack) * (1.0 + SAME)
            assert len(plan["placements"]) == EVERYTHING.pieces[within].min()
            assert "stopped" not in plan["message"]
        else:
            assert plan["slack_proved"] is False
            assert "; stopped before" in plan["message"]

    def test_a_plan_tells_whether_the_slack_is_used_to_the_end(self, bench: Bench) -> None:
        values = EVERYTHING.values("components")
        slack = 3.0 * float(values.min())
        told = [
            bench.plan(objective="components", slack=slack, time_limit_s=limit_s)["slack_proved"]
            for limit_s in (2e-6, 1.0)
        ]
        assert told == [False, True]
        assert bench.plan(objective="components")["slack_proved"] is None
        plan = bench.plan(objective="components", slack=slack)
        assert bench.what_if(plan)["offer"]["slack_proved"] is True
