"""The next best plans, and the front of residual against pieces, judged by trying everything."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.support.http.tiny_bench import ALL, EVERYTHING, SAME, Bench, bench_on, chosen
from tests.support.http.workshop import Workshop


class TestAlternatives:
    @pytest.mark.parametrize(("objective", "norm"), ALL[:3] + ALL[4:])
    def test_the_next_best_in_order(self, bench: Bench, objective: str, norm: str | None) -> None:
        plan = bench.plan(objective=objective, norm=norm, alternatives=12)
        offers = [plan, *plan["alternatives"]]
        assert len({chosen(offer) for offer in offers}) == 13
        assert all(chosen(offer) in EVERYTHING.all for offer in offers)
        found = [offer["objective_value"] for offer in offers]
        assert found == sorted(found)
        assert found == pytest.approx(np.sort(EVERYTHING.values(objective, norm))[:13], rel=SAME)
        for offer in offers:
            assert offer["status"] == "optimal"
            assert offer["objective_value"] == pytest.approx(EVERYTHING.value_of(offer["placements"], objective, norm))
            assert offer["gap"] == pytest.approx(offer["objective_value"] - offer["lower_bound"])
            assert offer["lower_bound"] <= found[0]
        assert plan["placements"] == bench.plan(objective=objective, norm=norm)["placements"]

    def test_an_alternative_does_not_say_that_nothing_is_better(self, bench: Bench) -> None:
        plan = bench.plan(alternatives=2)
        said = [offer["message"] for offer in (plan, *plan["alternatives"])]
        assert "no selection within the limits is better" in said[0]
        assert [("1 selection" in said[1]), ("2 selections" in said[2])] == [True, True], said

    def test_all_there_are(self, shared_shop: Workshop) -> None:
        """One piece in the box: 12 holes or none, and that is all."""
        plan = bench_on(shared_shop, {200.0: 1}).plan(alternatives=20)
        assert len({chosen(offer) for offer in (plan, *plan["alternatives"])}) == 13

    def test_a_long_search_does_not_end_with_the_best_alone(self, shared_shop: Workshop) -> None:
        """Many selections: the search takes more steps than the best by itself needs."""
        box = shared_shop.box(count=3, masses=(5.0, 10.0, 20.0, 50.0, 70.0, 100.0))
        session = shared_shop.session(box=box)
        shared_shop.learn(session)
        correction = shared_shop.correct(session)
        request = {"max_masses_per_plane": 3, "objective": "components"}
        few = shared_shop.plan(session, correction, **request, alternatives=3)
        many = shared_shop.plan(session, correction, **request, alternatives=20)
        values = [offer["objective_value"] for offer in many["alternatives"]]
        assert values == sorted(values)
        assert [chosen(o) for o in many["alternatives"][:3]] == [chosen(o) for o in few["alternatives"]]
        assert {offer["status"] for offer in (many, *many["alternatives"])} == {"optimal"}


class TestFront:
    @pytest.mark.parametrize(("objective", "norm"), ALL[:3] + ALL[4:])
    def test_each_point_is_the_best_of_so_many(self, bench: Bench, objective: str, norm: str | None) -> None:
        plan = bench.plan(objective=objective, norm=norm)
        points = bench.front(plan)
        values = EVERYTHING.values(objective, norm)
        assert points[0]["pieces"] == 0
        assert points[0]["offer"]["placements"] == []
        for point in points:
            best = values[EVERYTHING.pieces <= point["pieces"]].min()
            offer = point["offer"]
            assert offer["status"] == "optimal"
            assert offer["objective_value"] == pytest.approx(best, rel=SAME)
            assert offer["lower_bound"] == pytest.approx(best, rel=SAME)
            assert len(offer["placements"]) == point["pieces"]
        found = [point["offer"]["objective_value"] for point in points]
        assert all(more < fewer for fewer, more in pairwise(found))
        assert points[-1]["offer"]["objective_value"] == pytest.approx(plan["objective_value"], rel=SAME)
        skipped = set(range(int(EVERYTHING.pieces.max()) + 1)) - {point["pieces"] for point in points}
        for pieces in skipped:
            fewer = values[pieces > EVERYTHING.pieces].min()
            assert values[pieces >= EVERYTHING.pieces].min() == pytest.approx(fewer, rel=SAME)

    def test_masses_that_are_kept_count(self, shop: Workshop) -> None:
        one = bench_on(shop)
        fitted = shop.fit(one.plan(max_masses_per_plane=1))
        points = one.front(one.plan(base="present"))
        assert [point["pieces"] for point in points] == [len(point["offer"]["placements"]) for point in points]
        assert points[0]["pieces"] == len(fitted["fitted"])

    def test_blocked_holes_stay_empty(self, bench: Bench) -> None:
        blocked = [{"plane": "2", "position_deg": angle} for angle in (130.0, 180.0, 250.0)]
        every = EVERYTHING.but(taken=frozenset(("2", angle) for angle in (130.0, 180.0, 250.0)))
        points = bench.front(bench.plan(blocked=blocked))
        assert points[-1]["offer"]["objective_value"] == pytest.approx(every.best(), rel=SAME)
