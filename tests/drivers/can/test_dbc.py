"""DBCs in the alphabets they are written in, with messages that are broken and not read from."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivers.can.dbc import BrokenDatabase, check_messages, load_dbc

HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: X\n'
GOOD = 'BO_ 256 Good: 8 X\n SG_ Amp : 0|16@1+ (0.01,0) [0|642] "µm" X\nVAL_ 256 Amp 65535 "SNA";\n'
BROKEN = {
    "overlap": 'BO_ 700 Bad: 8 X\n SG_ A : 0|16@1+ (1,0) [0|0] "" X\n SG_ B : 8|16@1+ (1,0) [0|0] "" X\n',
    "too long": 'BO_ 700 Bad: 2 X\n SG_ A : 8|16@1+ (1,0) [0|0] "" X\n',
    "identifier": 'BO_ 5000 Bad: 8 X\n SG_ A : 0|16@1+ (1,0) [0|0] "" X\n',
    "names": 'VAL_ 700 Gone 1 "one";\nVAL_ 256 Gone 1 "one";\n',
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
@pytest.mark.parametrize("broken", [*BROKEN, ""])
def test_what_is_not_read_from_may_be_broken(tmp_path: Path, broken: str, encoding: str) -> None:
    path = tmp_path / "a.dbc"
    path.write_bytes((HEAD + BROKEN.get(broken, "") + GOOD).encode(encoding))
    database = load_dbc(path)
    good = database.get_message_by_name("Good")
    check_messages([good])
    signal = good.get_signal_by_name("Amp")
    assert signal.unit == "µm"
    assert signal.choices == {65535: "SNA"}


@pytest.mark.parametrize("broken", ["overlap", "too long"])
def test_a_broken_message_that_is_read_from_is_refused(tmp_path: Path, broken: str) -> None:
    path = tmp_path / "a.dbc"
    path.write_text(HEAD + BROKEN[broken] + GOOD)
    with pytest.raises(BrokenDatabase, match="message Bad is broken"):
        check_messages(load_dbc(path).messages)


@pytest.mark.parametrize("text", ["", "garbage", "BO_ x", HEAD + "BO_ 256 Good: 8 X\n SG_ >>"])
def test_what_is_no_dbc_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.dbc"
    path.write_text(text)
    try:
        assert not load_dbc(path).messages
    except BrokenDatabase:
        return
