"""The mapping file: checked at start, and wrong ones refused with the line."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivers.can.mapping_file import parse_mapping, read_mapping, standard_mapping, standard_mapping_text
from drivers.errors import InvalidSetting
from tests.support.drivers.frames import STRANGER_TOML, stranger


def test_the_standard_mapping_names_standard_and_extended_identifiers() -> None:
    for j1939, speed in ((False, 0x310), (True, 0x18FF1080)):
        mapping = standard_mapping(("P", "Q"), ("1",), j1939=j1939)
        by_name = {message.name.removeprefix("J1939"): message for message in mapping.messages()}
        assert set(by_name) == {"Status", "Heartbeat", "Speed", "Sensor1", "Sensor2", "Correction1"}
        assert by_name["Speed"].frame_id == speed
        assert {message.is_extended_frame for message in by_name.values()} == {j1939}
        assert {message.length for message in by_name.values()} == {8}


def test_names_with_quotes_survive() -> None:
    mapping = standard_mapping(('left "upper"', "a\\b"))
    assert [sensor.name for sensor in mapping.sensors] == ['left "upper"', "a\\b"]


WRONG = [
    ('signal = "Rev"', 'signal = "Rpm"', 7, "names signal 'Rpm', which message Rot has not: use one of Rev"),
    ('message = "Rot"', 'message = "Rota"', 6, "names message 'Rota', which the DBC has not: use one of Ang, Rot, Vib"),
    ('signal = "Rev"', 'signal = "Rev"\nunit = "rpm"', 8, "states rpm, the DBC says Hz"),
    ('signal = "Rev"', 'signal = "Rev"\nunits = "Hz"', 8, "unknown key 'units'"),
    ('unit = "mm/s"', 'unit = "g"', 12, "is in in/s, the sensor in g: these are different quantities"),
    ('unit = "mm/s"', 'unit = "furlong"', 11, "has unit 'furlong': use one of"),
    ('detection = "peak"', 'detection = "top"', 12, "has detection 'top': use one of rms, peak, peak_to_peak"),
    ('sense = "lead"', 'sense = "left"', 13, "has sense 'left': use one of lag, lead"),
    ('valid = "Ok"', 'valid = "Okay"', 12, "names signal 'Okay'"),
    ('counter = "Seq"', 'counter = "Nr"', 2, "names 'Nr', which is in no mapped message"),
    ("node = 0x21", "node = 300", 3, "a J1939 source address is 0 to 253"),
    ('name = "left"', 'name = ""', 10, "has name '': state a text"),
    ('dbc = "stranger.dbc"', 'dbc = "gone.dbc"', 1, "which is no DBC that can be read"),
    ("[speed]", "[sped]", 5, "unknown key 'sped'"),
    ('name = "left"', "name = 3 4", None, r"is no TOML .*line 10"),
    ("[[sensor]]", "[sensor]", 9, r"write \[\[sensor\]\]"),
]


@pytest.mark.parametrize(("was", "now", "line", "words"), WRONG, ids=[str(one[1]) for one in WRONG])
def test_a_wrong_mapping_is_refused_with_its_line(
    tmp_path: Path, was: str, now: str, line: int | None, words: str
) -> None:
    assert was in STRANGER_TOML
    path = stranger(tmp_path, STRANGER_TOML.replace(was, now, 1))
    with pytest.raises(InvalidSetting, match=words) as refused:
        read_mapping(path)
    assert str(path) in str(refused.value)
    if line is not None:
        assert f"mapping.toml, line {line}:" in str(refused.value)


def test_a_mapping_without_sensors_or_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidSetting, match=r"no .*sensor"):
        parse_mapping('counter = "Counter"')
    with pytest.raises(InvalidSetting, match="cannot be read"):
        read_mapping(tmp_path / "none.toml")


def test_a_broken_dbc_is_refused(tmp_path: Path) -> None:
    path = stranger(tmp_path)
    (tmp_path / "stranger.dbc").write_bytes(b"\xff\xfe BO_ nothing")
    with pytest.raises(InvalidSetting, match=r"line 1: dbc names .* no DBC that can be read"):
        read_mapping(path)


def test_a_sensor_mapped_twice_is_refused() -> None:
    text = standard_mapping_text(("P", "Q")).replace('name = "Q"', 'name = "P"')
    with pytest.raises(InvalidSetting, match=r"line 22: \[sensor\] name maps 'P' twice"):
        parse_mapping(text)
