"""Where corrections come from, over HTTP: fits of every kind, saved coefficients, amplitudes alone."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import Any

import pytest

from tests.support.http.scattered_runs import learned, scattered, silenced
from tests.support.http.workshop import DRUM, Workshop, mass, reading, vector_of

EXACT = 1e-9


def total(correction: Any, key: str = "corrections") -> dict[str, complex]:
    return {entry["plane"]: vector_of(entry, "mass_g", "angle_deg") for entry in correction[key]}


class TestWithoutAnyPhase:
    @pytest.mark.parametrize("source", ["fit", "saved_influence"])
    def test_the_source_that_needs_none_is_named(self, shop: Workshop, source: str) -> None:
        session = shop.session()
        if source == "saved_influence":
            machine = shop.get(f"/sessions/{session}")["machine_id"]
            learned(shop, session)
            shop.post(f"/machines/{machine}/influence", {"session_id": session})
            session = shop.session(machine)
        for masses in ([], [mass("1", 200.0, 0.0)], [mass("2", 200.0, 0.0)]):
            readings = [reading(s, v, phase_deg=None) for s, v in DRUM.vibration(masses).items()]
            kind = "trial" if masses else "initial"
            shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})
        problem = shop.refused("POST", f"/sessions/{session}/corrections", {"source": source}, 422, "no_phase")
        assert "amplitude_only" in problem["advice"]
        assert problem["field"] == "source"


class TestMethods:
    def test_minimax_makes_the_greatest_share_of_its_limit_smallest_and_says_how_small(self, shop: Workshop) -> None:
        three = replace(
            DRUM,
            initial={**DRUM.initial, "M": 2.0 + 1.0j},
            influence={**DRUM.influence, ("M", "1"): 0.002 + 0.001j, ("M", "2"): -0.001 + 0.006j},
        )
        sensors = [{"name": name, "limit": limit} for name, limit in (("P", 0.5), ("Q", 1.0), ("M", 0.25))]
        session = shop.session(shop.machine(sensors=sensors))
        shop.learn(session, three)
        limits = {"P": 0.5, "Q": 1.0, "M": 0.25}
        shares = {}
        for method in ("minimax", "weighted"):
            answer = shop.correct(session, method=method)
            shares[method] = max(v["amplitude"] / limits[v["sensor"]] for v in answer["predicted"])
        best = shop.correct(session, method="minimax")["quality"]
        assert shares["minimax"] == pytest.approx(best["objective_value"], rel=1e-6)
        assert best["lower_bound"] == pytest.approx(best["objective_value"], rel=1e-5)
        assert shares["minimax"] < shares["weighted"]

    def test_a_limit_on_the_mass_of_a_plane_holds(self, shop: Workshop) -> None:
        session = shop.session()
        learned(shop, session)
        free = shop.correct(session)
        limit = 0.7 * max(c["mass_g"] for c in free["corrections"])
        answer = shop.correct(session, max_mass_g=limit)
        assert max(c["mass_g"] for c in answer["corrections"]) <= limit * (1 + 1e-6)
        assert all(c["interval"] is not None for c in answer["corrections"])

    def test_other_planes_keep_what_they_carry(self, shop: Workshop) -> None:
        session = shop.session()
        shop.learn(session)
        shop.run(session, "correction", [mass("2", 120.0, 40.0)])
        answer = total(shop.correct(session, planes=["1"]))
        assert answer["2"] == pytest.approx(cmath.rect(120.0, math.radians(40.0)), abs=1e-6)

    def test_parts_mounted_later_are_allowed_for(self, shop: Workshop) -> None:
        session = shop.session()
        shop.learn(session)
        later = mass("1", 50.0, 90.0)
        answer = shop.correct(session, mounted_later=[later])
        pieces = [mass(c["plane"], c["mass_g"], c["angle_deg"]) for c in answer["corrections"]]
        assert max(abs(v) for v in DRUM.vibration([*pieces, later]).values()) < 1e-9

    def test_static_and_couple_parts_add_up_to_the_corrections(self, shop: Workshop) -> None:
        session = shop.session()
        shop.learn(session)
        answer = shop.correct(session)
        parts = answer["static_couple"]
        static, couple, whole = total(parts, "static"), total(parts, "couple"), total(answer)
        for plane in whole:
            assert static[plane] + couple[plane] == pytest.approx(whole[plane], abs=1e-6)
        assert abs(couple["1"] + couple["2"]) < 1e-6
        assert static["1"] == pytest.approx(static["2"], abs=1e-6)

    def test_the_static_couple_method_of_its_own(self, shop: Workshop) -> None:
        alike = replace(
            DRUM,
            influence={("P", "1"): 0.01 + 0j, ("P", "2"): 0.004j, ("Q", "1"): 0.004j, ("Q", "2"): 0.01 + 0j},
        )
        session = shop.session()
        shop.learn(session, alike)
        assert silenced(shop.correct(session, method="static_couple"), alike) < 1e-9

    def test_damping_buys_less_mass_for_more_vibration(self, shop: Workshop) -> None:
        session = shop.session()
        shop.learn(session)
        free, damped = shop.correct(session), shop.correct(session, damping=0.5)
        assert sum(c["mass_g"] for c in damped["corrections"]) < sum(c["mass_g"] for c in free["corrections"])
        assert silenced(damped) > silenced(free)

    @pytest.mark.parametrize(
        ("request_", "field"),
        [
            ({"source": "balancer", "masses": [mass("1", 1.0, 0.0)], "method": "minimax"}, "method"),
            ({"source": "fit", "masses": [mass("1", 1.0, 0.0)]}, "masses"),
            ({"source": "fit", "influence_of": "type"}, "influence_of"),
            ({"source": "amplitude_only", "earlier_sessions": ["x"]}, "earlier_sessions"),
        ],
    )
    def test_a_field_of_another_source_is_refused(self, shop: Workshop, request_: dict[str, Any], field: str) -> None:
        session = shop.session()
        problem = shop.refused("POST", f"/sessions/{session}/corrections", request_, 422, "invalid_input")
        assert problem["field"] == field


class TestSavedInfluence:
    def test_one_run_balances_the_next_drum(self, shop: Workshop) -> None:
        machine = shop.machine()
        first = shop.session(machine)
        learned(shop, first)
        kept = shop.post(f"/machines/{machine}/influence", {"session_id": first})
        assert kept["refused"] == []
        other = replace(DRUM, initial={"P": 1.0 - 2.0j, "Q": -3.0 + 0.5j})
        session = shop.session(machine)
        scattered(shop, session, "initial", [], other)
        answer = shop.correct(session, source="saved_influence")
        assert silenced(answer, other) < EXACT
        assert all(c["interval"] is not None for c in answer["corrections"])
        plan = shop.plan(session, answer)
        assert plan["status"] in ("optimal", "within_uncertainty")
        log = shop.get(f"/sessions/{session}/log")
        assert log["corrections"][0]["saved_influence"] == kept["saved"]

    def test_without_coefficients_it_says_what_to_do(self, shop: Workshop) -> None:
        session = shop.session()
        shop.run(session, "initial")
        body = {"source": "saved_influence"}
        assert (
            "trial runs"
            in shop.refused("POST", f"/sessions/{session}/corrections", body, 422, "no_influence")["advice"]
        )

    def test_learning_is_bounded_and_says_so(self, shop: Workshop) -> None:
        machine = shop.machine()
        first = shop.session(machine)
        learned(shop, first)
        before = shop.post(f"/machines/{machine}/influence", {"session_id": first})
        twice = replace(DRUM, influence={k: (2.0 * v if k[0] == "P" else v) for k, v in DRUM.influence.items()})
        second = shop.session(machine)
        learned(shop, second, twice)
        after = shop.post(f"/machines/{machine}/influence", {"session_id": second})
        assert {entry["sensor"] for entry in after["refused"]} == {"P"}
        assert all(entry["change"] == pytest.approx(1.0, rel=1e-6) for entry in after["refused"])
        rows = {row["sensor"]: row["influence"] for row in after["saved"]["rows"]}
        old = {row["sensor"]: row["influence"] for row in before["saved"]["rows"]}
        assert rows["P"] == old["P"]
        history = shop.get(f"/machines/{machine}/influence")
        assert [entry["session_id"] for entry in history] == [second, first]
        assert shop.get(f"/machines/{machine}/influence?limit=1&offset=1") == history[1:]
        shop.refused("POST", f"/machines/{machine}/influence", {"session_id": second}, 409, "learned_already")

    def test_statistics_of_a_type_balance_a_machine_of_it(self, shop: Workshop) -> None:
        for turn in (0.99, 1.01):
            drum = replace(DRUM, influence={k: v * turn for k, v in DRUM.influence.items()})
            machine = shop.machine(type="KZS")
            session = shop.session(machine)
            learned(shop, session, drum)
            shop.post(f"/machines/{machine}/influence", {"session_id": session})
        typical = shop.get("/influence-statistics?type=KZS")
        assert typical["machines"] == 2
        third = shop.session(shop.machine(type="KZS"))
        scattered(shop, third, "initial", [])
        assert silenced(shop.correct(third, source="saved_influence", influence_of="type")) < 1e-6
        shop.refused("GET", "/influence-statistics?type=other", None, 404, "not_found")


class TestEarlierSessions:
    def test_an_earlier_session_tells_what_the_masses_do_but_not_how_the_drum_is_now(self, shop: Workshop) -> None:
        machine = shop.machine()
        first = shop.session(machine)
        shop.learn(first)
        now = replace(DRUM, initial={"P": 0.5 + 1.0j, "Q": 2.0 - 1.0j})
        session = shop.session(machine)
        shop.run(session, "initial", drum=now)
        shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, "too_few_runs")
        answer = shop.correct(session, earlier_sessions=[first])
        assert silenced(answer, now) < 1e-9
        assert len(answer["earlier_runs"][0]) == 3
        plan = shop.plan(session, answer)
        assert plan["predicted"]

    def test_a_session_of_another_machine_is_refused(self, shop: Workshop) -> None:
        other = shop.session()
        session = shop.session()
        shop.learn(session)
        body = {"source": "fit", "earlier_sessions": [other]}
        shop.refused("POST", f"/sessions/{session}/corrections", body, 409, "session_of_other_machine")


class TestWithoutPhase:
    def run(self, shop: Workshop, session: str, masses: list[dict[str, Any]]) -> None:
        readings = [{"sensor": s, "amplitude": abs(v), "phase_deg": None} for s, v in DRUM.vibration(masses).items()]
        kind = "trial" if masses else "initial"
        shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})

    def test_two_planes_from_amplitudes_alone(self, shop: Workshop) -> None:
        session = shop.session()
        self.run(shop, session, [])
        for plane in ("1", "2"):
            for angle in (0.0, 120.0, 240.0):
                self.run(shop, session, [mass(plane, 150.0, angle)])
        answer = shop.correct(session, source="amplitude_only")
        found = [answer["corrections"], *answer["alternatives"]]
        # Each sensor's own phase is unknown, so several corrections may explain the same amplitudes.
        assert min(silenced({"corrections": masses}) for masses in found) < 1e-3
        if answer["alternatives"]:
            assert answer["diagnostics"][0]["code"] == "ambiguous_without_phase"

    def test_too_few_runs_are_refused_with_the_number_that_is_needed(self, shop: Workshop) -> None:
        session = shop.session()
        self.run(shop, session, [])
        self.run(shop, session, [mass("1", 150.0, 0.0)])
        body = {"source": "amplitude_only"}
        problem = shop.refused("POST", f"/sessions/{session}/corrections", body, 422, "too_few_runs")
        assert "must have 5 amplitudes" in problem["detail"]
