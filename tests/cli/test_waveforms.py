"""A waveform file fed to a service by the commands, to a run taken from it; a simulated drum's waveforms likewise."""

from __future__ import annotations

import re
import signal
import struct
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path

import httpx2
import pytest

from drivers.errors import InvalidSetting, UnreadableFile
from drivers.files.readings import read_recording
from drivers.files.recording import Layout
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.spec import true_readings
from service.cli.commands import bridge, replay, simulate
from service.cli.commands.bridge import bridge_until_stopped
from service.cli.commands.replay import record_until_stopped
from service.cli.commands.serve import serving
from service.cli.support.demo_machine import machine_of
from service.cli.support.sources import Simulation, Waveform, waveform_of
from service.settings import Settings
from tests.cli.test_replay import OPTIONS
from tests.support.drivers.waveform_files import STARTED, recorded, write_csv, write_uff, write_wav

LAYOUT = """key_phasor = "{2}"
started_at = 2026-05-04T08:30:00Z
{3}

[[channel]]
column = "{0}"
sensor = "P"
full_scale = 5.0

[[channel]]
column = "{1}"
sensor = "Q"
full_scale = 5.0
"""
FILES: dict[str, tuple[Callable[..., Layout], tuple[str, ...]]] = {
    "drum.csv": (write_csv, ("P", "Q", "kp", 'time = "t"')),
    "drum.wav": (write_wav, ("1", "2", "3", "")),
    "drum.uff": (write_uff, ("1+Z", "2+Z", "9", "")),
}
TRUE = true_readings(threshing_drum_example())
BLOCKS = 6
"""Of 4 s, in the recording's 26."""


@pytest.fixture(autouse=True)
def no_signals(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (bridge, replay):
        monkeypatch.setattr(module, "on_stop", lambda _: None)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("service")
    with serving(Settings(database_url=f"sqlite:///{folder / 'service.db'}")) as url:
        yield url


def api_of(url: str) -> httpx2.Client:
    return httpx2.Client(base_url=f"{url}/api/v1", trust_env=False, timeout=60.0)


def waveform(folder: Path, name: str) -> Waveform:
    write, columns = FILES[name]
    recorded(write, folder / name)
    (folder / "layout.toml").write_text(LAYOUT.format(*columns))
    return waveform_of(folder / name, folder / "layout.toml", None)


def taken_run(url: str, source: str) -> dict[str, tuple[float, float]]:
    """The initial run of a session, taken from what is stored of the source."""
    with api_of(url) as api:
        machine = next(one["machine_id"] for one in api.get("/sources").json() if one["name"] == source)
        session = api.post("/sessions", json={"machine_id": machine}).raise_for_status().json()["id"]
        ended = STARTED + timedelta(seconds=26)
        take = {"source": source, "from": STARTED.isoformat(), "to": ended.isoformat()}
        run = api.post(f"/sessions/{session}/runs", json={"kind": "initial", "take": take}).raise_for_status().json()
    return {one["sensor"]: (one["amplitude"], one["phase_deg"]) for one in run["readings"]}


def bind(url: str, source: str) -> None:
    with api_of(url) as api:
        machine = api.post("/machines", json=machine_of(threshing_drum_example(), source)).raise_for_status().json()
        api.put(f"/sources/{source}", json={"machine_id": machine["id"]}).raise_for_status()


def check(run: dict[str, tuple[float, float]]) -> None:
    """The drum's true vectors, as near as the noise of its bearings lets six blocks tell."""
    assert set(run) == {"P", "Q"}
    for sensor, (amplitude, phase) in run.items():
        assert amplitude == pytest.approx(TRUE[sensor][0], rel=0.01)
        assert (phase - TRUE[sensor][1] + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.5)


def test_a_recorded_waveform_is_bridged_once_however_often_it_is_sent(
    tmp_path: Path, service: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bind(service, "shed")
    for attempt in ("first", "again"):
        bridge_until_stopped(
            waveform(tmp_path, "drum.wav"),
            url=service,
            token=None,
            source="shed",
            spool=tmp_path / f"{attempt}.db",
            max_bytes=2**20,
            status_s=10.0,
            send_again=False,
        )
        assert f"waiting 0, delivered {2 * BLOCKS}" in capsys.readouterr().out
    check(taken_run(service, "shed"))


@pytest.mark.parametrize("name", ["drum.csv", "drum.uff"])
def test_a_recorded_waveform_is_replayed_to_a_run(
    tmp_path: Path, service: str, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bind(service, name)
    options = OPTIONS | {"source": name}
    replay.replay_file(waveform(tmp_path, name), to="http", url=service, as_now=False, keep_going=False, **options)  # type: ignore[arg-type]
    assert f"{2 * BLOCKS} readings of {name!r} replayed" in capsys.readouterr().out
    check(taken_run(service, name))


def test_what_is_recorded_of_a_waveform_is_what_it_gives(tmp_path: Path) -> None:
    record_until_stopped(tmp_path / "out.jsonl", waveform(tmp_path, "drum.csv"), "shed", None)
    with waveform(tmp_path, "drum.csv").driver("shed") as driver:
        assert list(read_recording(tmp_path / "out.jsonl")) == list(driver)


def test_a_waveform_of_which_every_block_is_refused_is_told_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = waveform(tmp_path, "drum.wav")
    whole = slow.file.read_bytes()
    slow.file.write_bytes(whole[:24] + struct.pack("<I", 8) + whole[28:])
    with pytest.raises(UnreadableFile, match=r"drum\.wav: gives no reading: 0 key-phasor edges"):
        record_until_stopped(tmp_path / "out.jsonl", slow, "shed", None)
    assert not (tmp_path / "out.jsonl").exists()
    options = OPTIONS | {"source": "shed"}
    with pytest.raises(UnreadableFile, match="gives no reading"):
        replay.replay_file(slow, to="can", url="", as_now=False, keep_going=False, **options)  # type: ignore[arg-type]
    assert capsys.readouterr().out.count("the first because: ") == 2


def test_two_recordings_of_a_source_do_not_share_numbers(tmp_path: Path) -> None:
    first = waveform(tmp_path, "drum.wav")
    later = waveform_of(first.file, tmp_path / "layout.toml", STARTED + timedelta(seconds=26))
    with first.driver("shed") as one, later.driver("shed") as other:
        assert max(reading.sequence for reading in one) < min(reading.sequence for reading in other)


def test_a_waveform_without_a_layout_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidSetting, match="needs a layout"):
        waveform_of(tmp_path / "drum.wav", None, None)


def test_simulated_waveforms_are_sent_as_readings(
    service: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    out = simulate.out_to_http(service)
    simulation = Simulation(3, waveforms=True)
    simulate.simulate_until_stopped(service, None, out, "127.0.0.1:0", "sim", simulation, 1)
    said = capsys.readouterr().out
    assert re.search(r"control port http://127.0.0.1:\d+\n", said)
    assert "stopped after 2 readings" in said
