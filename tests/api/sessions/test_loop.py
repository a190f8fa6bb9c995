"""The loop a technician goes through, from a machine to a closed session."""

from __future__ import annotations

import pytest

from tests.support.http.workshop import DRUM, Workshop, on_rotor, vector_of


def test_from_readings_to_a_balanced_drum(shop: Workshop) -> None:
    session = shop.session()
    assert shop.state(session) == "open"
    shop.learn(session)
    correction = shop.correct(session)
    assert shop.state(session) == "corrected"
    residual = DRUM.vibration([{**c, "angle_deg": c["angle_deg"]} for c in correction["corrections"]])
    assert all(abs(vector) < 1e-9 for vector in residual.values())

    plan = shop.plan(session, correction, max_masses_per_plane=2, method="modified_jaya")
    assert (shop.state(session), plan["status"]) == ("planned", "heuristic")
    fitted = shop.fit(plan)
    assert (shop.state(session), fitted["state"]) == ("fitted", "fitted")

    check = shop.post(
        f"/sessions/{session}/runs", {"kind": "check", "readings": DRUM.readings(on_rotor(fitted["fitted"]))}
    )
    assert shop.state(session) == "checked"
    assert check["masses"] == on_rotor(fitted["fitted"])
    for measured, expected in zip(check["readings"], plan["predicted"], strict=True):
        assert vector_of(measured) == pytest.approx(vector_of(expected), abs=1e-9)

    report = shop.get(f"/sessions/{session}/report.json")
    assert [line["sensor"] for line in report["before_after"]] == ["P", "Q"]
    assert all(line["reduction"] > 0.9 for line in report["before_after"])
    assert report["fitted"] == fitted["fitted"]
    shop.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
    assert shop.state(session) == "closed"


def test_lists_are_newest_first_and_paged(shop: Workshop) -> None:
    machines = [shop.machine() for _ in range(3)]
    box = shop.box()
    sessions = [shop.session(machine, box) for machine in machines]
    assert [m["id"] for m in shop.get("/machines")] == machines[::-1]
    assert [m["id"] for m in shop.get("/machines?limit=1&offset=1")] == [machines[1]]
    assert [s["id"] for s in shop.get("/sessions")] == sessions[::-1]
    assert [s["id"] for s in shop.get(f"/sessions?machine_id={machines[0]}")] == [sessions[0]]
    assert shop.get("/sessions?state=closed") == []
    assert [c["id"] for c in shop.get("/catalogues")] == [box]


def test_health_stands_at_the_root_and_under_the_prefix(shop: Workshop) -> None:
    at_root = shop.client.get("/health")
    assert at_root.status_code == 200
    assert at_root.json() == shop.get("/health")
    assert at_root.json()["status"] == "ok"


def test_the_machine_of_a_session_is_a_copy(shop: Workshop) -> None:
    machine = shop.machine()
    session = shop.session(machine)
    shop.ask("PATCH", f"/machines/{machine}", {"service_speed_rpm": 500.0, "rotor_mass_kg": None})
    assert shop.get(f"/machines/{machine}")["service_speed_rpm"] == 500.0
    assert shop.get(f"/machines/{machine}")["rotor_mass_kg"] is None
    copy = shop.get(f"/sessions/{session}")["machine"]
    assert (copy["service_speed_rpm"], copy["rotor_mass_kg"]) == (460.0, 120.0)
