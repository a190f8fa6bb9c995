"""`drumtrue layout`: what is written for a file reads the file, and the numbers are those that were written."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.errors import InvalidSetting, UnreadableFile
from drivers.files.driver import read_recording
from drivers.files.layout_draft import described, draft
from drivers.files.layout_file import read_layout
from drivers.files.survey import Survey, survey
from tests.support.drivers.text_forms import ROWS, START, Form, text_of, written
from tests.support.drivers.waveform_files import RATE, drum_block, write_csv, write_uff, write_wav

NOW = datetime(2026, 5, 4, 8, 30, tzinfo=UTC)


def drafted(path: Path, found: Survey, change: tuple[str, str] = ("", "")) -> Path:
    file = path.with_suffix(".toml")
    file.write_text(draft(found, path).replace(*change), encoding="utf-8")
    return file


@given(written(), st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_layout_of_a_text_of_any_form_reads_it(tmp_path: Path, form: Form, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pulses = np.where(np.arange(ROWS) % 17 < 4, 5.0, 0.0)
    values = np.stack([pulses, rng.normal(size=ROWS)], axis=1).round(5)
    path = tmp_path / "a.csv"
    path.write_bytes(text_of(form, values).encode(form.encoding))
    found = survey(path)
    assert found.key_phasor == "kp"
    stated = "sample_rate_hz = 0.0" if "Sample rate,2560" not in form.head else "sample_rate_hz = 2560"
    file = drafted(path, found, (stated, f"sample_rate_hz = {form.rate}"))
    if form.time in ("epoch", "iso") and form.encoding != "utf-16-le":
        assert abs((found.recording.began or NOW) - START).total_seconds() < 1e-3
        file.write_text(draft(found, path))
    layout = read_layout(file, NOW).layout
    assert layout.key_phasor == "kp"
    read = read_recording(path, layout)
    name = next(column for column, _ in layout.channels if column.startswith("P"))
    assert read.column("kp") == pytest.approx(values[:, 0], abs=1e-5)
    assert read.column(name) == pytest.approx(values[:, 1], abs=1e-8)
    if form.separator != " " or form.time not in ("ms", "us"):
        assert read.sample_rate_hz == pytest.approx(form.rate, rel=0.02 if form.time == "rounded" else 2e-3)


@pytest.mark.parametrize("write", [write_csv, write_wav, write_uff])
def test_every_kind_is_described_and_drafted(tmp_path: Path, write: object) -> None:
    suffix = {write_csv: ".csv", write_wav: ".wav", write_uff: ".uff"}[write]  # type: ignore[index]
    path = tmp_path / f"a{suffix}"
    used = write(path, drum_block())  # type: ignore[operator]
    found = survey(path)
    assert found.key_phasor == used.key_phasor
    assert f"at {RATE:.6g} Hz" in described(found, path)[0]
    layout = read_layout(drafted(path, found, ("full_scale = 0.0", "full_scale = 5.0")), NOW).layout
    assert [column for column, _ in layout.channels] == [column for column, _ in used.channels]
    assert read_recording(path, layout).sample_rate_hz == pytest.approx(RATE, rel=1e-4)


def test_what_nothing_tells_must_be_stated_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    write_wav(path, drum_block())
    file = drafted(path, survey(path))
    with pytest.raises(InvalidSetting, match=r"full_scale 0.0 must be > 0"):
        read_layout(file, NOW)
    with pytest.raises(InvalidSetting, match="does not say when the recording was started"):
        read_layout(drafted(path, survey(path), ("full_scale = 0.0", "full_scale = 5.0")))
    still = tmp_path / "b.csv"
    still.write_text("t,P\n" + "".join(f"{row / 100},{row * row % 7}.5\n" for row in range(60)))
    with pytest.raises(InvalidSetting, match="has no key_phasor"):
        read_layout(drafted(still, survey(still)), NOW)


HEADER = "Logger 4\nStart time: 2026-05-04 08:30:00\nSampling rate: 2.56 kHz\n\n"


def test_rate_and_start_are_taken_from_a_header(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    rows = "".join(f"{5 * (row % 40 < 9)}\t{row % 13}\n" for row in range(300))
    path.write_text(HEADER + "tacho\tacc [g]\n" + rows)
    found = survey(path)
    assert (found.rate_stated, found.recording.began, found.key_phasor) == (2560.0, NOW, "tacho")
    text = draft(found, path)
    assert "started_at = 2026-05-04T08:30:00Z" in text
    assert 'raw_unit = "g"\n' in text
    path.write_text("# 2.5 Hz\n# tacho acc\n" + rows.replace("\t", " "))  # as numpy.savetxt writes names
    assert read_recording(path, read_layout(_renamed(path), NOW).layout).column("acc")[:3].tolist() == [0.0, 1.0, 2.0]


def _renamed(path: Path) -> Path:
    file = path.with_suffix(".toml")
    file.write_text('key_phasor = "tacho"\nsample_rate_hz = 100.0\n[[channel]]\ncolumn = "acc"\nsensor = "P"\n')
    return file


@pytest.mark.parametrize("contents", [b"", b"x", b"hello\nthere\n" * 50, b"\xff\xfe\x00", bytes(range(256)) * 9])
def test_what_holds_no_table_is_refused(tmp_path: Path, contents: bytes) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(contents)
    with pytest.raises(UnreadableFile):
        survey(path)
