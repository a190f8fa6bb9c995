"""Bad input: each a clear problem, and nothing stored."""

from __future__ import annotations

import json
import math
import re
from string import Template
from typing import Any
from urllib.parse import quote

import pytest

from tests.support.http.workshop import DRUM, Workshop, application, box_body, machine_body, mass, problem_of

NOON = "2025-12-01T12:00:00Z"
RUN = "/sessions/$session/runs"
INITIAL = {"kind": "initial", "readings": [{"sensor": "P", "amplitude": 1.0, "phase_deg": 10.0}]}
READING = {"source": "bridge", "sequence": 7, "taken_at": NOON, "sensor": "P", "amplitude": 1.0}
ANSWER = {"source": "bridge", "sequence": 7, "taken_at": NOON, "masses": [mass("1", 10.0, 33.0)]}
TAKE = {"source": "bridge", "from": NOON, "to": "2025-12-01T12:01:00Z"}
PLAN = {"correction_id": "$correction", "objective": "components", "method": "exact", "max_masses_per_plane": 1}


@pytest.fixture(scope="module")
def names(shared_shop: Workshop) -> dict[str, str]:
    """Identifiers of a session with a plan, of an empty one, and of strangers to both."""
    shop = shared_shop
    machine, stranger = shop.machine(), shop.machine(sensors=[{"name": "P"}])
    session, foreign = shop.session(machine), shop.session(stranger)
    plan = shop.planned(session)
    for source, bound in (("bridge", machine), ("far bridge", stranger)):
        shop.ask("PUT", f"/sources/{source}", {"machine_id": bound})
    shop.post("/readings", {**READING, "source": "far bridge"})
    balancer = shop.correct(foreign, source="balancer", masses=[mass("1", 100.0, 33.0)])
    answer = shop.post("/balancer-answers", {**ANSWER, "source": "far bridge", "session_id": foreign})
    return {
        "machine": machine,
        "session": session,
        "box": shop.box(),
        "plan": plan["id"],
        "correction": plan["correction_id"],
        "fresh": shop.session(machine),
        "initial_only": _with_initial_run(shop, machine),
        "foreign": foreign,
        "foreign_run": shop.run(foreign, "initial", drum=_p_alone())["id"],
        "foreign_correction": balancer["id"],
        "foreign_answer": answer["id"],
    }


def _with_initial_run(shop: Workshop, machine: str) -> str:
    session = shop.session(machine)
    shop.run(session, "initial")
    return session


def _p_alone() -> Any:
    return type(DRUM)(initial={"P": DRUM.initial["P"]}, influence=DRUM.influence)


def run_with(**changes: Any) -> dict[str, Any]:
    """An initial run whose reading is changed."""
    return {**INITIAL, "readings": [{**INITIAL["readings"][0], **changes}]}  # type: ignore[dict-item]


def trial(*masses: dict[str, Any]) -> dict[str, Any]:
    """A trial run with these masses."""
    return {**INITIAL, "kind": "trial", "masses": list(masses)}


def plane(**changes: Any) -> dict[str, Any]:
    """A machine whose first plane is changed."""
    body = machine_body("new")
    return {**body, "planes": [{**body["planes"][0], **changes}]}


def sensor(**changes: Any) -> dict[str, Any]:
    """A machine whose sensor is changed."""
    return machine_body("new", sensors=[{"name": "P", **changes}])


