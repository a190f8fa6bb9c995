"""Plans on the masses that are on the rotor (base: present), where those break a limit already."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.http.workshop import Workshop, mass


def fitted_session(shop: Workshop, **machine: Any) -> tuple[str, Any, Any]:
    """A session with three masses a plane fitted and a check run; its correction and the fitted plan."""
    session = shop.session(shop.machine(**machine))
    shop.learn(session)
    plan = shop.fit(shop.plan(session, shop.correct(session), max_masses_per_plane=3))
    shop.run(session, "check", [mass(p["plane"], p["mass_g"], p["position_deg"]) for p in plan["fitted"]])
    return session, shop.correct(session), plan


def test_kept_masses_within_the_limits_are_added_to(shop: Workshop) -> None:
    session, correction, fitted = fitted_session(shop)
    plan = shop.plan(session, correction, base="present", max_masses_per_plane=3)
    assert plan["status"] == "optimal"
    assert plan["placements"] == fitted["fitted"]
    assert {change["action"] for change in plan["changes"]} == {"keep"}


@pytest.mark.parametrize("what", ["count", "blocked"])
def test_kept_masses_that_break_a_limit_make_the_plan_infeasible_with_the_reason(shop: Workshop, what: str) -> None:
    session, correction, fitted = fitted_session(shop)
    first = fitted["fitted"][0]
    request: dict[str, Any] = {"max_masses_per_plane": 1}
    said = "must carry at most 1 masses, it has 3"
    if what == "blocked":
        hole = {"plane": first["plane"], "position_deg": first["position_deg"]}
        request, said = {"max_masses_per_plane": 3, "blocked": [hole]}, "is blocked and carries a mass"
    plan = shop.plan(session, correction, base="present", **request)
    assert plan["status"] == "infeasible"
    assert plan["placements"] == []
    assert plan["objective_value"] is None
    assert said in plan["reason"]
    assert shop.get(f"/plans/{plan['id']}/front") == []
    problem = shop.refused("POST", f"/plans/{plan['id']}/fitted", {}, 409, "plan_infeasible")
    assert problem["advice"]
