"""Kills and a full disk, on real processes: nothing lost, nothing doubled. `tests.e2e.faults` is the long campaign."""

from __future__ import annotations

import json
import random
import shutil
from pathlib import Path

import pytest

from tests.e2e.faults import Place, fill_the_disk, kill_the_bridge, kill_the_service
from tests.support.processes.namespaces import no_namespace, run_inside


def test_the_bridge_killed_in_mid_stream(tmp_path: Path) -> None:
    stored = kill_the_bridge(Place(tmp_path, 10_000), 2, random.Random(1))
    assert stored == sorted(stored)


def test_the_service_killed_in_mid_stream(tmp_path: Path) -> None:
    stored = kill_the_service(Place(tmp_path, 10_000), 1, random.Random(2))
    assert stored == sorted(stored)


@pytest.mark.skipif(no_namespace() is not None, reason=no_namespace() or "")
def test_a_service_that_listens_itself_killed_in_mid_stream(tmp_path: Path) -> None:
    done = run_inside("tests.e2e.can_faults", str(tmp_path), "--kills", "1", timeout_s=300)
    assert done.returncode == 0, done.stdout + done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    assert (seen["lost_of_what_it_had"], seen["doubled"], seen["waiting"], seen["status"]) == (0, 0, 0, 0), seen
    assert seen["had_at_each_kill"][0] > 0
    assert seen["stored"] + sum(seen["gaps"]) <= seen["sent"]
    # What came while it was dead is gone, in one gap, and the service says about how much it was.
    (gap,) = seen["gaps"]
    assert seen["told_lost"][1] == pytest.approx(gap, rel=0.1)


@pytest.mark.skipif(shutil.which("prlimit") is None, reason="no prlimit: a file's size cannot be limited")
def test_a_full_disk_is_refused_loudly_and_breaks_nothing(tmp_path: Path) -> None:
    kept, lines = fill_the_disk(Place(tmp_path, 5_000), 300_000)
    assert 0 < kept < 5_000
    assert any(line.startswith("FULL: spool") and "nothing new is kept until" in line for line in lines)
