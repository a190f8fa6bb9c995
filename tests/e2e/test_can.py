"""Separate processes over a CAN bus: simulated drum, bridge, service; the right masses in the right holes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.processes.can_loop import ANSWER
from tests.support.processes.namespaces import no_namespace, run_inside


@pytest.mark.skipif(no_namespace() is not None, reason=no_namespace() or "")
def test_a_drum_on_the_bus_is_balanced(tmp_path: Path) -> None:
    done = run_inside("tests.support.processes.can_loop", str(tmp_path), timeout_s=120)
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(done.stdout.splitlines()[-1])
    assert all(reduction >= 0.9 for reduction in result["reductions"]), result["reductions"]
    assert {piece["plane"] for piece in result["pieces"]} == {"1", "2"}
    assert result["statuses"] == [0, 0, 0]
    answered = result["answered"]
    # Each way carried it once.
    for masses in (*(one["masses"] for one in answered["answers"]), answered["corrections"]):
        assert [(one["plane"], one["mass_g"], one["angle_deg"]) for one in masses] == [
            (plane, pytest.approx(mass), pytest.approx(angle)) for plane, mass, angle in ANSWER
        ]
    assert len(answered["answers"]) == 2
    assert answered["plan"]["status"] == "optimal"
    assert {one["plane"] for one in answered["plan"]["placements"]} == {"1", "2"}
    # Both ways read the same frames: the same vectors, none lost and none doubled on either.
    bridged, direct = result["bridged"], result["direct"]
    assert len(bridged) > 100
    assert bridged == direct[-len(bridged) :]
