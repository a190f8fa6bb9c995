"""Plans that end early: at their deadline, or where the measurement cannot tell more."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.http.tiny_bench import EVERYTHING, SAME, Bench, answer_of, chosen
from tests.support.http.workshop import DRUM, on_rotor, vector_of


@pytest.mark.arithmetic
class TestDeadline:
    @pytest.mark.parametrize("limit_s", [1e-6, 3e-5, 1e-3])
    @pytest.mark.parametrize("method", ["certified", "modified_jaya"])
    def test_the_best_so_far_with_an_honest_bound(self, bench: Bench, method: str, limit_s: float) -> None:
        """The tests' stop-watch goes on by a microsecond whenever it is read: the same step for everybody."""
        plan = bench.plan(method=method, time_limit_s=limit_s, alternatives=0 if method == "modified_jaya" else 3)
        best = EVERYTHING.best()
        assert chosen(plan) in EVERYTHING.all
        assert plan["objective_value"] >= best * (1.0 - SAME)
        if method == "modified_jaya":
            assert (plan["status"], plan["lower_bound"]) == ("heuristic", None)
        else:
            assert plan["status"] in ("limit_reached", "optimal")
            assert plan["lower_bound"] <= best * (1.0 + SAME)
            assert (plan["status"] == "optimal") <= (plan["objective_value"] <= best * (1.0 + SAME))
        ranked = np.sort(EVERYTHING.values("residual_vibration"))
        for rank, offer in enumerate(plan["alternatives"], start=1):
            assert offer["lower_bound"] <= best * (1.0 + SAME)
            if offer["status"] == "optimal":
                assert offer["objective_value"] == pytest.approx(ranked[rank], rel=SAME)

    def test_every_step_of_a_search(self, bench: Bench) -> None:
        """Ended after any number of steps, a plan never calls something optimal that is not."""
        ranked = np.sort(EVERYTHING.values("components"))
        statuses = set()
        for steps in range(1, 60, 5):
            plan = bench.plan(objective="components", method="exact", alternatives=5, time_limit_s=1e-6 * steps)
            offers = [plan, *plan["alternatives"]]
            statuses |= {offer["status"] for offer in offers}
            for rank, offer in enumerate(offers):
                assert offer["lower_bound"] <= ranked[0] * (1.0 + SAME)
                if offer["status"] == "optimal":
                    assert offer["objective_value"] == pytest.approx(ranked[rank], rel=SAME)
        assert statuses == {"optimal", "limit_reached"}

    @pytest.mark.parametrize("limit_s", [1e-6, 1e-5, 1e-4])
    def test_modes_and_fronts_end_too(self, bench: Bench, limit_s: float) -> None:
        values = EVERYTHING.values("residual_vibration", "max")
        plan = bench.plan(mode="fewest", limit=float(values.min()) * 1.01, time_limit_s=limit_s)
        assert plan["status"] in ("limit_reached", "optimal", "infeasible")
        assert plan["status"] != "infeasible"
        if plan["status"] == "optimal":
            assert len(plan["placements"]) == EVERYTHING.pieces[values <= values.min() * 1.01].min()
        bench.plan(slack=1.0, time_limit_s=limit_s)
        plain = bench.plan(time_limit_s=limit_s)
        sums = EVERYTHING.values("residual_vibration")
        for point in bench.front(plain):
            best = sums[EVERYTHING.pieces <= point["pieces"]].min()
            assert (
                point["offer"]["lower_bound"] <= best * (1.0 + SAME) <= point["offer"]["objective_value"] * (1 + 1e-8)
            )
        assert bench.what_if(plain)["offer"]["objective_value"] >= EVERYTHING.best() * (1.0 - SAME)

    def test_without_time_for_the_fewest_some_that_meet_the_limit(self, bench: Bench) -> None:
        """Wherever the proof is cut short, what is said holds, and masses that meet the limit are not kept back."""
        values = EVERYTHING.values("residual_vibration", "max")
        limit = float(values.min()) * 1.3
        fewest = EVERYTHING.pieces[values <= limit].min()
        met_without_proof = 0
        for steps in range(5, 400, 14):
            plan = bench.plan(mode="fewest", limit=limit, time_limit_s=1e-6 * steps)
            assert plan["lower_bound"] <= plan["objective_value"] * (1.0 + SAME)
            if plan["status"] == "optimal":
                assert len(plan["placements"]) == fewest
                continue
            assert plan["status"] == "limit_reached"
            if "fewer do not" in plan["message"]:
                # How few is proved, only not that no other choice of as many is better.
                assert len(plan["placements"]) == fewest
            else:
                assert int(plan["message"].split("fewer than ")[1].split()[0]) <= fewest
            if plan["objective_value"] <= limit:
                assert fewest <= len(plan["placements"])
                met_without_proof += 1
        assert plan["status"] == "optimal"
        assert met_without_proof


@pytest.mark.arithmetic
class TestUncertainty:
    @pytest.mark.parametrize(("objective", "norm"), [("residual_vibration", "sum"), ("components", None)])
    def test_what_the_measurement_cannot_tell_is_not_searched_for(
        self, noisy: Bench, objective: str, norm: str | None
    ) -> None:
        plan = noisy.plan(objective=objective, norm=norm, method="certified")
        assert plan["objective_scatter"] > 0.0
        assert plan["status"] in ("within_uncertainty", "optimal")
        assert plan["lower_bound"] is not None
        assert 0.0 <= plan["gap"] <= plan["objective_scatter"]
        if plan["status"] == "within_uncertainty":
            assert "less than can be measured" in plan["message"]
        assert answer_of(noisy.plan(objective=objective, norm=norm, method="certified")) == answer_of(plan)

    def test_alternatives_are_then_no_more_than_they_are(self, noisy: Bench) -> None:
        plan = noisy.plan(alternatives=5)
        for offer in plan["alternatives"]:
            assert offer["status"] in ("optimal", "within_uncertainty")
            assert offer["gap"] == pytest.approx(offer["objective_value"] - offer["lower_bound"])
            if offer["status"] == "within_uncertainty":
                assert offer["gap"] <= plan["objective_scatter"]

    def test_the_scatter_is_what_repeated_sessions_show(self, noisy: Bench) -> None:
        """The standard deviation of each prediction, joined; the readings' scatter is that of a real component."""
        plan = noisy.plan()
        each = [math.sqrt(2.0) * vector["scatter"] / 0.2 for vector in plan["predicted"]]
        assert plan["objective_scatter"] == pytest.approx(math.hypot(*each), rel=0.1)

    def test_without_scatter_the_proof_is_whole(self, bench: Bench) -> None:
        assert bench.plan()["objective_scatter"] is None

    def test_the_prediction_is_that_of_the_drum(self, bench: Bench) -> None:
        plan = bench.plan()
        expected = DRUM.vibration(on_rotor(plan["placements"]))
        assert {v["sensor"]: vector_of(v) for v in plan["predicted"]} == pytest.approx(expected, abs=1e-9)