NUMBERS = {
    "nan": (run_with(amplitude=math.nan), "readings[0].amplitude"),
    "infinity": (run_with(amplitude=math.inf), "readings[0].amplitude"),
    "minus infinity": (run_with(phase_deg=-math.inf), "readings[0].phase_deg"),
    "nan scatter": (run_with(scatter=math.nan), "readings[0].scatter"),
    "negative amplitude": (run_with(amplitude=-1.0), "readings[0].amplitude"),
    "amplitude beyond any sensor": (run_with(amplitude=1e10), "readings[0].amplitude"),
    "zero scatter": (run_with(scatter=0.0), "readings[0].scatter"),
    "zero speed": (run_with(speed_rpm=0.0), "readings[0].speed_rpm"),
    "phase 400": (run_with(phase_deg=400.0), "readings[0].phase_deg"),
    "boolean": (run_with(amplitude=True), "readings[0].amplitude"),
    "text": (run_with(amplitude="1.0"), "readings[0].amplitude"),
    "null": (run_with(amplitude=None), "readings[0].amplitude"),
    "list": (run_with(amplitude=[1.0]), "readings[0].amplitude"),
    "nan mass": (trial(mass("1", math.nan, 0.0)), "masses[0].mass_g"),
    "angle 400": (trial(mass("1", 10.0, 400.0)), "masses[0].angle_deg"),
    "boolean angle": (trial(mass("1", 10.0, False)), "masses[0].angle_deg"),
    "nan speed": ({**INITIAL, "nominal_speed_rpm": math.nan}, "nominal_speed_rpm"),
    "unknown field": (run_with(amplitud=1.0), "readings[0].amplitud"),
    "missing phase": ({**INITIAL, "readings": [{"sensor": "P", "amplitude": 1.0}]}, "readings[0].phase_deg"),
    "no such kind": ({**INITIAL, "kind": "try"}, "kind"),
    "no reading": ({**INITIAL, "readings": []}, "readings"),
    "too many masses": (trial(*[mass("1", 1.0, 0.0)] * 1001), "masses"),
}


@pytest.mark.parametrize(("body", "where"), NUMBERS.values(), ids=NUMBERS)
def test_a_value_that_breaks_the_rule_of_its_field(
    shared_shop: Workshop, names: dict[str, str], body: object, where: str
) -> None:
    problem = refuse(shared_shop, names, "POST", RUN, body, 422, "invalid_input")
    assert problem["field"] == where
    offending = body
    for key in where.replace("]", "").replace("[", ".").split("."):
        offending = offending[int(key)] if isinstance(offending, list) else dict(offending).get(key)  # type: ignore[call-overload]
    if isinstance(offending, float) and not math.isfinite(offending):
        assert problem["value"] == str(offending)
    elif not isinstance(offending, list):
        assert problem["value"] == offending


