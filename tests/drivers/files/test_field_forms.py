"""WAV, universal and LabVIEW files as recorders leave them."""

from __future__ import annotations

import struct
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.errors import UnreadableFile
from drivers.files.driver import WaveformFile, read_recording
from drivers.files.labview_file import read_lvm, read_tdms
from drivers.files.uff_file import read_uff
from drivers.files.wav_file import read_wav
from drivers.signal.edges import find_edges
from drivers.signal.revolutions import one_a_turn
from tests.support.drivers.analytic import apart
from tests.support.drivers.waveform_files import RATE, drum_block, layout, recorded, tacho, write_csv, write_uff

SAMPLES = np.arange(300, dtype="<i2").reshape(100, 3)
shapes = settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def wav(
    *, magic: bytes = b"RIFF", before: bytes = b"", size: int | None = None, behind: bytes = b"", large: bool = False
) -> bytes:
    data = SAMPLES.tobytes()
    form = struct.pack("<HHIIHH", 1, 3, 640, 640 * 6, 6, 16)
    ds64 = b"ds64" + struct.pack("<IQQQI", 28, 0, len(data), 100, 0) if large else b""
    chunks = ds64 + b"fmt " + struct.pack("<I", 16) + form + before
    chunks += b"data" + struct.pack("<I", len(data) if size is None else size) + data + behind
    return magic + struct.pack("<I", 4 + len(chunks)) + b"WAVE" + chunks


@given(
    st.sampled_from([None, 0xFFFFFFFF, 0, 10**6]),
    st.sampled_from([b"", b"\0", b"ID3\x04junkjunk", b"LIST\x04\0\0\0abcd"]),
    st.sampled_from([b"", b"bext\x05\0\0\0hello", b"bext\x05\0\0\0hello\0", b"LIST\x04\0\0\0abcd"]),
)
@shapes
def test_the_samples_that_are_there_are_read(tmp_path: Path, size: int | None, behind: bytes, before: bytes) -> None:
    path = tmp_path / "a.wav"
    path.write_bytes(wav(size=size, behind=behind, before=before))
    found = read_wav(path)
    for place in range(3):
        assert np.array_equal(found.column(str(place + 1))[:100] * 32768.0, SAMPLES[:, place])
    assert bool(found.notes) == (size is not None)
    assert size is not None or len(found.column("1")) == 100


