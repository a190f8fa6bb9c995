"""Every plan is followed by its check, whatever its correction came from."""

from __future__ import annotations

import cmath
from dataclasses import replace
from typing import Any

import pytest

from tests.support.http.workshop import DRUM, LinearDrum, Workshop, mass, on_rotor, reading


def changed(turn: float, share: float) -> LinearDrum:
    """The drum on another ground: every answer to a mass turned and scaled."""
    factor = share * cmath.rect(1.0, turn)
    return replace(DRUM, influence={key: factor * value for key, value in DRUM.influence.items()})


def taught(shop: Workshop) -> tuple[str, str]:
    """A machine that knows its coefficients, and a box."""
    machine, box = shop.machine(), shop.box()
    session = shop.session(machine, box)
    shop.learn(session)
    shop.post(f"/machines/{machine}/influence", {"session_id": session})
    return machine, box


def one_run_round(shop: Workshop, session: str, drum: LinearDrum) -> Any:
    """Correct by saved coefficients, fit the plan, take the check run."""
    correction = shop.correct(session, source="saved_influence")
    plan = shop.plan(session, correction, max_masses_per_plane=2)
    fitted = shop.fit(plan)["fitted"]
    body = {"kind": "check", "readings": drum.readings(on_rotor(fitted))}
    return shop.post(f"/sessions/{session}/runs", body)


def codes(entries: Any) -> list[str]:
    return [one["code"] for one in entries]


@pytest.mark.parametrize("turn", [1.2, 2.0, 3.1])
def test_coefficients_that_no_longer_hold_never_make_two_rounds_worse(shop: Workshop, turn: float) -> None:
    machine, box = taught(shop)
    drum = changed(turn, 1.1)
    session = shop.session(machine, box)
    shop.run(session, "initial", drum=drum)
    check = one_run_round(shop, session, drum)
    assert "coefficients_outdated" in codes(check["warnings"])
    before = max(abs(v) for v in drum.initial.values())
    worse = max(one["amplitude"] for one in check["readings"]) > 1.05 * before
    assert ("round_worse" in codes(check["warnings"])) or not worse
    refused = shop.client.post(f"/api/v1/sessions/{session}/corrections", json={"source": "saved_influence"})
    assert (refused.status_code, refused.json()["code"]) == (409, "coefficients_outdated")
    assert "trial run" in refused.json()["advice"]
    # Trial runs of this session take over: from then on its own fit is used.
    for plane in ("1", "2"):
        shop.run(session, "trial", [mass(plane, 200.0, 0.0)], drum)
    again = shop.correct(session, source="saved_influence")
    assert "coefficients_replaced" in codes(again["diagnostics"])
    residual = drum.vibration(again["corrections"])
    assert max(abs(v) for v in residual.values()) < 1e-6 * before


def test_coefficients_that_hold_are_used_without_a_word(shop: Workshop) -> None:
    machine, box = taught(shop)
    session = shop.session(machine, box)
    shop.run(session, "initial")
    check = one_run_round(shop, session, changed(0.03, 1.02))
    assert codes(check["warnings"]) == []
    assert codes(shop.correct(session, source="saved_influence")["diagnostics"]) == []


def test_a_round_by_a_balancer_that_made_it_worse_is_said(shop: Workshop) -> None:
    session = shop.session()
    shop.run(session, "initial")
    masses = [mass("1", 235.0, 21.0), mass("2", 270.0, 92.0)]
    correction = shop.correct(session, source="balancer", masses=masses)
    fitted = shop.fit(shop.plan(session, correction, objective="components"))["fitted"]
    body = {"kind": "check", "readings": DRUM.readings(on_rotor(fitted))}
    check = shop.post(f"/sessions/{session}/runs", body)
    assert codes(check["warnings"]) == ["round_worse"]
    assert check["warnings"][0]["parameters"]["ratio"] > 1.5


def test_runs_at_another_speed_than_stated_are_said(shop: Workshop) -> None:
    session = shop.session()
    for kind, on in (("initial", []), ("trial", [mass("1", 200.0, 0.0)]), ("trial", [mass("2", 200.0, 0.0)])):
        readings = [reading(name, v, speed_rpm=230.0) for name, v in DRUM.vibration(on).items()]
        shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": on, "readings": readings})
    assert "speed_off_nominal" in codes(shop.correct(session)["diagnostics"])


def test_no_run_at_the_service_speed_is_said(shop: Workshop) -> None:
    session = shop.session()
    for kind, on in (("initial", []), ("trial", [mass("1", 200.0, 0.0)]), ("trial", [mass("2", 200.0, 0.0)])):
        shop.run(session, kind, on, nominal_speed_rpm=300.0)
    found = shop.correct(session)["diagnostics"]
    assert codes(found) == ["service_speed_not_measured"]
    assert found[0]["parameters"] == {"service_rpm": 460.0, "measured_rpm": 300.0}