RULES: dict[str, tuple[str, str, object, int, str, str | None]] = {
    # runs
    "unknown sensor": ("POST", RUN, run_with(sensor="R"), 422, "invalid_input", "readings[0].sensor"),
    "unknown plane": ("POST", RUN, trial(mass("9", 10.0, 0.0)), 422, "invalid_input", "masses[0].plane"),
    "trial without a mass": ("POST", RUN, trial(), 422, "mass_missing", "masses"),
    "correction without a mass": ("POST", RUN, {**INITIAL, "kind": "correction"}, 422, "mass_missing", "masses"),
    "trial of 0 g": ("POST", RUN, trial(mass("1", 0.0, 0.0)), 422, "invalid_input", "masses[0].mass_g"),
    "initial with a mass": (
        "POST", RUN, {**INITIAL, "masses": [mass("1", 1.0, 0.0)]}, 422, "invalid_input", "masses",
    ),
    "sensor twice": (
        "POST", RUN, {**INITIAL, "readings": [INITIAL["readings"][0]] * 2}, 422, "sensor_twice", "readings[1].sensor",
    ),
    "neither readings nor take": ("POST", RUN, {"kind": "initial"}, 422, "invalid_input", "readings"),
    "readings and take": ("POST", RUN, {**INITIAL, "take": TAKE}, 422, "invalid_input", "readings"),
    "nothing to take": ("POST", RUN, {"kind": "initial", "take": TAKE}, 422, "nothing_to_take", "take"),
    "take backwards": (
        "POST", RUN, {"kind": "initial", "take": {**TAKE, "to": "2025-11-01T00:00:00Z"}}, 422, "invalid_input",
        "take.from",
    ),
    "take without a zone": (
        "POST", RUN, {"kind": "initial", "take": {**TAKE, "to": "2025-12-01T12:01:00"}}, 422, "invalid_input",
        "take.to",
    ),
    # of another session
    "run from a source of another machine": (
        "POST", RUN, {"kind": "initial", "take": {**TAKE, "source": "far bridge"}}, 409, "source_of_other_machine",
        "take.source",
    ),
    "reading for a session of another machine": (
        "POST", "/readings", {**READING, "session_id": "$foreign"}, 409, "source_of_other_machine", "[0].session_id",
    ),
    "plan with a correction of another session": (
        "POST", "/sessions/$session/plans", {**PLAN, "correction_id": "$foreign_correction"}, 409,
        "correction_of_other_session", "correction_id",
    ),
    "correction from an answer of another session": (
        "POST", "/sessions/$session/corrections", {"source": "balancer", "answer_id": "$foreign_answer"}, 409,
        "answer_of_other_session", "answer_id",
    ),
    "run changed through another session": (
        "PATCH", "/sessions/$session/runs/$foreign_run", {"excluded": True, "reason": "typo"}, 404, "not_found",
        "run_id",
    ),
    # readings and answers
    "reading of an unknown sensor": (
        "POST", "/readings", [READING, {**READING, "sequence": 8, "sensor": "R"}], 422, "invalid_input", "[1].sensor",
    ),
    "reading with a negative amplitude": (
        "POST", "/readings", [READING, {**READING, "sequence": 8, "amplitude": -1.0}], 422, "invalid_input",
        "[1].amplitude",
    ),
    "reading with a nan": (
        "POST", "/readings", {**READING, "amplitude": math.nan}, 422, "invalid_input", "amplitude",
    ),
    "reading with an unknown field": ("POST", "/readings", {**READING, "plane": "1"}, 422, "invalid_input", "plane"),
    "reading of an unknown source": (
        "POST", "/readings", {**READING, "source": "nobody"}, 404, "source_not_bound", "[0].session_id",
    ),
    "reading for an unknown session": (
        "POST", "/readings", {**READING, "session_id": "none"}, 404, "not_found", "session_id",
    ),
    "no reading": ("POST", "/readings", [], 422, "invalid_input", None),
    "too many readings": ("POST", "/readings", [READING] * 10_001, 413, "too_large", None),
    "time without a zone": (
        "POST", "/readings", {**READING, "taken_at": "2025-12-01T12:00:00"}, 422, "invalid_input", "[0].taken_at",
    ),
    "sequence below zero": ("POST", "/readings", {**READING, "sequence": -1}, 422, "invalid_input", "sequence"),
    "sequence with a fraction": ("POST", "/readings", {**READING, "sequence": 1.5}, 422, "invalid_input", "sequence"),
    "source with a sign that cannot be printed": (
        "POST", "/readings", {**READING, "source": "a\x00b", "session_id": "$session"}, 422, "invalid_input",
        "[0].source",
    ),
    "binding a source with such a sign": (
        "PUT", "/sources/a%00b", {"machine_id": "$machine"}, 422, "invalid_input", "name",
    ),
    "answer for an unknown plane": (
        "POST", "/balancer-answers", {**ANSWER, "masses": [mass("9", 1.0, 0.0)]}, 422, "invalid_input",
        "masses[0].plane",
    ),
    "answer with a nan": (
        "POST", "/balancer-answers", {**ANSWER, "masses": [mass("1", math.nan, 0.0)]}, 422, "invalid_input",
        "masses[0].mass_g",
    ),
    "answer without a mass": (
        "POST", "/balancer-answers", {**ANSWER, "masses": []}, 422, "invalid_input", "masses",
    ),
    "source of an unknown machine": ("PUT", "/sources/x", {"machine_id": "none"}, 404, "not_found", "machine_id"),
    # corrections
    "no run": ("POST", "/sessions/$fresh/corrections", {"source": "fit"}, 422, "too_few_runs", "runs"),
    "too few runs": ("POST", "/sessions/$initial_only/corrections", {"source": "fit"}, 422, "too_few_runs", "runs"),
    "balancer without masses": (
        "POST", "/sessions/$session/corrections", {"source": "balancer"}, 422, "invalid_input", "masses",
    ),
    "balancer with an unknown plane": (
        "POST", "/sessions/$session/corrections", {"source": "balancer", "masses": [mass("9", 1.0, 0.0)]}, 422,
        "invalid_input", "masses[0].plane",
    ),
    "balancer with a plane twice": (
        "POST", "/sessions/$session/corrections", {"source": "balancer", "masses": [mass("1", 1.0, 0.0)] * 2}, 422,
        "invalid_input", "masses",
    ),
    "balancer with a method": (
        "POST", "/sessions/$session/corrections",
        {"source": "balancer", "method": "least_squares", "masses": [mass("1", 1.0, 0.0)]}, 422, "invalid_input",
        "method",
    ),
    "fit with masses": (
        "POST", "/sessions/$session/corrections", {"source": "fit", "masses": [mass("1", 1.0, 0.0)]}, 422,
        "invalid_input", "masses",
    ),
    "unknown answer": (
        "POST", "/sessions/$session/corrections", {"source": "balancer", "answer_id": "none"}, 404, "not_found",
        "balancer_answer_id",
    ),
    # plans
    "blocked hole that is none": (
        "POST", "/sessions/$session/plans", {**PLAN, "blocked": [{"plane": "1", "position_deg": 30.0}]}, 422,
        "invalid_input", "blocked[0].position_deg",
    ),
    "blocked hole of an unknown plane": (
        "POST", "/sessions/$session/plans", {**PLAN, "blocked": [{"plane": "9", "position_deg": 20.0}]}, 422,
        "invalid_input", "blocked[0].plane",
    ),
    "weights for another objective": (
        "POST", "/sessions/$session/plans", {**PLAN, "weights": [1.0]}, 422, "invalid_input", "weights",
    ),
    "too few weights": (
        "POST", "/sessions/$session/plans", {**PLAN, "objective": "residual_vibration", "weights": [1.0]}, 422,
        "invalid_input", "weights",
    ),
    "no time": (
        "POST", "/sessions/$session/plans", {**PLAN, "time_limit_s": 0.0}, 422, "invalid_input", "time_limit_s",
    ),
    "unknown correction": (
        "POST", "/sessions/$session/plans", {**PLAN, "correction_id": "none"}, 404, "not_found", "correction_id",
    ),
    "vibration from a balancer's answer": (
        "POST", "/sessions/$foreign/plans",
        {**PLAN, "correction_id": "$foreign_correction", "objective": "residual_vibration"}, 409, "no_influence",
        "objective",
    ),
    # fitted
    "piece at an angle that is no position": (
        "POST", "/plans/$plan/fitted", {"actual": [{"plane": "1", "position_deg": 30.0, "mass_g": 100.0}]}, 422,
        "invalid_input", "actual[0].position_deg",
    ),
    "piece in an unknown plane": (
        "POST", "/plans/$plan/fitted", {"actual": [{"plane": "9", "position_deg": 20.0, "mass_g": 100.0}]}, 422,
        "invalid_input", "actual[0].plane",
    ),
    "piece that is not in the box": (
        "POST", "/plans/$plan/fitted", {"actual": [{"plane": "1", "position_deg": 20.0, "mass_g": 101.0}]}, 422,
        "invalid_input", "actual[0].mass_g",
    ),
    "two pieces in a hole for one": (
        "POST", "/plans/$plan/fitted", {"actual": [{"plane": "1", "position_deg": 20.0, "mass_g": 100.0}] * 2}, 422,
        "hole_full", "actual[1].position_deg",
    ),
    "unknown plan": ("POST", "/plans/none/fitted", {}, 404, "not_found", "plan_id"),
    # machines
    "machine without a plane": ("POST", "/machines", machine_body("new", planes=[]), 422, "invalid_input", "planes"),
    "too many planes": (
        "POST", "/machines", machine_body("new", planes=machine_body()["planes"] * 5), 422, "invalid_input", "planes",
    ),
    "two planes of one name": (
        "POST", "/machines", machine_body("new", planes=machine_body()["planes"][:1] * 2), 422, "invalid_input",
        "planes",
    ),
    "position 400": (
        "POST", "/machines", plane(positions_deg=[20.0, 400.0]), 422, "invalid_input", "planes[0].positions_deg[1]",
    ),
    "position twice, as 0 and 360": (
        "POST", "/machines", plane(positions_deg=[0.0, 20.0, 360.0]), 422, "invalid_input", "planes[0].positions_deg",
    ),
    "no position": ("POST", "/machines", plane(positions_deg=[]), 422, "invalid_input", "planes[0].positions_deg"),
    "too many positions": (
        "POST", "/machines", plane(positions_deg=[n / 2.0 for n in range(361)]), 422, "invalid_input",
        "planes[0].positions_deg",
    ),
    "labels for other positions": (
        "POST", "/machines", plane(hole_labels=["A"]), 422, "invalid_input", "planes[0].hole_labels",
    ),
    "more masses than holes": (
        "POST", "/machines", plane(positions_deg=[0.0], max_masses=2), 422, "invalid_input", "planes[0].max_masses",
    ),
    "no radius": ("POST", "/machines", plane(radius_mm=0.0), 422, "invalid_input", "planes[0].radius_mm"),
    "unit of another quantity": ("POST", "/machines", sensor(unit="g"), 422, "invalid_input", "sensors[0].unit"),
    "sensor on an unknown bearing": (
        "POST", "/machines", sensor(bearing="R"), 422, "invalid_input", "sensors[0].bearing",
    ),
    "no such sense": (
        "POST", "/machines", machine_body("new", angle_sense="clockwise"), 422, "invalid_input", "angle_sense",
    ),
    "bearings at one place": (
        "POST", "/machines",
        machine_body("new", bearings=[{"name": "P", "axial_mm": 1.0}, {"name": "Q", "axial_mm": 1.0}]), 422,
        "invalid_input", "bearings",
    ),
    "empty name": ("POST", "/machines", machine_body("   "), 422, "invalid_input", "name"),
    "name with a control sign": ("POST", "/machines", machine_body("a\x07b"), 422, "invalid_input", "name"),
    "nan in a patch": (
        "PATCH", "/machines/$machine", {"rotor_mass_kg": math.nan}, 422, "invalid_input", "rotor_mass_kg",
    ),
    "unknown field in a patch": ("PATCH", "/machines/$machine", {"colour": None}, 422, "invalid_input", "colour"),
    "patch that breaks a rule": (
        "PATCH", "/machines/$machine", {"sensors": [{"name": "P", "limit": -1.0}]}, 422, "invalid_input",
        "sensors[0].limit",
    ),
    "patch that is a list": ("PATCH", "/machines/$machine", [], 422, "invalid_input", None),
    # boxes
    "empty catalogue": ("POST", "/catalogues", {"name": "new", "items": []}, 422, "invalid_input", "items"),
    "a mass twice": ("POST", "/catalogues", box_body("new", masses=[10.0, 10.0]), 422, "invalid_input", "items"),
    "count of none": ("POST", "/catalogues", box_body("new", count=0), 422, "invalid_input", "items[0].count"),
    "mass of 0 g": ("POST", "/catalogues", box_body("new", masses=[0.0]), 422, "invalid_input", "items[0].mass_g"),
    "received a mass that is not in the box": (
        "PATCH", "/catalogues/$box", {"received": [{"mass_g": 11.0, "pieces": 1}]}, 422, "invalid_input",
        "received[0].mass_g",
    ),
    "counted a mass twice": (
        "PATCH", "/catalogues/$box", {"counted": [{"mass_g": 10.0, "pieces": 1}] * 2}, 422, "invalid_input",
        "counted[1].mass_g",
    ),
    # sessions
    "session on an unknown machine": ("POST", "/sessions", {"machine_id": "none"}, 404, "not_found", "machine_id"),
    "session with an unknown box": (
        "POST", "/sessions", {"machine_id": "$machine", "catalogue_id": "none"}, 404, "not_found", "catalogue_id",
    ),
    "run-out of an unknown sensor": (
        "POST", "/sessions",
        {"machine_id": "$machine", "run_out": [{"sensor": "R", "amplitude": 1.0, "phase_deg": 0.0}]}, 422,
        "invalid_input", "run_out[0].sensor",
    ),
    "session reopened": ("PATCH", "/sessions/$session", {"state": "open"}, 422, "invalid_input", "state"),
    "unknown session": ("GET", "/sessions/none", None, 404, "not_found", "session_id"),
    "run of an unknown session": ("POST", "/sessions/none/runs", INITIAL, 404, "not_found", "session_id"),
    "longer list than there is": ("GET", "/sessions?limit=201", None, 422, "invalid_input", "limit"),
}  # fmt: skip


