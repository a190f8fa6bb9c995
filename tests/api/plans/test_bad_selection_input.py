"""Boxes, holes and requests that make no sensible selection: a clear problem, or an honest answer."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from tests.support.http.workshop import DRUM, POSITIONS, Workshop, machine_body, on_rotor, vector_of

METHODS = ["certified", "exact", "modified_jaya"]
EVERY_HOLE = [{"plane": plane, "position_deg": angle} for plane in "12" for angle in POSITIONS]


def items(*masses: object, count: object = 1) -> dict[str, Any]:
    """A box."""
    return {"name": "new", "items": [{"mass_g": grams, "count": count} for grams in masses]}


def plane(**changes: Any) -> dict[str, Any]:
    """A machine whose first plane is changed."""
    first, second = machine_body()["planes"]
    return machine_body("new", planes=[{**first, **changes}, second])


@pytest.mark.parametrize(
    ("path", "body", "field", "value"),
    [
        ("/catalogues", items(), "items", None),
        ("/catalogues", items(10.0, -20.0), "items[1].mass_g", -20.0),
        ("/catalogues", items(0.0), "items[0].mass_g", 0.0),
        ("/catalogues", items(math.nan), "items[0].mass_g", "nan"),
        ("/catalogues", items(math.inf), "items[0].mass_g", "inf"),
        ("/catalogues", items("10"), "items[0].mass_g", "10"),
        ("/catalogues", items(10.0, 20.0, 10.0), "items", 10.0),
        ("/catalogues", items(10.0, count=0), "items[0].count", 0),
        ("/catalogues", items(10.0, count=-1), "items[0].count", -1),
        ("/catalogues", items(10.0, count=1.5), "items[0].count", 1.5),
        ("/catalogues", items(*range(1, 10_002)), "items", None),
        ("/machines", plane(positions_deg=[0.0, 90.0, 360.0]), "planes[0].positions_deg", None),
        ("/machines", plane(positions_deg=[-90.0, 0.0, 270.0]), "planes[0].positions_deg", None),
        ("/machines", plane(positions_deg=[10.0, 10.0 + 1e-8]), "planes[0].positions_deg", None),
        ("/machines", plane(positions_deg=[0.0, 90.0], max_masses=3), "planes[0].max_masses", 3),
        ("/machines", plane(positions_deg=[0.0], max_masses=3, masses_per_position=2), "planes[0].max_masses", 3),
        ("/machines", plane(max_masses=0), "planes[0].max_masses", 0),
        ("/machines", plane(max_force_n=0.0), "planes[0].max_force_n", 0.0),
        ("/machines", plane(max_total_mass_g=-1.0), "planes[0].max_total_mass_g", -1.0),
    ],
)
def test_what_is_no_box_and_no_plane(
    shared_shop: Workshop, path: str, body: dict[str, Any], field: str, value: object
) -> None:
    problem = refused(shared_shop, path, body)
    assert problem["field"] == field
    assert problem["detail"]
    if value is not None:
        assert problem["value"] == value


def refused(shop: Workshop, path: str, body: dict[str, Any]) -> dict[str, Any]:
    """The problem that a body is answered with, whatever numbers are in it."""
    return shop.refused("POST", path, json.dumps(body).encode(), 422, "invalid_input")


@pytest.fixture(scope="module")
def asked(shared_shop: Workshop) -> tuple[str, Any]:
    """A session with its correction."""
    session = shared_shop.session()
    shared_shop.learn(session)
    return session, shared_shop.correct(session)


@pytest.mark.parametrize(
    ("request_", "field"),
    [
        ({"max_masses_per_plane": 0}, "max_masses_per_plane"),
        ({"max_masses_per_plane": 21}, "max_masses_per_plane"),
        ({"blocked": [{"plane": "1", "position_deg": 30.0}]}, "blocked[0].position_deg"),
        ({"alternatives": 21}, "alternatives"),
        ({"alternatives": -1}, "alternatives"),
        ({"slack": -0.1}, "slack"),
        ({"slack": math.nan}, "slack"),
        ({"mode": "most"}, "mode"),
        ({"time_limit_s": 0.0}, "time_limit_s"),
        ({"time_limit_s": 121.0}, "time_limit_s"),
        ({"angle_tolerance_deg": -1.0}, "angle_tolerance_deg"),
        ({"mass_tolerance_g": -1.0}, "mass_tolerance_g"),
        ({"weights": [1.0]}, "weights"),
        ({"weights": [1.0, 0.0]}, "weights[1]"),
        ({"objective": "components", "norm": "max"}, "norm"),
        ({"base": "new"}, "base"),
        ({"seed": -1}, "seed"),
    ],
)
def test_what_is_no_request(
    shared_shop: Workshop, asked: tuple[str, Any], request_: dict[str, Any], field: str
) -> None:
    session, correction = asked
    body = {"correction_id": correction["id"], "objective": "residual_vibration", **request_}
    assert refused(shared_shop, f"/sessions/{session}/plans", body)["field"] == field


class TestNothingToChooseFrom:
    """No piece may be fitted: leaving the rotor as found is the best there is, and proved."""

    def _is_empty(self, plan: Any, method: str) -> None:
        assert plan["placements"] == []
        assert plan["status"] == ("heuristic" if method == "modified_jaya" else "optimal")
        expected = sum(abs(vector) for vector in DRUM.initial.values()) / 0.2
        assert plan["objective_value"] == pytest.approx(expected)
        assert {v["sensor"]: vector_of(v) for v in plan["predicted"]} == pytest.approx(DRUM.initial, abs=1e-9)

    @pytest.mark.parametrize("method", METHODS)
    def test_every_hole_is_blocked(self, shared_shop: Workshop, asked: tuple[str, Any], method: str) -> None:
        session, correction = asked
        plan = shared_shop.plan(session, correction, method=method, blocked=EVERY_HOLE)
        self._is_empty(plan, method)
        if method != "modified_jaya":
            assert len(shared_shop.get(f"/plans/{plan['id']}/front")) == 1

    @pytest.mark.parametrize("method", METHODS)
    def test_the_box_is_used_up(self, shared_shop: Workshop, method: str) -> None:
        box = shared_shop.box(count=1, masses=(100.0, 200.0))
        session = shared_shop.session(box=box)
        shared_shop.learn(session)
        counted = [{"mass_g": grams, "pieces": 0} for grams in (100.0, 200.0)]
        shared_shop.ask("PATCH", f"/catalogues/{box}", {"counted": counted})
        correction = shared_shop.correct(session)
        plan = shared_shop.plan(session, correction, method=method)
        self._is_empty(plan, method)
        bought = shared_shop.post(f"/plans/{plan['id']}/what-if", {"bought": [{"mass_g": 200.0, "pieces": 2}]})
        assert bought["worse_by"] < 0.0
        for base in ("as_found", "present"):
            self._is_empty(shared_shop.plan(session, correction, method=method, base=base), method)

    def test_another_session_has_the_last_piece(self, shop: Workshop) -> None:
        box = shop.box(count=1, masses=(200.0,))
        first, second = shop.session(box=box), shop.session(box=box)
        shop.fit(shop.planned(first))
        assert shop.on_hand(box) == {200.0: 0}
        plan = shop.planned(second)
        self._is_empty(plan, "exact")
        assert shop.planned(first)["placements"], "its own pieces may come off, so it may plan with them"

    def test_all_too_heavy(self, shared_shop: Workshop) -> None:
        light = [{**plane, "max_force_n": 1.0} for plane in machine_body()["planes"]]
        session = shared_shop.session(shared_shop.machine(planes=light))
        shared_shop.learn(session)
        self._is_empty(shared_shop.plan(session, shared_shop.correct(session)), "exact")

    def test_the_fewest_that_meet_a_limit(self, shared_shop: Workshop, asked: tuple[str, Any]) -> None:
        session, correction = asked
        free = shared_shop.plan(session, correction, norm="max")["objective_value"]
        plan = shared_shop.plan(session, correction, mode="fewest", blocked=EVERY_HOLE, limit=free * 1.01)
        assert (plan["status"], plan["placements"]) == ("infeasible", [])
        assert "the blocked positions" in plan["reason"]
        worst = max(abs(vector) for vector in DRUM.initial.values()) / 0.2
        assert f"leaves {worst:.4g}" in plan["reason"]
        met = shared_shop.plan(session, correction, mode="fewest", blocked=EVERY_HOLE, limit=worst * 1.01)
        assert (met["status"], met["placements"]) == ("optimal", [])


class TestMoreThanThereIs:
    def test_more_masses_than_the_machine_takes(self, shared_shop: Workshop, asked: tuple[str, Any]) -> None:
        """A request lowers the machine's limit and never raises it."""
        session, correction = asked
        plan = shared_shop.plan(session, correction, max_masses_per_plane=20)
        assert {len([p for p in plan["placements"] if p["plane"] == name]) for name in "12"} <= {0, 1, 2, 3}
        assert plan["placements"] == shared_shop.plan(session, correction, max_masses_per_plane=3)["placements"]

    def test_fewer_holes_left_than_masses_allowed(self, shared_shop: Workshop, asked: tuple[str, Any]) -> None:
        session, correction = asked
        blocked = [hole for hole in EVERY_HOLE if (hole["plane"], hole["position_deg"]) != ("1", 200.0)]
        plan = shared_shop.plan(session, correction, max_masses_per_plane=3, blocked=blocked)
        assert {(p["plane"], p["position_deg"]) for p in plan["placements"]} <= {("1", 200.0)}
        assert plan["status"] == "optimal"

    def test_a_drum_that_needs_nothing(self, shared_shop: Workshop) -> None:
        """Its vibration is zero to the last digit."""
        session = shared_shop.session()
        shared_shop.learn(session, type(DRUM)({"P": 0j, "Q": 0j}, DRUM.influence))
        correction = shared_shop.correct(session)
        for objective in ("residual_vibration", "components"):
            plan = shared_shop.plan(session, correction, objective=objective)
            assert (plan["placements"], plan["status"]) == ([], "optimal")


