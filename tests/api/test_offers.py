"""What a plan offers, judged by trying everything: the best with proof, the next best, the front, what if, fewest."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from tests.api.every_selection import BOX, EverySelection, tiny_machine
from tests.api.workshop import DRUM, LinearDrum, Workshop, machine_body, mass, on_rotor, reading, vector_of

EVERYTHING = EverySelection()
ALL = [
    ("components", None),
    ("bearing_force", None),
    ("residual_vibration", None),
    ("residual_vibration", "sum"),
    ("residual_vibration", "max"),
    ("residual_vibration", "rms"),
]
SAME = 1e-9


@dataclass(frozen=True)
class Bench:
    """A session on the tiny drum, with its correction."""

    shop: Workshop
    session: str
    box: str
    correction: Any

    def plan(self, **request: Any) -> Any:
        """A plan by the exact search unless the request says otherwise."""
        usual = {"method": "exact", "max_masses_per_plane": None}
        return self.shop.plan(self.session, self.correction, **{**usual, **request})

    def refused(self, status: int = 422, code: str = "invalid_input", **request: Any) -> Any:
        """The problem that a request for a plan is answered with."""
        body = {"correction_id": self.correction["id"], "objective": "residual_vibration", **request}
        return self.shop.refused("POST", f"/sessions/{self.session}/plans", body, status, code)

    def what_if(self, plan: Any, **asked: Any) -> Any:
        """The plan under other circumstances."""
        return self.shop.post(f"/plans/{plan['id']}/what-if", asked)

    def front(self, plan: Any) -> Any:
        """The front of a plan."""
        return self.shop.get(f"/plans/{plan['id']}/front")


def tiny_box(shop: Workshop, box: dict[float, int | None]) -> str:
    """A stored box with these counts."""
    items = [{"mass_g": grams, "count": count} for grams, count in box.items()]
    return str(shop.post("/catalogues", {"name": f"tiny {shop.count('catalogue')}", "items": items})["id"])


def bench_on(shop: Workshop, box: dict[float, int | None] | None = None, drum: LinearDrum = DRUM) -> Bench:
    """A bench of its own."""
    stored = tiny_box(shop, box or dict(BOX))
    session = shop.session(shop.machine(**tiny_machine()), stored)
    shop.learn(session, drum)
    return Bench(shop, session, stored, shop.correct(session))


@pytest.fixture(scope="module")
def bench(shared_shop: Workshop) -> Bench:
    """A bench that tests share: they only add plans to it."""
    return bench_on(shared_shop)


@pytest.fixture(scope="module")
def noisy(shared_shop: Workshop) -> Bench:
    """Six masses a plane of twelve kinds, and readings that scatter."""
    box = shared_shop.box(count=4, masses=[10.0, 15.0, 20.0, 25.0, 30.0, *(10.0 * n for n in range(4, 11))])
    planes = [{**plane, "max_masses": 6} for plane in machine_body()["planes"]]
    session = shared_shop.session(shared_shop.machine(planes=planes), box)
    rng = np.random.default_rng(8)
    for masses in ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)]):
        readings = [
            reading(s, v + complex(*rng.normal(0.0, 0.02, 2)), scatter=0.02) for s, v in DRUM.vibration(masses).items()
        ]
        kind = "trial" if masses else "initial"
        shared_shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})
    return Bench(shared_shop, session, box, shared_shop.correct(session))


def answer_of(plan: Any) -> Any:
    """A plan without what differs from one to the next by its nature."""
    return {key: value for key, value in plan.items() if key not in ("id", "number", "created_at", "seconds")} | {
        "per_method": [{**part, "seconds": None} for part in plan["per_method"]]
    }


def chosen(offer: Any) -> tuple[tuple[str, float, float], ...]:
    """The selection of an offer."""
    return tuple((p["plane"], p["position_deg"], p["mass_g"]) for p in offer["placements"])


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

    def test_a_plan_from_another_box_is_not_answered_with_this_one(self, shop: Workshop) -> None:
        one = bench_on(shop)
        plan = one.plan()
        shop.ask("PATCH", f"/sessions/{one.session}", {"catalogue_id": shop.box()})
        problem = shop.refused("POST", f"/plans/{plan['id']}/what-if", {}, 409, "box_changed")
        assert problem["field"] == "catalogue_id"
        shop.refused("GET", f"/plans/{plan['id']}/front", None, 409, "box_changed")
        shop.refused("POST", f"/plans/{plan['id']}/fitted", {}, 409, "box_changed")

    def test_nothing_is_stored(self, bench: Bench) -> None:
        plan = bench.plan()
        before = bench.shop.rows()
        bench.what_if(plan, missing=[{"mass_g": 200.0}], bought=[{"mass_g": 50.0}])
        bench.front(plan)
        assert bench.shop.rows() == before

    def test_unknown_plan(self, shared_shop: Workshop) -> None:
        shared_shop.refused("POST", "/plans/none/what-if", {}, 404, "not_found")
        shared_shop.refused("GET", "/plans/none/front", None, 404, "not_found")


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
            assert f"{fewest} pieces meet the limit" in plan["message"]

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


def pieces_of_none() -> int:
    """Index of the selection without any piece."""
    return EVERYTHING.all.index(())


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
        for steps in range(5, 230, 8):
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
