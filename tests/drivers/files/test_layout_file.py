"""The layout file of a waveform: read as it says, and wrong ones refused with the line."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from drivers.errors import InvalidSetting
from drivers.files.layout_file import read_layout

LAYOUT = """key_phasor = "kp"
time = "t"
started_at = 2026-05-04T10:30:00+02:00
block_s = 2
threshold = 0.5
nominal_rpm = 460
band_hz = [10, 1000]

[[channel]]
column = "P"
sensor = "left"
raw_unit = "g"
full_scale = 5

[[channel]]
column = "Q"
sensor = "right"
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "drum.toml"
    path.write_text(text)
    return path


def test_it_is_read_as_it_says(tmp_path: Path) -> None:
    found = read_layout(written(tmp_path, LAYOUT))
    assert found.block_s == 2.0
    assert found.layout.started_at == datetime(2026, 5, 4, 8, 30, tzinfo=UTC)
    assert (found.layout.time, found.layout.key_phasor, found.layout.threshold) == ("t", "kp", 0.5)
    assert [(column, one.sensor, one.raw_unit, one.full_scale) for column, one in found.layout.channels] == [
        ("P", "left", "g", 5),
        ("Q", "right", "m/s2", None),
    ]
    assert (found.settings.nominal_rpm, found.settings.band_hz) == (460, (10.0, 1000.0))


def test_the_time_that_is_stated_with_the_file_comes_first(tmp_path: Path) -> None:
    moment = datetime(2026, 6, 1, tzinfo=UTC)
    path = written(tmp_path, LAYOUT)
    assert read_layout(path, moment).layout.started_at == moment
    path.write_text(LAYOUT.replace("started_at = 2026-05-04T10:30:00+02:00\n", ""))
    assert read_layout(path, moment).layout.started_at == moment


WRONG = [
    ('key_phasor = "kp"', "", None, "has no key_phasor"),
    ('time = "t"', 'tiem = "t"', 2, "unknown key 'tiem': use .*time"),
    ('time = "t"', 'time = "t"\nsample_rate_hz = 640', None, "sample_rate_hz 640 beside the column of time 't'"),
    ("started_at = 2026-05-04T10:30:00+02:00", "", None, "state started_at"),
    ("+02:00", "", 3, "state its zone"),
    ("block_s = 2", 'block_s = "2"', 4, "has block_s '2', which is of the wrong kind"),
    ("block_s = 2", "block_s = true", 4, "wrong kind"),
    ("[10, 1000]", "[10]", 7, "state two frequencies"),
    ("[10, 1000]", "[1000, 10]", None, "band_hz .*the lower first"),
    ('raw_unit = "g"', 'raw_unit = "stone"', 9, "raw_unit 'stone' of acceleration .*be one of m/s2, g"),
    ('sensor = "right"', "", 15, "has no sensor"),
    ('sensor = "right"', 'sensor = "left"', None, "left"),
    ("full_scale = 5", "full_scale = 0", 9, "full_scale 0 .*be > 0"),
    ("nominal_rpm = 460", "nominal_rpm = ", None, "is no TOML .*line 6"),
]


@pytest.mark.parametrize(("was", "now", "line", "words"), WRONG, ids=[one[1] or one[0] for one in WRONG])
def test_a_wrong_layout_is_refused_with_its_line(
    tmp_path: Path, was: str, now: str, line: int | None, words: str
) -> None:
    path = written(tmp_path, LAYOUT.replace(was, now, 1))
    with pytest.raises(InvalidSetting, match=words) as refused:
        read_layout(path)
    assert str(path) in str(refused.value)
    assert line is None or f", line {line}: " in str(refused.value)


def test_a_layout_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InvalidSetting, match="cannot be read"):
        read_layout(tmp_path / "gone.toml")