def test_rf64(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    path.write_bytes(wav(magic=b"RF64", size=0xFFFFFFFF, behind=b"LIST\x04\0\0\0abcd", large=True))
    found = read_wav(path)
    assert (len(found.column("1")), found.notes) == (100, ())


@given(st.integers(45, 700))
@shapes
def test_a_wav_cut_anywhere_gives_whole_moments(tmp_path: Path, length: int) -> None:
    path = tmp_path / "a.wav"
    path.write_bytes(wav()[:length])
    try:
        found = read_wav(path)
    except UnreadableFile:
        assert length < 44 + 12
        return
    count = min((length - 44) // 6, 100)
    assert np.array_equal(found.column("3") * 32768.0, SAMPLES[:count, 2])


# ---------------------------------------------------------------- universal files
def uff(path: Path, names: list[tuple[int, int, str, int]]) -> None:
    """Sets of node, direction, text, and times the rate; the number of a set is its first sample."""
    import pyuff

    sets = []
    for number, (node, direction, text, faster) in enumerate(names, start=1):
        data = np.arange(50.0 * faster) + number
        sets.append(
            pyuff.prepare_58(
                binary=0, func_type=1, rsp_node=node, rsp_dir=direction, ref_node=0, ref_dir=0, id1=text,
                data=data, x=np.arange(len(data)) / (RATE * faster), abscissa_spacing=1, abscissa_spec_data_type=17,
                ordinate_spec_data_type=12, orddenom_spec_data_type=0, ordinate_axis_units_lab="m/s^2",
            )
        )  # fmt: skip
    pyuff.UFF(str(path)).write_sets(sets, mode="add")


FOUR = [(0, 0, "Tacho", 4), (0, 0, "Acc P", 1), (7, 3, "x", 1), (7, 3, "x", 1)]


@pytest.mark.filterwarnings("ignore::ResourceWarning")
class TestUniversal:
    def test_a_column_is_named_by_text_number_or_node(self, tmp_path: Path) -> None:
        uff(tmp_path / "a.uff", FOUR)
        found = read_uff(tmp_path / "a.uff", ["Tacho", "Acc P", "#3", "#4"])
        assert [found.column(name)[0] for name in ("Tacho", "Acc P", "#3", "#4")] == [1.0, 2.0, 3.0, 4.0]
        assert (found.rate_of("Acc P"), found.rate_of("Tacho")) == pytest.approx((RATE, 4 * RATE), rel=1e-4)

    @pytest.mark.parametrize("name", ["7+Z", "x", "0", "gone", "#9"])
    def test_a_name_of_several_or_none_is_refused_with_the_others(self, tmp_path: Path, name: str) -> None:
        uff(tmp_path / "a.uff", FOUR)
        with pytest.raises(UnreadableFile, match=r"name one by its? ?number|name one by number"):
            read_uff(tmp_path / "a.uff", ["Tacho", name])

    def test_sets_that_nothing_names_may_be_anything(self, tmp_path: Path) -> None:
        path = tmp_path / "a.uff"
        used = write_uff(path, drum_block(), binary=0)
        text = path.read_text()
        first = text[: text.index("    -1", 10) + 7]
        path.write_text(text + first + first.replace("m/s^2", "furlong"))
        with pytest.raises(UnreadableFile, match=r"3 time responses of 1\+Z"):
            read_recording(path, used)
        other = replace(used, channels=used.channels[1:])
        assert list(read_recording(path, other).columns) == ["9", "2+Z"]


# ---------------------------------------------------------------- LabVIEW
def lvm(path: Path, *, x_columns: str, point: str = ".", separator: str = "Tab") -> None:
    mark = {"Tab": "\t", "Comma": ","}[separator]
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", f"Separator\t{separator}", f"Decimal_Separator\t{point}"]
    head += [f"X_Columns\t{x_columns}", "Date\t2026/05/04", "***End_of_Header***\t", "\t", "Channels\t2\t\t"]
    head += [
        "Samples\t100\t100\t",
        f"Delta_X\t{0.0015625:.7f}\t0.0015625\t".replace(".", point),
        "***End_of_Header***\t\t\t",
    ]
    names = ["X_Value", "kp", "P", "Comment"]
    rows = [mark.join(names)]
    for row in range(100):
        x = f"{row * 0.0015625:.7f}" if x_columns == "One" else ""
        rows.append(mark.join([x, f"{row % 7:.6f}", f"{row / 8:.6f}", ""]).replace(".", point))
    text = "\n".join([*head, *rows, ""])
    path.write_text(text if mark == "\t" else text.replace("\t", mark))


@pytest.mark.parametrize(
    ("x_columns", "point", "separator"),
    [("One", ".", "Tab"), ("No", ".", "Tab"), ("One", ",", "Tab"), ("No", ".", "Comma")],
)
def test_a_labview_measurement(tmp_path: Path, x_columns: str, point: str, separator: str) -> None:
    lvm(tmp_path / "a.lvm", x_columns=x_columns, point=point, separator=separator)
    found = read_lvm(tmp_path / "a.lvm", ["kp", "P"])
    assert found.sample_rate_hz == pytest.approx(640.0)
    assert found.column("P").tolist() == pytest.approx([row / 8 for row in range(100)])


def test_a_tdms_file_needs_its_package_or_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.tdms"
    path.write_bytes(b"TDSm")
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(UnreadableFile, match=r"pip install 'drumtrue\[tdms\]'"):
        read_tdms(path)

    class Channel(list[float]):
        def __init__(self, name: str, properties: dict[str, object]) -> None:
            super().__init__([1.0, 2.0, 3.0])
            self.name, self.group_name, self.properties = name, "G", properties

    channels = [Channel("P", {"wf_increment": 0.001, "unit_string": "g"}), Channel("text", {})]
    file = SimpleNamespace(groups=lambda: [SimpleNamespace(channels=lambda: channels)])
    stand_in = ModuleType("nptdms")
    stand_in.TdmsFile = SimpleNamespace(read=lambda _: file)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "nptdms", stand_in)
    found = read_tdms(path, ["P"])
    assert (found.sample_rate_hz, found.column("P").tolist(), found.stated) == (
        1000.0,
        [1.0, 2.0, 3.0],
        {"P": (None, "g")},
    )
    assert list(read_tdms(path).columns) == ["G/P"]
    with pytest.raises(UnreadableFile, match="has no column 'Q': its columns are G/P, G/text"):
        read_tdms(path, ["Q"])


# ---------------------------------------------------------------- several pulses a turn
@pytest.mark.parametrize("pulses", [2, 3, 4, 8])
def test_several_pulses_a_turn_are_seen_or_stated(tmp_path: Path, pulses: int) -> None:
    seconds, hz = 12.0, 460.0 / 60.0
    times = np.arange(int(2560 * seconds)) / 2560
    turned = hz * times * 2.0 * np.pi
    p = -3.0 * np.sqrt(2.0) * 1e-3 * 2.0 * np.pi * hz * np.sin(turned - np.radians(112.0))
    kp = 5.0 * ((pulses * hz * times) % 1.0 < 0.25)
    path = tmp_path / "a.csv"
    path.write_text(
        "kp,P\n"
        + "".join(
            f"{a},{b:.9g}\n"
            for a, b in zip(kp, p + np.random.default_rng(1).normal(scale=0.002, size=len(p)), strict=True)
        )
    )
    used = replace(layout(("P", "P", "kp"), sample_rate_hz=2560.0), channels=layout(("P", "P", "kp")).channels[:1])
    driver = WaveformFile(path, used, source="shed", block_s=6.0)
    with driver:
        assert list(driver) == []
    assert f"turns once in {pulses} pulses" in str(driver.first_refusal)
    with WaveformFile(path, replace(used, pulses_per_turn=pulses), source="shed", block_s=4.0) as stated:
        readings = list(stated)
    assert len(readings) == 3
    for one in readings:
        assert one.amplitude == pytest.approx(3.0, rel=0.005)
        assert apart(one.phase_deg or 0.0, 112.0) < 1.0
        assert one.speed_rpm == pytest.approx(460.0, rel=1e-3)


def test_missed_pulses_do_not_move_the_mark() -> None:
    edges = np.arange(200) * 0.1
    kept = np.delete(edges, [17, 50, 51, 120])
    assert one_a_turn(kept, 4) == pytest.approx([one for one in edges[::4] if one in kept])
    assert len(find_edges(tacho(drum_block()), RATE)) == len(drum_block().edges_s)


def test_a_column_of_another_rate_keeps_the_time(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    used = recorded(write_csv, path)
    recording = read_recording(path, used)
    fast = replace(
        recording,
        columns={**recording.columns, "kp": np.repeat(recording.column("kp"), 4)},
        rates_hz={"kp": 4 * RATE},
    )
    from drivers.files.recording import whole_block

    plain, other = whole_block(recording, used), whole_block(fast, used)
    assert other.edges_s == pytest.approx(plain.edges_s, abs=1.0 / RATE)
    assert other.sample_rate_hz == plain.sample_rate_hz
