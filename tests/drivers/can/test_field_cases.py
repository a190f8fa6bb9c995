"""Logs and DBCs as people had them: read rightly, or refused with cause and cure."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from drivers.can.mapping_file import read_mapping, standard_mapping
from drivers.clock import ManualClock
from drivers.errors import LogError
from drivers.files.replay import ReplayDriver
from drivers.reading import Reading

FOLDER = Path(__file__).parent / "field"
CASES: list[dict[str, Any]] = json.loads((FOLDER / "cases.json").read_text())["cases"]


def replayed(log: Path, mapping: str | None, started_at: str | None = None) -> tuple[list[Reading], str]:
    read = standard_mapping(("P", "Q")) if mapping is None else read_mapping(FOLDER / mapping)
    start = None if started_at is None else datetime.fromisoformat(started_at)
    with ReplayDriver(log, clock=ManualClock(), source="shed", mapping=read, started_at=start) as driver:
        return list(driver), "\n".join(driver.told())


@pytest.mark.parametrize("case", CASES, ids=[case["id"] for case in CASES])
def test_a_case_of_the_field(case: dict[str, Any]) -> None:
    log, mapping = FOLDER / case["log"], case.get("mapping")
    if "refused" in case:
        with pytest.raises(LogError, match=case["refused"]):
            replayed(log, mapping)
        if "started_at" not in case:
            return
    readings, told = replayed(log, mapping, case.get("started_at"))
    assert case.get("told", "") in told
    assert len(readings) == case["readings"]
    for end, name in ((readings[0], "first"), (readings[-1], "last")):
        if name in case:
            assert abs((end.taken_at - datetime.fromisoformat(case[name])).total_seconds()) < 1e-4
    for name in ("amplitude", "phase_deg", "speed_rpm"):
        if name in case:
            expected = case[name]
            for one in readings:
                got = getattr(one, name)
                assert got is None if expected is None else got == pytest.approx(expected, abs=0.06)


def test_two_logs_of_one_source_have_numbers_apart_and_the_same_ones_when_read_again() -> None:
    first, again = (replayed(FOLDER / "candump_l.log", None)[0] for _ in range(2))
    assert [one.sequence for one in first] == [one.sequence for one in again]
    later, _ = replayed(FOLDER / "asc_nodate.asc", None, "2026-05-05T08:30:00Z")
    assert {one.sequence for one in first}.isdisjoint(one.sequence for one in later)
    assert max(one.sequence for one in first) < min(one.sequence for one in later)


def test_a_log_of_other_messages_names_their_identifiers_and_the_mapping() -> None:
    with pytest.raises(
        LogError,
        match=r"none of its 8 frames is of a mapped message; their identifiers are 100, 200; check the mapping",
    ):
        replayed(FOLDER / "padded_dlc.log", None)


def test_refused_frames_do_not_send_the_user_to_the_mapping() -> None:
    with pytest.raises(LogError) as refused:
        replayed(FOLDER / "sna_no_range.log", "sna_no_range.toml")
    assert "check the mapping" not in str(refused.value)