@pytest.mark.parametrize(("method", "path", "body", "status", "code", "where"), RULES.values(), ids=RULES)
def test_a_request_that_breaks_a_rule(
    shared_shop: Workshop,
    names: dict[str, str],
    method: str,
    path: str,
    body: object,
    status: int,
    code: str,
    where: str | None,
) -> None:
    assert refuse(shared_shop, names, method, path, body, status, code)["field"] == where


def test_a_run_with_both_readings_and_take_is_told_so(shared_shop: Workshop, names: dict[str, str]) -> None:
    problem = refuse(shared_shop, names, "POST", RUN, {**INITIAL, "take": TAKE}, 422, "invalid_input")
    assert problem["detail"] == "a run must have readings or take, got both"
    assert "amplitude" in str(problem["value"])


@pytest.mark.parametrize("angle", [33.3, -359.9, 360.0, -360.0, 0.001])
def test_runs_and_balancer_answers_may_have_any_angle(shop: Workshop, angle: float) -> None:
    session = shop.session()
    shop.run(session, "trial", [mass("1", 12.3, angle)])
    shop.run(session, "correction", [mass("2", -4.5, angle)])
    shop.correct(session, source="balancer", masses=[mass("1", 12.3, angle)])
    answer = {**ANSWER, "session_id": session, "masses": [mass("1", 12.3, angle)]}
    assert shop.post("/balancer-answers", answer)["accepted"] is True