@pytest.fixture(scope="module")
def warehouse(shared_shop: Workshop) -> tuple[str, Any]:
    """A session with a box of ten thousand kinds."""
    box = {"name": "warehouse", "items": [{"mass_g": 0.1 * n, "count": 2} for n in range(1, 10_001)]}
    session = shared_shop.session(box=str(shared_shop.post("/catalogues", box)["id"]))
    shared_shop.learn(session)
    return session, shared_shop.correct(session)


@pytest.mark.arithmetic
class TestTenThousandKinds:
    def test_one_a_plane_is_proved(self, shared_shop: Workshop, warehouse: tuple[str, Any]) -> None:
        plan = shared_shop.plan(*warehouse, method="certified")
        assert plan["status"] == "optimal"
        assert len(plan["placements"]) == 2

    def test_more_than_can_be_listed_ends_with_an_honest_bound(
        self, shared_shop: Workshop, warehouse: tuple[str, Any]
    ) -> None:
        """The tests' stop-watch goes on by a microsecond whenever it is read."""
        plan = shared_shop.plan(*warehouse, method="certified", max_masses_per_plane=3, time_limit_s=2e-4)
        assert plan["status"] in ("limit_reached", "optimal")
        assert 0.0 <= plan["lower_bound"] <= plan["objective_value"]
        best_of_one = shared_shop.plan(*warehouse)["objective_value"]
        assert plan["lower_bound"] <= best_of_one
        assert {v["sensor"]: vector_of(v) for v in plan["predicted"]} == pytest.approx(
            DRUM.vibration(on_rotor(plan["placements"])), abs=1e-9
        )
