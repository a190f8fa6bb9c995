"""Record and replay as commands: into a file, out to a service, errors told with their line."""

from __future__ import annotations

import json
from pathlib import Path

import httpx2
import pytest

from drivers.errors import LogError
from drivers.files.readings import read_recording
from drivers.simulator.example import threshing_drum_example
from service.cli.commands import replay
from service.cli.commands.replay import record_until_stopped, replay_file
from service.cli.commands.serve import serving
from service.cli.support.demo_machine import machine_of
from service.cli.support.sources import Simulation
from service.settings import Settings

OPTIONS = {
    "token": None,
    "bus": "virtual:replay",
    "mapping": None,
    "sensors": "P,Q",
    "j1939": False,
    "source": None,
    "speed": None,
}


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(replay, "on_stop", lambda _: None)
    path = tmp_path / "shed.jsonl"
    record_until_stopped(path, Simulation(1, 0.0001), "shed", 20)
    return path


def test_what_was_recorded_arrives_once_however_often_it_is_replayed(tmp_path: Path, recording: Path) -> None:
    assert len(list(read_recording(recording))) == 20
    with (
        serving(Settings(database_url=f"sqlite:///{tmp_path / 'replay.db'}")) as url,
        httpx2.Client(base_url=f"{url}/api/v1", trust_env=False, timeout=60.0) as api,
    ):
        machine = api.post("/machines", json=machine_of(threshing_drum_example(1), "drum")).json()
        api.put("/sources/shed", json={"machine_id": machine["id"]}).raise_for_status()
        for _ in range(2):
            assert replay_file(recording, to="http", url=url, as_now=False, keep_going=False, **OPTIONS) == 0  # type: ignore[arg-type]
        again = [json.loads(line) for line in recording.read_text().splitlines()]
        receipt = api.post("/readings", json=again).json()
    assert receipt == {"accepted": 0, "duplicates": 20}


def test_onto_a_bus_at_its_own_time(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert replay_file(recording, to="can", url="", as_now=True, keep_going=False, **OPTIONS) == 0  # type: ignore[arg-type]
    assert "20 readings of 'shed' replayed" in capsys.readouterr().out


@pytest.mark.parametrize(("name", "text"), [("a.asc", "garbage\n"), ("a.jsonl", ""), ("a.json", '{"runs": []}')])
def test_a_file_without_a_reading_is_told(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(LogError, match=f"{name}: it holds no reading"):
        replay_file(tmp_path / name, to="can", url="", as_now=True, keep_going=True, **OPTIONS)  # type: ignore[arg-type]


def test_a_wrong_line_ends_it_or_is_passed_over_if_asked(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = recording.read_text().splitlines()
    lines[7] = "{"
    recording.write_text("\n".join(lines))
    with pytest.raises(LogError, match=r"shed.jsonl, line 8: it is no JSON"):
        replay_file(recording, to="can", url="", as_now=False, keep_going=False, **OPTIONS)  # type: ignore[arg-type]
    assert replay_file(recording, to="can", url="", as_now=False, keep_going=True, **OPTIONS) == 1  # type: ignore[arg-type]
    out = capsys.readouterr().out
    assert "passed over:" in out
    assert "19 readings of 'shed' replayed" in out