def refuse(
    shop: Workshop, names: dict[str, str], method: str, path: str, body: object, status: int, code: str
) -> dict[str, Any]:
    """The problem that a request is answered with, once `$names` stand for what they name."""
    text = None if body is None else Template(json.dumps(body)).substitute(names).encode()
    return shop.refused(method, Template(path).substitute(names), text, status, code)


def test_a_query_parameter_that_an_operation_does_not_have_is_named(shared_shop: Workshop) -> None:
    asked = 0
    for path, methods in application().openapi()["paths"].items():
        for method, operation in methods.items():
            known = [one["name"] for one in operation.get("parameters", []) if one["in"] == "query"]
            address = f"{re.sub(r'{.*?}', 'x', path)}?limite=3&{'&'.join(f'{name}=1' for name in known)}"
            answer = shared_shop.client.request(method.upper(), address, json={})
            problem = problem_of(answer, 422, "unknown_parameter")
            assert (problem["field"], problem["value"]) == ("limite", "3")
            assert all(name in problem["advice"] for name in known), operation["operationId"]
            asked += 1
    assert asked > 40


@pytest.mark.parametrize("moment", ["0001-01-01T00:00:00+23:00", "9999-12-31T23:59:59-23:00"])
def test_a_time_that_another_zone_cannot_write_is_refused(shared_shop: Workshop, moment: str) -> None:
    shop, run = shared_shop, {"kind": "initial", "take": {**TAKE, "to": moment}}
    machine = shop.machine()
    session = shop.session(machine)
    shop.ask("PUT", "/sources/clockless", {"machine_id": machine})
    for path, body in (
        ("/readings", {**READING, "source": "clockless", "taken_at": moment}),
        ("/balancer-answers", {**ANSWER, "source": "clockless", "taken_at": moment}),
        (f"/sessions/{session}/runs", run),
    ):
        assert "year" in shop.refused("POST", path, body, 422, "invalid_input")["detail"]
    query = f"from={quote(moment)}"
    assert "year" in shop.refused("GET", f"/sources/clockless/readings?{query}", None, 422, "invalid_input")["detail"]
