"""Plans that survive the uncertainty of the readings, and the probabilities that every plan states."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.http.workshop import DRUM, Workshop, mass

SCATTER = 0.02


def noisy(shop: Workshop, scatter: float | None = SCATTER) -> tuple[str, Any]:
    """A session whose readings state their scatter, and its correction."""
    session = shop.session(shop.machine(balance_grade_mm_s=16.0))
    for kind, masses in (("initial", []), ("trial", [mass("1", 200.0, 0.0)]), ("trial", [mass("2", 200.0, 0.0)])):
        readings = DRUM.readings(masses)
        if scatter is not None:
            readings = [{**one, "scatter": scatter * one["amplitude"]} for one in readings]
        shop.run(session, kind, masses, readings=readings)
    return session, shop.correct(session)


class TestRobust:
    @pytest.mark.parametrize("aim", ["quantile_95", "probability_within_limits"])
    @pytest.mark.parametrize("base", ["residual_vibration", "bearing_force"])
    def test_a_plan_by_its_aim(self, shared_shop: Workshop, aim: str, base: str) -> None:
        session, correction = noisy(shared_shop)
        asked = {"objective": "robust", "method": "certified", "robust": {"aim": aim, "base": base}}
        plan = shared_shop.plan(session, correction, alternatives=2, max_masses_per_plane=2, **asked)
        assert (plan["status"], plan["lower_bound"], plan["gap"]) == ("heuristic", None, None)
        assert plan["request"]["robust"] == asked["robust"]
        assert 0.0 <= plan["probability_best"] <= 1.0
        values = [plan["objective_value"], *(one["objective_value"] for one in plan["alternatives"])]
        assert values == sorted(values)
        if aim == "probability_within_limits":
            assert plan["objective_value"] == pytest.approx(1.0 - plan["probability_within"], abs=1e-12)
        fitted = shared_shop.fit(plan)
        assert fitted["probability_within"] == plan["probability_within"]

    def test_every_plan_says_how_probably_it_keeps_the_limits(self, shared_shop: Workshop) -> None:
        session, correction = noisy(shared_shop)
        plan = shared_shop.plan(session, correction)
        assert 0.0 <= plan["probability_within"] <= 1.0
        assert plan["probability_best"] is None
        assert plan["probability_within"] == shared_shop.plan(session, correction)["probability_within"]

    @pytest.mark.parametrize(
        ("changed", "field", "code"),
        [
            ({"objective": "components", "robust": {}}, "robust", "invalid_input"),
            ({"mode": "fewest"}, "mode", "invalid_input"),
            ({"method": "modified_jaya"}, "method", "invalid_input"),
            ({"slack": 0.1}, "slack", "invalid_input"),
            ({"robust": {"base": "bearing_force"}, "norm": "max"}, "norm", "invalid_input"),
        ],
    )
    def test_what_it_would_pass_over_is_refused(
        self, shared_shop: Workshop, changed: dict[str, Any], field: str, code: str
    ) -> None:
        session, correction = noisy(shared_shop)
        body = {"correction_id": correction["id"], "objective": "robust", **changed}
        problem = shared_shop.refused("POST", f"/sessions/{session}/plans", body, 422, code)
        assert problem["field"] == field

    def test_a_balancers_answer_has_no_coefficients_to_draw(self, shared_shop: Workshop) -> None:
        session = shared_shop.session()
        masses = [{"plane": plane, "mass_g": 120.0, "angle_deg": 40.0} for plane in "12"]
        correction = shared_shop.correct(session, source="balancer", masses=masses)
        body = {"correction_id": correction["id"], "objective": "robust", "robust": {"base": "bearing_force"}}
        shared_shop.refused("POST", f"/sessions/{session}/plans", body, 409, "no_errors_of_coefficients")
