"""Separate processes over a CAN bus: simulated drum, bridge, service; the right masses in the right holes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.e2e.namespaces import no_namespace, run_inside

pytestmark = pytest.mark.skipif(no_namespace() is not None, reason=no_namespace() or "")


@pytest.mark.parametrize("how", ["bridge", "listen"])
def test_a_drum_on_the_bus_is_balanced(tmp_path: Path, how: str) -> None:
    done = run_inside("tests.e2e.can_loop", str(tmp_path), how, timeout_s=60)
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(done.stdout.splitlines()[-1])
    assert all(reduction >= 0.9 for reduction in result["reductions"]), result
    assert {piece["plane"] for piece in result["pieces"]} == {"1", "2"}
    assert result["statuses"] == [0] * len(result["statuses"])
