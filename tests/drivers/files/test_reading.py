"""Files of every format read the drum they were recorded from."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.errors import InvalidSetting, UnreadableFile
from drivers.files.csv_file import read_csv
from drivers.files.driver import WaveformFile, read_recording
from drivers.files.recording import Layout
from drivers.files.wav_file import read_wav
from drivers.signal.block import Channel
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.spec import true_readings
from tests.support.drivers.analytic import apart
from tests.support.drivers.waveform_files import (
    RATE,
    STARTED,
    drum_block,
    layout,
    recorded,
    write_csv,
    write_uff,
    write_wav,
)

Writer = Callable[..., Layout]
FORMATS: list[tuple[str, Writer, dict[str, Any]]] = [
    ("a.csv", write_csv, {}),
    ("a.txt", write_csv, {"separator": "\t"}),
    ("german.csv", write_csv, {"separator": ";", "point": ","}),
    ("bare.csv", write_csv, {"time": False}),
    ("a.wav", write_wav, {}),
    ("24.wav", write_wav, {"bits": 24}),
    ("32.WAV", write_wav, {"bits": 32, "extensible": True}),
    ("float.wav", write_wav, {"bits": 32, "code": 3}),
    ("double.wav", write_wav, {"bits": 64, "code": 3}),
    ("a.uff", write_uff, {}),
    ("text.unv", write_uff, {"binary": 0}),
]


@pytest.mark.parametrize(("name", "write", "options"), FORMATS, ids=[name for name, _, _ in FORMATS])
class TestFormats:
    def test_readings_are_those_of_the_drum(
        self, tmp_path: Path, name: str, write: Writer, options: dict[str, Any]
    ) -> None:
        path = tmp_path / name
        used = recorded(write, path, **options)
        with WaveformFile(path, used, source="shed", block_s=8.0, session_id="s") as file:
            readings = list(file)
        assert [(one.sequence, one.sensor) for one in readings] == list(enumerate("PQPQPQ", start=1))
        assert [one.taken_at for one in readings[::2]] == [STARTED + timedelta(seconds=8 * i) for i in range(3)]
        for reading in readings:
            assert reading.phase_deg is not None
            amplitude, phase_deg = true_readings(threshing_drum_example(), speed_rpm=reading.speed_rpm)[reading.sensor]
            assert reading.amplitude == pytest.approx(amplitude, rel=0.005)
            assert apart(reading.phase_deg, phase_deg) <= 0.5
            assert reading.session_id == "s"

    def test_columns_that_are_not_there_are_named(
        self, tmp_path: Path, name: str, write: Writer, options: dict[str, Any]
    ) -> None:
        path = tmp_path / name
        used = replace(recorded(write, path, **options), key_phasor="nowhere")
        with pytest.raises(UnreadableFile, match=r"no column 'nowhere'.*columns are"):
            WaveformFile(path, used, source="shed").open()


class TestDriver:
    def test_the_same_file_gives_the_same_readings_in_every_run_and_after_any_stop(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        used = recorded(write_wav, path)
        with WaveformFile(path, used, source="shed") as file:
            at_once = list(file)
        stopped = WaveformFile(path, used, source="shed")
        piecewise = []
        for _ in range(20):
            with stopped:
                reading = next(iter(stopped), None)
            if reading is not None:
                piecewise.append(reading)
        assert piecewise == at_once
        assert len(at_once) == 12

    def test_a_file_shorter_than_a_block_is_one_block(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        used = recorded(write_wav, path)
        with WaveformFile(path, used, source="shed", block_s=60.0) as file:
            assert len(list(file)) == 2

    def test_blocks_without_a_reading_are_counted_refused(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        used = recorded(write_wav, path)
        with WaveformFile(path, used, source="shed", block_s=0.4) as file:
            assert list(file) == []
            assert file.health().refused == 2 * int(26.0 / 0.4)
            assert file.last_refusal is not None
            assert "record for longer" in file.last_refusal

    @pytest.mark.parametrize("name", ["gone.csv", "a.mp3", "folder.wav"])
    def test_what_cannot_be_opened(self, tmp_path: Path, name: str) -> None:
        (tmp_path / "folder.wav").mkdir()
        with pytest.raises(UnreadableFile, match=name) as error:
            WaveformFile(tmp_path / name, layout(("1", "2", "3")), source="shed").open()
        assert error.value.path == str(tmp_path / name)


class TestUnits:
    def test_a_wav_file_needs_the_full_scale(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        used = recorded(write_wav, path)
        with pytest.raises(InvalidSetting, match="full_scale of 'P'"):
            WaveformFile(path, replace(used, channels=(("1", Channel("P")),)), source="shed").open()

    @pytest.mark.parametrize(("name", "write"), [("a.wav", write_wav), ("a.uff", write_uff)])
    def test_a_layout_with_another_sample_rate_than_the_file_is_refused(
        self, tmp_path: Path, name: str, write: Writer
    ) -> None:
        path = tmp_path / name
        used = recorded(write, path)
        assert read_recording(path, replace(used, sample_rate_hz=RATE)).sample_rate_hz == pytest.approx(RATE)
        with pytest.raises(UnreadableFile, match=r"sampled at 640 Hz, the layout says sample_rate_hz 1280"):
            read_recording(path, replace(used, sample_rate_hz=2 * RATE))

    @pytest.mark.parametrize("raw", [{"raw_quantity": "velocity", "raw_unit": "mm/s"}, {"raw_unit": "g"}])
    def test_a_universal_file_that_states_another_unit_is_refused(self, tmp_path: Path, raw: dict[str, Any]) -> None:
        path = tmp_path / "a.uff"
        used = recorded(write_uff, path)
        with pytest.raises(UnreadableFile, match="correct the layout"):
            WaveformFile(path, replace(used, channels=(("1+Z", Channel("P", **raw)),)), source="shed").open()

    def test_a_layout_states_its_time_in_utc_and_its_sensors_once(self) -> None:
        east = timezone(timedelta(hours=2))
        for changes in (
            {"started_at": datetime(2026, 5, 4)},  # noqa: DTZ001
            {"started_at": datetime(2026, 5, 4, tzinfo=east)},
            {"channels": ()},
            {"channels": (("1", Channel("P")), ("2", Channel("P")))},
            {"sample_rate_hz": 0.0},
            {"sample_rate_hz": RATE, "time": "t"},
        ):
            with pytest.raises(InvalidSetting):
                layout(("1", "2", "3"), **changes)


class TestCsv:
    def refusal(self, tmp_path: Path, text: str | bytes, **options: Any) -> UnreadableFile:
        path = tmp_path / "a.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(UnreadableFile) as error:
            read_csv(path, **({"time": "t"} | options))
        return error.value

    def test_a_cell_that_is_no_number_is_named_with_its_line(self, tmp_path: Path) -> None:
        for cell in ("x", "1_0", "inf", "1e999"):
            error = self.refusal(tmp_path, f"# a\nt,a\n0,1\n\n1,{cell}\n")
            assert error.line == 5
            assert repr(cell) in str(error)

    def test_too_many_or_too_few_cells(self, tmp_path: Path) -> None:
        assert self.refusal(tmp_path, "t,a\n0,1\n1\n").line == 3
        assert self.refusal(tmp_path, "t,a\n0,1,2\n").line == 2

    @pytest.mark.parametrize(
        "text", ["t,t\n0,1\n1,1\n", "t,\n0,1\n1,1\n", "# only words\n", "", "t,a\n0,1\n", b"\xff\xfe"]
    )
    def test_no_table(self, tmp_path: Path, text: str | bytes) -> None:
        self.refusal(tmp_path, text)

    @pytest.mark.parametrize(
        "times", [[0, 1, 1, 2], [0, 2, 1, 3], [0, 1, 1.5, 2.5, 3.7], [0, 1, 2, 50], [0, float("nan"), 2, 3]]
    )
    def test_times_that_are_not_even(self, tmp_path: Path, times: list[float]) -> None:
        self.refusal(tmp_path, "t,a\n" + "".join(f"{t},1\n" for t in times))

    def test_no_rate_at_all(self, tmp_path: Path) -> None:
        assert "sample rate" in str(self.refusal(tmp_path, "a\n1\n2\n", time=None))
        assert "no column 't'" in str(self.refusal(tmp_path, "a\n1\n2\n"))

    def test_gaps_and_empty_cells_are_lost_samples_and_rounded_times_do_not_matter(self, tmp_path: Path) -> None:
        path = tmp_path / "a.csv"
        moments = [i for i in range(1000) if i not in (100, 101, 500)]
        path.write_text("t,a\n" + "".join(f"{i / RATE:.4f},{'' if i == 700 else i}\n" for i in moments))
        recording = read_csv(path, time="t")
        assert recording.sample_rate_hz == pytest.approx(RATE, rel=1e-3)
        column = recording.column("a")
        assert np.flatnonzero(np.isnan(column)).tolist() == [100, 101, 500, 700]
        assert column[999] == 999.0


class TestWav:
    def test_eight_bits(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        block = drum_block()
        write_wav(path, block, bits=8)
        assert np.abs(read_wav(path).column("1") * 5.0 - block.samples[0]).max() <= 5.0 / 100.0

    def test_a_recording_cut_short_is_read_as_far_as_it_goes(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        recorded(write_wav, path)
        good = path.read_bytes()
        path.write_bytes(good[:-1001])
        found = read_wav(path)
        assert "cut short" in found.notes[0]
        path.write_bytes(good)
        whole = read_wav(path)
        assert not whole.notes
        assert np.array_equal(found.column("2"), whole.column("2")[: len(found.column("2"))])

    def test_damage(self, tmp_path: Path) -> None:
        path = tmp_path / "a.wav"
        recorded(write_wav, path)
        good = path.read_bytes()

        def wrong(contents: bytes, words: str) -> None:
            path.write_bytes(contents)
            with pytest.raises(UnreadableFile, match=words):
                read_wav(path)

        wrong(b"RIFX" + good[4:], "no WAV file")
        wrong(good[:12], "no format chunk")
        wrong(good[:20] + struct.pack("<H", 2) + good[22:], "coding 2 with 16 bits")
        wrong(good[:22] + struct.pack("<H", 0) + good[24:], "0 channels")
        wrong(good[:24] + struct.pack("<I", 0) + good[28:], "at 0 Hz")
        wrong(good[:48], "0 bytes of samples")
        not_a_number = struct.pack("<f", float("nan"))
        recorded(write_wav, path, bits=32, code=3)
        wrong(path.read_bytes()[:-4] + not_a_number, "no finite numbers")


class TestUff:
    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"func_type": 4}, "no data set 58"),
            ({"rsp_node": 3, "rsp_dir": 3}, "3 time responses of 3\\+Z"),
        ],
    )
    def test_sets_that_are_no_recording(self, tmp_path: Path, changes: dict[str, Any], words: str) -> None:
        path = tmp_path / "a.uff"
        used = replace(write_uff(path, drum_block(), **changes), key_phasor="3+Z")
        with pytest.raises(UnreadableFile, match=words):
            read_recording(path, used)

    def test_a_file_cut_short(self, tmp_path: Path) -> None:
        path = tmp_path / "a.uff"
        used = recorded(write_uff, path, binary=0)
        text = path.read_text().splitlines(keepends=True)
        path.write_text("".join(text[:500] + text[520:]))
        with pytest.raises(UnreadableFile, match="are announced"):
            read_recording(path, used)
