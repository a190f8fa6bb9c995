"""Logs: read back as written; errors with file, line and reason; the rest only if asked; any bytes, only `LogError`."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import timedelta
from itertools import pairwise
from pathlib import Path

import can
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.can.logs.can_log import read_can_log
from drivers.can.mapping_file import standard_mapping
from drivers.clock import ManualClock
from drivers.errors import InvalidSetting, LogError
from drivers.files.readings import Recorder, read_recording
from drivers.files.replay import ReplayDriver, open_log, read_session_log
from drivers.reading_json import reading_to_dict
from tests.support.drivers.frames import START, readings, sensor_frames

MAPPING = standard_mapping(("P",))
TEXT = (".log", ".csv", ".trc", ".asc")
SUFFIXES = (*TEXT, ".blf")
COUNT = 40


def write_log(path: Path) -> Path:
    """One frame of speed and COUNT readings of sensor P, 10 ms apart."""
    with can.Logger(path) as log:
        for index, frame in enumerate(sensor_frames(COUNT)):
            frame.timestamp = START.timestamp() + 0.01 * index
            log.on_message_received(frame)
    return path


def numbers(path: Path, errors: list[LogError] | None = None) -> list[int]:
    on_error = None if errors is None else errors.append
    return [round(one.amplitude * 1000) for one in open_log(path, MAPPING, on_error)]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_log_gives_back_what_was_written(tmp_path: Path, suffix: str) -> None:
    path = write_log(tmp_path / f"bus{suffix}")
    found = list(open_log(path, MAPPING))
    assert [round(one.amplitude * 1000) for one in found] == list(range(1, COUNT + 1))
    assert [one.sequence - found[0].sequence for one in found] == list(range(COUNT))
    assert all(one.speed_rpm == pytest.approx(460.0) for one in found)
    steps = [(b.taken_at - a.taken_at).total_seconds() for a, b in pairwise(found)]
    assert steps == pytest.approx([0.01] * (COUNT - 1), abs=0.0011)
    if suffix != ".asc":  # which keeps no milliseconds of its start, and reads it in local time
        assert abs(found[0].taken_at - START - timedelta(seconds=0.01)) < timedelta(milliseconds=2)


@pytest.mark.parametrize("suffix", TEXT)
def test_a_wrong_line_is_told_with_its_number_and_the_rest_is_used_if_asked(tmp_path: Path, suffix: str) -> None:
    path = write_log(tmp_path / f"bus{suffix}")
    lines = path.read_text().splitlines()
    first = next(index for index, line in enumerate(lines) if "321" in line)
    wrong = (first + 3, first + 20)
    for index in wrong:
        lines[index] = {".asc": "  0.5 1 zzz Rx d 8 00", ".trc": "  4 30.0 DT 1 zz Rx - 8 00 00"}.get(
            suffix, "garbage, here"
        )
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(LogError, match=rf"bus\{suffix}, line {wrong[0] + 1}: ") as told:
        numbers(path)
    assert told.value.line == wrong[0] + 1
    errors: list[LogError] = []
    kept = numbers(path, errors)
    assert [error.line for error in errors] == [index + 1 for index in wrong]
    assert kept == [one for one in range(1, COUNT + 1) if one not in (4, 21)]


@pytest.mark.parametrize(
    ("suffix", "line", "words"),
    [
        (".csv", "0.1,2.0,3.0,4.0", r"line 2: it has too few parts: "),
        (".csv", "2e9,zz,0,0,0,8,AAAA", "'zz' is no hexadecimal number: .*; correct the file"),
        (".csv", "x,0x1,0,0,0,8,AAAA", "'x' is no time"),
        (".csv", "2e9,0x1,0,0,0,8,A", "its data 'A' are no base64"),
        (".csv", "2e9,0x1,0,0,0,8,AAAA", "it has 3 bytes of data where 8 are announced"),
        (".csv", "2e9,0xfffffffff,0,0,0,8,AAAA", "identifier '0xfffffffff' is too great"),
        (".asc", "0.5 1 zzz Rx d 8 00", "'zzz' is no hexadecimal number, nor a message of the mapping's DBC"),
        (".asc", "0.5 1 123 Rx d 8 00", "it has 1 bytes of data where 8 are announced"),
        (".asc", "0,5 1 123 Rx d 1 00", "time '0,5' has a decimal comma"),
        (".log", "(1.0) can0", "it is no line of candump"),
        (".log", "can0 123#00", "its lines have no time: record with `candump -l`"),
        (".log", "(2000000000.0) can0 123#0g", "its data '0g' are no hexadecimal digits"),
        (".log", "(2000000000.0) can0 123#112233445566778899", "it has 9 bytes of data; 8 are the most"),
    ],
)
def test_what_is_wrong_in_a_line_is_said_in_words(tmp_path: Path, suffix: str, line: str, words: str) -> None:
    path = tmp_path / f"bus{suffix}"
    head = {".csv": "timestamp,arbitration_id,extended,remote,error,dlc,data\n", ".asc": "date 2026-05-04 08:30:00\n"}
    path.write_text(head.get(suffix, "") + line + "\n")
    with pytest.raises(LogError, match=words):
        numbers(path)


def test_a_table_that_is_no_can_log_is_told_what_else_it_may_be(tmp_path: Path) -> None:
    path = tmp_path / "wave.csv"
    path.write_text("t,kp,P,Q\n0.1,2.0,3.0,4.0\n")
    with pytest.raises(LogError, match=r"line 1: .*names no columns of a CAN log; .*with its layout \(--layout\)"):
        numbers(path)


def test_a_damaged_blf_is_told_and_what_lies_before_is_used_if_asked(tmp_path: Path) -> None:
    path = write_log(tmp_path / "bus.blf")
    whole = path.read_bytes()
    for damaged, words in ((whole[:-100], "cut short|damaged"), (b"LOGX" + whole[4:], "damaged"), (b"", "damaged")):
        path.write_bytes(damaged)
        with pytest.raises(LogError, match=words):
            numbers(path)
        errors: list[LogError] = []
        if damaged[:4] != whole[:4]:
            with pytest.raises(LogError, match=words):
                numbers(path, errors)
            continue
        kept = numbers(path, errors)
        assert kept == list(range(1, len(kept) + 1))
        assert len(errors) == 1


def test_a_recording_survives_the_round_trip_bit_by_bit(tmp_path: Path) -> None:
    path = tmp_path / "shed.jsonl"
    some = [replace(one, phase_deg=None if one.sequence % 3 else 12.25, scatter=0.1) for one in readings(20)]
    with Recorder(path) as recorder:
        recorder.write(some[:5])
        recorder.write(some[5:])
    assert recorder.written == 20
    assert list(read_recording(path)) == some
    with pytest.raises(LogError, match=r"it is there already; name a new file: a recording never replaces one$"):
        Recorder(path)


WRONG_LINES = [
    ("{", "it is no JSON"),
    ("[1]", "is no JSON object"),
    ('{"source": "a"}', "sequence is not stated"),
    ({"amplitude": -1.0}, "amplitude is -1.0, it must be 0 or more"),
    ({"amplitude": "3"}, "amplitude is '3', which is no float"),
    ({"amplitude": True}, "amplitude is True, which is no float"),
    ({"amplitude": 10**400}, "which is not finite"),
    ({"phase_deg": 400.0}, "it must be 360 or less"),
    ({"speed_rpm": 0}, "speed_rpm is 0.0, it must be above 0"),
    ({"taken_at": "2026-07-01T12:00:00"}, "which is no time with a zone"),
    ({"taken_at": 5}, "which is no time with a zone"),
    ({"sequence": 1.5}, "sequence is 1.5, which is no int"),
    ({"sensor": ""}, "sensor is '', it must have 1 to 100 characters"),
    ({"weight": 1}, "field 'weight' is unknown"),
]


@pytest.mark.parametrize(("wrong", "words"), WRONG_LINES, ids=[str(words) for _, words in WRONG_LINES])
def test_a_wrong_line_of_a_recording(tmp_path: Path, wrong: str | dict[str, object], words: str) -> None:
    path = tmp_path / "shed.jsonl"
    good = [json.dumps(reading_to_dict(one)) for one in readings(3)]
    line = wrong if isinstance(wrong, str) else json.dumps(reading_to_dict(readings(1)[0]) | wrong)
    path.write_text("\n".join([good[0], "", line, *good[1:]]) + "\n")
    with pytest.raises(LogError, match=r"shed.jsonl, line 3: ") as told:
        list(read_recording(path))
    assert words in told.value.reason
    errors: list[LogError] = []
    assert len(list(read_recording(path, errors.append))) == 3
    assert [error.line for error in errors] == [3]


def test_files_that_are_no_logs(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"a":\n 1,,}')
    with pytest.raises(LogError, match=r"a.json, line 2: it is no JSON"):
        list(read_session_log(tmp_path / "a.json"))
    (tmp_path / "b.json").write_text("[]")
    with pytest.raises(LogError, match="no session log"):
        list(open_log(tmp_path / "b.json"))
    for name in ("gone.jsonl", "gone.json", "gone.log", "gone.blf", "gone.xyz"):
        with pytest.raises(LogError, match=name):
            list(open_log(tmp_path / name, MAPPING))
    with pytest.raises(LogError, match=r"gone.jsonl: it cannot be read .*; check its name"):
        list(open_log(tmp_path / "gone.jsonl"))
    with pytest.raises(LogError, match=r"'.xyz' is no suffix of a log that can be read; give one of .jsonl, "):
        open_log(tmp_path / "gone.xyz")
    with pytest.raises(InvalidSetting, match="name the mapping"):
        open_log(tmp_path / "gone.log")


def test_a_recording_goes_into_a_folder_that_is_there(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"cannot be written \(No such file or directory\); name a file in a folder"):
        Recorder(tmp_path / "nowhere" / "b.jsonl")


def test_a_wrong_run_of_a_session_log_is_named(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    runs = [{"readings": [{"sensor": "P", "amplitude": 1.0}]}, {"readings": [{"sensor": "P"}]}, {"readings": 3}, 7]
    path.write_text(json.dumps({"runs": runs}))
    with pytest.raises(LogError, match=r"runs\[1\]\.readings\[0\]: amplitude is not stated"):
        list(read_session_log(path))
    errors: list[LogError] = []
    assert len(list(read_session_log(path, errors.append))) == 1
    assert len(errors) == 3


class TestReplay:
    def recording(self, folder: Path) -> Path:
        path = folder / "shed.jsonl"
        with Recorder(path) as recorder:
            recorder.write(readings(30))
        return path

    def test_speed_is_kept(self, tmp_path: Path) -> None:
        clock = ManualClock()
        begun = clock.now()
        with ReplayDriver(self.recording(tmp_path), clock=clock, speed=0.5) as replay:
            assert list(replay) == readings(30)
        assert (clock.now() - begun).total_seconds() == pytest.approx(0.029 / 0.5, abs=1e-5)

    def test_it_goes_on_after_what_is_kept_already(self, tmp_path: Path) -> None:
        with ReplayDriver(self.recording(tmp_path), clock=ManualClock(), after=12) as replay:
            assert [one.sequence for one in replay] == list(range(13, 31))

    def test_source_and_times_can_be_stated_anew(self, tmp_path: Path) -> None:
        day = timedelta(days=1)
        with ReplayDriver(self.recording(tmp_path), clock=ManualClock(), source="again", shift=day) as replay:
            assert list(replay) == [replace(one, source="again", taken_at=one.taken_at + day) for one in readings(30)]

    def test_two_sources_in_one_file_need_one_name(self, tmp_path: Path) -> None:
        path = tmp_path / "two.jsonl"
        with Recorder(path) as recorder:
            recorder.write([*readings(2), *readings(2, source="other", first=3)])
        with ReplayDriver(path, clock=ManualClock()) as replay, pytest.raises(LogError, match="'can' and 'other'"):
            list(replay)
        with ReplayDriver(path, clock=ManualClock(), source="one") as replay:
            assert len(list(replay)) == 4

    def test_numbers_that_go_back_are_told(self, tmp_path: Path) -> None:
        path = tmp_path / "back.jsonl"
        with Recorder(path) as recorder:
            recorder.write([*readings(3), *readings(1)])
        with (
            ReplayDriver(path, clock=ManualClock()) as replay,
            pytest.raises(LogError, match="gave sequence 1 after 3"),
        ):
            list(replay)

    def test_a_negative_speed_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(InvalidSetting):
            ReplayDriver(self.recording(tmp_path), clock=ManualClock(), speed=0.0)


@st.composite
def mutations(draw: st.DrawFn, whole: bytes) -> bytes:
    """The file with some bytes changed, cut out or put in."""
    data = bytearray(whole)
    for _ in range(draw(st.integers(1, 6))):
        place = draw(st.integers(0, len(data)))
        kind = draw(st.sampled_from(["change", "cut", "put", "line"]))
        if kind == "cut":
            del data[place : place + draw(st.integers(1, 200))]
        elif kind == "put":
            data[place:place] = draw(st.binary(min_size=1, max_size=30))
        elif kind == "line":
            data[place:place] = draw(st.text(max_size=20)).encode("utf-8", "replace") + b"\n"
        elif place < len(data):
            data[place] = draw(st.integers(0, 255))
    return bytes(data)


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".jsonl", ".json"])
@given(data=st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_any_bytes_are_readings_or_a_log_error(tmp_path: Path, suffix: str, data: st.DataObject) -> None:
    original = tmp_path / f"whole{suffix}"
    if not original.exists():
        if suffix == ".jsonl":
            with Recorder(original) as recorder:
                recorder.write(readings(COUNT))
        elif suffix == ".json":
            stated = [{"sensor": "P", "amplitude": 1.0, "phase_deg": 20.0}]
            original.write_text(
                json.dumps({"runs": [{"readings": stated, "taken_at": START.isoformat()}] * 5}, indent=1)
            )
        else:
            write_log(original)
    path = tmp_path / f"bytes{suffix}"
    path.write_bytes(data.draw(mutations(original.read_bytes()) | st.binary(max_size=300)))
    found: list[int] = []
    try:
        for one in open_log(path, MAPPING):
            found.append(round(one.amplitude * 1000))
    except LogError as error:
        assert error.file == path  # noqa: PT017
    errors: list[LogError] = []
    try:
        rest = [round(one.amplitude * 1000) for one in open_log(path, MAPPING, errors.append)]
    except LogError:
        return
    assert rest[: len(found)] == found


def test_reading_frames_of_an_unknown_kind_of_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no suffix of a log"):
        list(read_can_log(tmp_path / "a.db"))
