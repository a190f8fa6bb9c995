"""`drumtrue check`, `layout` and `mapping`: values and reasons shown, drafts written and never over another file."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path

import can
import pytest

from drivers.can.bus import BusAddress
from drivers.can.frames import Frame
from drivers.can.mapping_file import read_mapping, standard_mapping
from drivers.errors import InvalidSetting, LogError
from service.cli.commands.check import check_bus, check_log, live
from service.cli.commands.drafts import layout, mapping
from tests.support.drivers.frames import sensor_frames
from tests.support.drivers.waveform_files import drum_block, write_csv

FIELD = Path(__file__).parents[1] / "drivers" / "can" / "field"


def test_a_log_is_shown_with_values_and_reasons(capsys: pytest.CaptureFixture[str]) -> None:
    status = check_log(FIELD / "mixed.log", read_mapping(FIELD / "sna_in_range.toml"), 2, None)
    told = capsys.readouterr().out
    assert status == 0
    assert "0.001 s  200  Vib1: P amplitude 3 mm/s (Amp 300), P phase 112 deg (Pha 1120)" in told
    assert "-> P 3 mm/s, at 112.0 deg, 460 r/min" in told
    assert "P amplitude 655.35 mm/s (Amp 65535, not_available)" in told
    assert told.count("!! not_available") == 3  # of four
    assert "  4  not_available" in told


def test_a_log_that_gives_nothing_says_what_never_came(capsys: pytest.CaptureFixture[str]) -> None:
    assert check_log(FIELD / "padded_dlc.log", standard_mapping(("P",)), 2, None) == 1
    told = capsys.readouterr().out
    assert "Sensor1 never came: check its identifier" in told
    assert "not mapped: 100 (4), 200 (4)" in told
    assert told.splitlines()[-1].startswith("no reading")


def test_a_log_without_a_start_is_checked_and_the_start_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert check_log(FIELD / "asc_nodate.asc", standard_mapping(("P", "Q")), 0, None) == 0
    assert "state --started-at to replay it" in capsys.readouterr().out


def test_wrong_lines_are_told_and_passed_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.log"
    good = (FIELD / "candump_l.log").read_text().splitlines()
    path.write_text("\n".join([*good[:9], *["(1777883400.0) can0 zz#zz"] * 8, *good[9:], ""]))
    assert check_log(path, standard_mapping(("P", "Q")), 0, None) == 0
    told = capsys.readouterr().out
    assert told.count("wrong: ") == 5
    assert "and 3 more lines that are wrong" in told


@pytest.mark.parametrize("fd", [False, True])
def test_a_live_bus_is_shown(fd: bool, capsys: pytest.CaptureFixture[str]) -> None:
    stop, sent = threading.Event(), threading.Event()
    protocol = can.CanProtocol.CAN_FD if fd else can.CanProtocol.CAN_20
    with can.Bus(interface="virtual", channel=f"check{fd}", protocol=protocol) as bus:

        def send() -> None:
            while not stop.wait(0.02):
                for frame in sensor_frames(3):
                    frame.is_fd = fd
                    bus.send(frame)
                sent.set()

        thread = threading.Thread(target=send)
        thread.start()
        address = BusAddress("virtual", f"check{fd}", {"protocol": protocol})
        status = check_bus(address, standard_mapping(("P",)), 5, 0.3, threading.Event())
        stop.set()
        thread.join()
    assert (status, sent.is_set()) == (0, True)
    assert "last: P " in capsys.readouterr().out


def test_listening_ends_with_its_time_or_when_it_is_stopped() -> None:
    stop, passed = threading.Event(), [0.0]

    class Endless:
        def take(self, timeout_s: float) -> Sequence[Frame]:
            passed[0] += timeout_s
            return ((None, 1, False, b"", True),)

        def close(self) -> None: ...

    assert len(list(live(Endless(), 1.05, stop, lambda: passed[0]))) == 11
    stop.set()
    assert list(live(Endless(), 1.0, stop, lambda: passed[0])) == []


def test_drafts_are_written_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.csv"
    write_csv(path, drum_block())
    layout(path, tmp_path / "a.toml")
    mapping(FIELD / "mux_pages.dbc", tmp_path / "m.toml")
    told = capsys.readouterr().out
    assert "correct what is marked there" in told
    assert "Vib1 0x200, 8 bytes: Page, Amp [mm/s], Pha [deg], Cnt" in told
    with pytest.raises(LogError, match="it is there already"):
        layout(path, tmp_path / "a.toml")
    with pytest.raises(LogError, match="it is there already"):
        mapping(FIELD / "mux_pages.dbc", tmp_path / "m.toml")
    layout(path)
    assert 'key_phasor = "kp"' in capsys.readouterr().out
    with pytest.raises(LogError, match="cannot be written"):
        layout(path, tmp_path / "no" / "a.toml")
    (tmp_path / "bad.dbc").write_bytes(b"\0\xff not a dbc")
    with pytest.raises(InvalidSetting, match="is no DBC that can be read"):
        mapping(tmp_path / "bad.dbc")
