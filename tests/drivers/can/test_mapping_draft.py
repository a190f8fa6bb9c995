"""`drumtrue mapping`: signals of a balancer's DBC are found by unit and name, and what is written can be read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.can.dbc import load_dbc
from drivers.can.mapping_draft import described, draft
from drivers.can.mapping_file import parse_mapping, standard_mapping

FIELD = Path(__file__).parent / "field"
drawn = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@dataclass(frozen=True)
class Style:
    """How a maker names and places the signals of two sensors."""

    level: str
    amplitude: str
    phase: str
    angle: str
    speed: tuple[str, str]
    counter: str
    together: bool
    extended: bool
    flags: bool
    little: bool


styles = st.builds(
    Style,
    level=st.sampled_from(["mm/s", "mm/s RMS", "µm", "in/s", "g", "m/s^2", "mils"]),
    amplitude=st.sampled_from(["Amp", "Amplitude", "Vibration", "Vib1x"]),
    phase=st.sampled_from(["Pha", "Phase", "Angle"]),
    angle=st.sampled_from(["deg", "°", "rad", "degrees"]),
    speed=st.sampled_from([("Rev", "rpm"), ("RotorSpeed", "1/min"), ("Drehzahl", "U/min"), ("Freq_rev", "Hz")]),
    counter=st.sampled_from(["Cnt", "Counter", "MsgCounter", "Alive", ""]),
    together=st.booleans(),
    extended=st.booleans(),
    flags=st.booleans(),
    little=st.booleans(),
)


def written(style: Style, folder: Path) -> Path:
    """The DBC: two sensors, in one message or two, the speed and something that is none of this."""

    def signal(name: str, place: int, length: int, unit: str, scale: str = "0.01") -> str:
        start = place if style.little else 8 * (place // 8) + 7
        return f' SG_ {name} : {start}|{length}@{int(style.little)}+ ({scale},0) [0|0] "{unit}" X'

    number = (1 << 31 | 0x18FF0021) if style.extended else 0x200
    lines = ['VERSION ""', "NS_ :", "BS_:", "BU_: Bal"]
    lines += [f"BO_ {number} Drive: 8 Bal", signal(style.speed[0], 0, 16, style.speed[1], "0.5")]
    lines += [signal("OilTemp", 16, 16, "degC"), signal("Battery", 32, 16, "V")]
    for sensor in (1, 2):
        end = f"_{'PQ'[sensor - 1]}" if style.together else ""
        if sensor == 1 or not style.together:
            lines.append(f"BO_ {number + 256 * sensor} Vib{sensor}: {16 if style.together else 8} Bal")
        at = 64 * (sensor - 1) if style.together else 0
        lines.append(signal(style.amplitude + end, at, 16, style.level))
        lines.append(signal(style.phase + end, at + 16, 16, style.angle, "0.1"))
        if style.flags:
            place = at + 32 + (0 if style.little else 7)
            name = f"{style.amplitude}{end}_Valid"
            lines.append(f' SG_ {name} : {place}|1@{int(style.little)}+ (1,0) [0|1] "" X')
        if style.counter and (sensor == 2 or not style.together):
            lines.append(signal(style.counter, at + 56, 8, "", "1"))
    path = folder / "acme.dbc"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


@given(styles)
@drawn
def test_sensors_speed_counter_and_flags_are_found(tmp_path: Path, style: Style) -> None:
    path = written(style, tmp_path)
    database = load_dbc(path)
    mapping = parse_mapping(draft(database, path), path)
    assert [one.amplitude.signal for one in mapping.sensors] == (
        [f"{style.amplitude}_P", f"{style.amplitude}_Q"] if style.together else [style.amplitude] * 2
    )
    assert [one.phase and one.phase.signal for one in mapping.sensors] == (
        [f"{style.phase}_P", f"{style.phase}_Q"] if style.together else [style.phase] * 2
    )
    assert mapping.speed is not None
    assert mapping.speed.signal == style.speed[0]
    assert mapping.counter == (style.counter or None)
    assert all((one.amplitude.valid is not None) == style.flags for one in mapping.sensors)
    assert any("OilTemp [degC]" in line for line in described(database))


@pytest.mark.parametrize("dbc", sorted(FIELD.glob("*.dbc")), ids=lambda path: path.stem)
def test_the_draft_of_a_field_dbc_maps_what_its_own_mapping_does(dbc: Path) -> None:
    own = parse_mapping(dbc.with_suffix(".toml").read_text(), dbc)
    mapping = parse_mapping(draft(load_dbc(dbc), dbc), dbc)
    assert [(one.amplitude.message, one.amplitude.signal) for one in mapping.sensors] == [
        (one.amplitude.message, one.amplitude.signal) for one in own.sensors
    ]
    assert (mapping.speed and mapping.speed.signal) == (own.speed and own.speed.signal)


def test_the_draft_of_our_own_dbc_has_its_sensors_and_flags() -> None:
    path = Path("drivers/balancer.dbc")
    mapping = parse_mapping(draft(load_dbc(path), path), path)
    assert mapping.sensors[0].overall == standard_mapping(("P",)).sensors[0].overall
    assert mapping.sensors[1].phase is not None
    assert (mapping.counter, mapping.heartbeat) == ("Counter", "Heartbeat")
    assert len(mapping.sensors) == 8


def test_a_dbc_without_vibration_says_what_to_fill_in(tmp_path: Path) -> None:
    path = tmp_path / "none.dbc"
    path.write_text('VERSION ""\nNS_ :\nBS_:\nBU_: X\nBO_ 5 M: 8 X\n SG_ Door : 0|2@1+ (1,0) [0|3] "" X\n')
    text = draft(load_dbc(path), path)
    assert "# No signal has a unit or a name of vibration" in text
    assert "# amplitude = " in text
