"""What is said of a correction, over HTTP: the grade it reaches, how well it is known, and what does not fit."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from tests.support.http.scattered_runs import learned, scattered, silenced
from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass, reading


class TestQuality:
    def test_the_grade_reached_follows_from_the_fit(self, shop: Workshop) -> None:
        session = shop.session(shop.machine(balance_grade_mm_s=16.0))
        learned(shop, session)
        tolerance = shop.correct(session)["tolerance"]
        omega = 460.0 * math.pi / 30.0
        assert tolerance["permissible_gmm"] == pytest.approx(120.0 * 16.0 / omega * 1000.0, rel=1e-9)
        assert sum(b["permissible_gmm"] for b in tolerance["bearings"]) == pytest.approx(tolerance["permissible_gmm"])
        assert tolerance["interval"]["low"] <= tolerance["grade_reached_mm_s"] <= tolerance["interval"]["high"]
        report = shop.get(f"/sessions/{session}/report.json")
        assert report["tolerance"]["grade_reached_mm_s"] == pytest.approx(tolerance["grade_reached_mm_s"], rel=1e-6)

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"bearings": [{"name": "A", "axial_mm": 200.0}, {"name": "B", "axial_mm": 600.0}]}, "overhung"),
            ({"rotor_mass_kg": None}, "rotor_mass_kg"),
            ({"bearings": [], "sensors": [{"name": "P"}, {"name": "Q"}]}, "axial_mm"),
        ],
    )
    def test_a_grade_that_cannot_be_judged_is_said_so(self, shop: Workshop, change: Any, said: str) -> None:
        session = shop.session(shop.machine(balance_grade_mm_s=16.0, **change))
        learned(shop, session)
        for answer in (shop.correct(session), shop.get(f"/sessions/{session}/report.json")):
            assert answer["tolerance"] is None
            assert said in answer["tolerance_missing"]
        plain = shop.session()
        learned(shop, plain)
        assert shop.correct(plain)["tolerance_missing"] is None

    def test_zones_only_where_the_machine_states_its_group(self, shop: Workshop) -> None:
        for group, zone in ((None, None), ({"group": 2, "support": "rigid"}, "C")):
            session = shop.session(shop.machine(iso_20816=group))
            readings = [reading("P", 1.0 + 0j, overall_rms=3.0)]
            shop.post(f"/sessions/{session}/runs", {"kind": "initial", "readings": readings})
            assert shop.get(f"/sessions/{session}/report.json")["before_after"][0]["zone_before"] == zone

    def test_a_run_above_service_speed_is_stored_and_warned_about(self, shop: Workshop) -> None:
        session = shop.session()
        fast = [{**reading("P", 1.0), "speed_rpm": 900.0}]
        for more in (
            {"nominal_speed_rpm": 900.0},
            {"readings": fast},
            {"readings": fast, "nominal_speed_rpm": 470},
        ):
            warned = shop.run(session, "initial", **more)["warnings"]
            assert [w["code"] for w in warned] == ["over_speed"]
            assert "900 r/min is above the service speed of 460 r/min" in warned[0]["message"]
        assert shop.run(session, "initial", nominal_speed_rpm=469.0)["warnings"] == []

    def test_trial_masses_are_suggested_and_a_large_one_is_warned_about_in_newtons(self, shop: Workshop) -> None:
        machine = shop.machine()
        session = shop.session(machine)
        asked = shop.get(f"/sessions/{session}/trial-masses")
        # A tenth of the load on the nearer bearing, whose share follows from the mass centre.
        load = 120.0 * 440.0 / 920.0 * 9.80665
        expected = 0.1 * load / (0.33 * (460.0 * math.pi / 30.0) ** 2) * 1000.0
        assert asked[0]["mass_g"] == pytest.approx(expected, rel=1e-9)
        assert asked[0]["angle_deg"] is None
        learned(shop, session)
        run = shop.run(session, "trial", [mass("1", 400.0, 0.0)])
        assert [w["code"] for w in run["warnings"]] == ["trial_mass_large"]
        assert " N " in run["warnings"][0]["message"]
        shop.post(f"/machines/{machine}/influence", {"session_id": session})
        assert all(s["angle_deg"] is not None for s in shop.get(f"/sessions/{session}/trial-masses"))

    def test_ellipses_and_intervals_shrink_with_the_scatter(self, shop: Workshop) -> None:
        session = shop.session()
        learned(shop, session)
        for entry in shop.correct(session)["corrections"]:
            assert entry["ellipse"]["major_g"] >= entry["ellipse"]["minor_g"] > 0.0
            assert entry["interval"]["low"] < entry["mass_g"] < entry["interval"]["high"]
            assert entry["angle_interval"]["low"] < entry["angle_deg"] < entry["angle_interval"]["high"]

    def test_inexact_placement_widens_the_prediction(self, shop: Workshop) -> None:
        session = shop.session()
        learned(shop, session)
        correction = shop.correct(session)
        widths = [
            [v["scatter"] for v in shop.plan(session, correction, **tolerance)["predicted"]]
            for tolerance in ({}, {"angle_tolerance_deg": 2.0, "mass_tolerance_g": 1.0})
        ]
        assert all(wide > narrow for narrow, wide in zip(*widths, strict=True))


class TestDiagnostics:
    def test_a_mirrored_phase_is_named_and_a_mistyped_run_can_be_superseded(self, shop: Workshop) -> None:
        session = shop.session()
        learned(shop, session)
        odd = replace(DRUM, initial={"P": 9.0 + 0j, "Q": -7.0j})
        bad = scattered(shop, session, "correction", [mass("1", 100.0, 30.0)], odd)
        codes = {d["code"] for d in shop.correct(session)["diagnostics"]}
        assert codes & {"bad_run", "one_of_runs_wrong", "sense_mirrored", "not_linear"}, codes
        again = [mass("1", 100.0, 30.0)]
        body = {"kind": "correction", "masses": again, "readings": DRUM.readings(again), "supersedes": bad["id"]}
        shop.post(f"/sessions/{session}/runs", body)
        good = shop.correct(session)
        assert silenced(good) < 1e-6
        kept = next(run for run in shop.get(f"/sessions/{session}")["runs"] if run["id"] == bad["id"])
        assert kept["excluded"] is True
        assert kept["reason"] == "superseded by run 5"

    def test_contradicting_runs_are_named_by_number(self, shop: Workshop) -> None:
        session = shop.session()
        learned(shop, session)
        scattered(shop, session, "trial", [mass("1", 200.0, 0.0)], replace(DRUM, initial={"P": 8.0 + 0j, "Q": 8.0j}))
        found = [d for d in shop.correct(session)["diagnostics"] if d["code"] == "runs_contradict"]
        assert found
        assert set(found[0]["runs"]) == {2, 4}


def test_sensors_that_no_mass_moves_give_no_correction(shop: Workshop) -> None:
    session = shop.session()
    for kind, masses in (("initial", []), ("trial", [mass("1", 200.0, 0.0)]), ("trial", [mass("2", 200.0, 0.0)])):
        body = {"kind": kind, "masses": masses, "readings": DRUM.readings()}
        shop.post(f"/sessions/{session}/runs", body)
    shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, "planes_dependent")


def test_planes_that_act_alike_to_machine_precision(shop: Workshop) -> None:
    session = shop.session()
    factor = 0.7 + 0.2j
    alike = {(s, "2"): factor * DRUM.influence[s, "1"] for s in ("P", "Q")}
    shop.learn(session, type(DRUM)(DRUM.initial, {**DRUM.influence, **alike}))
    problem = shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, "planes_dependent")
    assert problem["field"] == "planes"
    assert 'plane "1" and plane "2"' in problem["detail"]
    assert shop.state(session) == "open"


def test_runs_that_never_tell_the_planes_apart(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    for grams in (100.0, 200.0, 300.0):
        shop.run(session, "trial", [mass("1", grams, 0.0), mass("2", grams, 90.0)])
    shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, "planes_not_separated")


def test_dead_sensors(shop: Workshop) -> None:
    session = shop.session()
    shop.learn(session, type(DRUM)({"P": 0j, "Q": 0j}, dict.fromkeys(DRUM.influence, 0j)))
    shop.refused("POST", f"/sessions/{session}/corrections", {"source": "fit"}, 422, "all_readings_zero")


class TestIsItUnbalance:
    """Directions, axial sensors and the broadband value reach the diagnostics."""

    @pytest.mark.parametrize(
        ("h", "v", "a", "overall", "code"),
        [
            (2.0, 1.8j, 0.3, 1.1, None),
            (2.0, 0.5j, 0.3, 1.1, "not_unbalance_direction"),
            (2.0, 1.8, 0.3, 1.1, "not_unbalance_phase"),
            (2.0, 1.8j, 1.95, 1.1, "not_unbalance_axial"),
            (2.0, 1.8j, 0.3, 2.5, "not_unbalance_1x_share"),
        ],
    )
    def test_what_the_sensors_state_is_judged(
        self, shop: Workshop, h: complex, v: complex, a: complex, overall: float, code: str | None
    ) -> None:
        directions = {"H": "horizontal", "V": "vertical", "A": "axial"}
        sensors = [{"name": name, "bearing": "P", "direction": way} for name, way in directions.items()]
        plane = {"name": "1", "radius_mm": 100.0, "positions_deg": [0.0], "max_masses": 1}
        session = shop.session(shop.machine(sensors=sensors, planes=[plane]))
        drum = LinearDrum({"H": h, "V": v, "A": a}, {("H", "1"): 0.01, ("V", "1"): 0.01j, ("A", "1"): 0.003})
        for masses in ([], [mass("1", 100.0, 90.0)]):
            vectors = drum.vibration(masses)
            readings = [reading(s, x, scatter=0.005, overall_rms=overall * abs(x)) for s, x in vectors.items()]
            kind = "trial" if masses else "initial"
            shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": masses, "readings": readings})
        told = {d["code"] for d in shop.correct(session)["diagnostics"]}
        assert {c for c in told if c.startswith("not_unbalance")} == ({code} if code else set())
