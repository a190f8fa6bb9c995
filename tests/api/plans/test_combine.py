"""Several trims in a plane come to fewer masses: what the technician is shown, and the plan that replaces them."""

from __future__ import annotations

import cmath
import json
import math
from typing import Any

import pytest

from service.engine.logs.replay import read_log, resolve
from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass, vector_of

TRIMS = (
    [("1", 100.0, 20.0), ("2", 200.0, 200.0)],
    [("1", 100.0, 20.0), ("2", 200.0, 200.0), ("1", 100.0, 140.0), ("2", 200.0, 320.0)],
)
"""What is on after each of two trims; two equal masses 120 degrees apart do what one of them does between."""
COMBINED = {("1", 100.0, 80.0), ("2", 200.0, 260.0)}


def drum() -> LinearDrum:
    """A drum that needs one per cent more than the pieces of both trims give."""
    needed = {plane: cmath.rect(1.01 * grams, math.radians(angle)) for plane, grams, angle in COMBINED}
    initial = {
        sensor: -sum(DRUM.influence[sensor, plane] * vector for plane, vector in needed.items())
        for sensor in DRUM.initial
    }
    return LinearDrum(initial, DRUM.influence)


def trimmed(shop: Workshop) -> tuple[str, Any, Any]:
    """A session after two trims; its correction and the plan that is fitted."""
    session = shop.session()
    shop.learn(session, drum())
    plan: Any = None
    for pieces in TRIMS:
        plan = shop.plan(session, shop.correct(session), max_masses_per_plane=3)
        actual = [{"plane": p, "mass_g": grams, "position_deg": angle} for p, grams, angle in pieces]
        plan = shop.fit(plan, actual=actual)
        shop.run(session, "check", [mass(*piece) for piece in pieces], drum())
    return session, shop.correct(session), plan


def combine(shop: Workshop, session: str, correction: Any, **request: Any) -> Any:
    return shop.plan(session, correction, mode="combine", max_masses_per_plane=None, **request)


def test_the_report_shows_what_the_pieces_of_all_trims_come_to(shop: Workshop) -> None:
    session, _, plan = trimmed(shop)
    loads = shop.get(f"/sessions/{session}/report.json")["planes"]
    assert [piece for load in loads for piece in load["pieces"]] == plan["fitted"]
    for load in loads:
        pieces = [cmath.rect(p["mass_g"], math.radians(p["position_deg"])) for p in load["pieces"]]
        assert vector_of(load["as_one"], "mass_g", "angle_deg") == pytest.approx(sum(pieces), abs=1e-9)
        assert load["carried_g"] == pytest.approx(sum(map(abs, pieces)))
        assert load["saved"] == pytest.approx(1.0 - abs(sum(pieces)) / sum(map(abs, pieces)))


@pytest.mark.parametrize("objective", ["residual_vibration", "components", "bearing_force"])
def test_a_plan_replaces_them_by_the_fewest_that_do_as_well(shop: Workshop, objective: str) -> None:
    session, correction, fitted = trimmed(shop)
    plan = combine(shop, session, correction, objective=objective)
    assert plan["status"] == "optimal"
    assert {(p["plane"], p["mass_g"], p["position_deg"]) for p in plan["placements"]} == COMBINED
    assert [change["action"] for change in plan["changes"]] == ["remove"] * 4 + ["add"] * 2
    before, after = (vector["amplitude"] for vector in (fitted["predicted"][0], plan["predicted"][0]))
    assert after == pytest.approx(before)
    assert shop.fit(plan)["fitted"] == plan["placements"]


def test_a_limit_may_be_stated_instead(shop: Workshop) -> None:
    session, correction, _ = trimmed(shop)
    loose = combine(shop, session, correction, objective="components", limit=1e6)
    assert loose["placements"] == []


def test_the_log_gives_the_same_plan_again(shop: Workshop) -> None:
    session, correction, _ = trimmed(shop)
    plan = combine(shop, session, correction)
    again = resolve(read_log(json.dumps(shop.get(f"/sessions/{session}/log")).encode()))
    assert again.changed == ()
    assert len(again.plans[-1].placements) == len(plan["placements"])


def test_nothing_to_combine_is_told(shop: Workshop) -> None:
    session = shop.session()
    shop.learn(session)
    body = {"correction_id": shop.correct(session)["id"], "objective": "components", "mode": "combine"}
    problem = shop.refused("POST", f"/sessions/{session}/plans", body, 409, "nothing_fitted")
    assert "mount a plan first" in problem["advice"]


def test_masses_that_stay_are_not_combined(shop: Workshop) -> None:
    session, correction, _ = trimmed(shop)
    body = {"correction_id": correction["id"], "objective": "components", "mode": "combine", "base": "present"}
    assert shop.refused("POST", f"/sessions/{session}/plans", body, 422, "invalid_input")["field"] == "base"
