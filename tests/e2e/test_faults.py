"""Kills and a full disk, on real processes: nothing lost, nothing doubled. `tests.e2e.faults` is the long campaign."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

import pytest

from tests.e2e.faults import Place, fill_the_disk, kill_the_bridge, kill_the_service


def test_the_bridge_killed_in_mid_stream(tmp_path: Path) -> None:
    stored = kill_the_bridge(Place(tmp_path, 10_000), 2, random.Random(1))
    assert stored == sorted(stored)


def test_the_service_killed_in_mid_stream(tmp_path: Path) -> None:
    stored = kill_the_service(Place(tmp_path, 10_000), 1, random.Random(2))
    assert stored == sorted(stored)


@pytest.mark.skipif(shutil.which("prlimit") is None, reason="no prlimit: a file's size cannot be limited")
def test_a_full_disk_is_refused_loudly_and_breaks_nothing(tmp_path: Path) -> None:
    kept, lines = fill_the_disk(Place(tmp_path, 5_000), 300_000)
    assert 0 < kept < 5_000
    assert any(line.startswith("FULL: spool") and "nothing new is kept until" in line for line in lines)
