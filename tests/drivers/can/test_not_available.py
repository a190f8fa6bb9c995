"""Values that stand for none, and flags that vouch: what a frame says comes back, or no reading and its reason."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from drivers.can.decoder import FrameDecoder, Vector
from drivers.can.mapping import Validity
from drivers.can.mapping_file import read_mapping
from drivers.can.refusals import counted
from drivers.errors import InvalidSetting

DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ {ident} Vib: 8 X
 SG_ Amp : 0|{length}@1+ ({scale},0) [{low}|{high}] "mm/s" X
 SG_ Pha : 32|16@1+ (0.1,0) [0|0] "deg" X
 SG_ Flag : 56|4@1+ (1,0) [0|0] "" X
VAL_ {ident} Amp {table};
VAL_ {ident} Flag 0 "Off" 2 "Measuring" 3 "Hold";
"""
TOML = """dbc = "a.dbc"
{top}
[[sensor]]
name = "P"
amplitude = {{message = "Vib", signal = "Amp"{more}}}
phase = {{message = "Vib", signal = "Pha"}}
"""
SENTINELS = ("SNA", "Error", "not available", "Signal Invalid", "n/a", "Init", "Sensor fault", "Undefiniert")
EXTENDED = 0x98FF1021


def decoder(
    folder: Path,
    *,
    more: str = "",
    top: str = "",
    ident: int = 512,
    length: int = 16,
    table: str = "",
    scale: float = 0.01,
    limits: tuple[float, float] = (0, 0),
) -> FrameDecoder:
    text = DBC.format(ident=ident, length=length, table=table, scale=scale, low=limits[0], high=limits[1])
    (folder / "a.dbc").write_text(text)
    (folder / "a.toml").write_text(TOML.format(more=more, top=top))
    return FrameDecoder(read_mapping(folder / "a.toml"))


def fed(one: FrameDecoder, raw: int, phase: int = 900, flag: int = 1, ident: int = 512) -> Vector | None:
    data = (raw | phase << 32 | flag << 56).to_bytes(8, "little")
    found = one.feed(ident & 0x1FFFFFFF, ident > 0x7FF, data, 0.0)
    assert len(found) <= 1
    return found[0] if found and isinstance(found[0], Vector) else None


quick = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@given(
    st.dictionaries(st.integers(0, 0xFFFF), st.sampled_from(SENTINELS), min_size=1, max_size=4),
    st.integers(0, 0xFFFE),
    st.booleans(),
)
@quick
def test_named_raw_values_are_none_and_others_are_read(
    tmp_path: Path, names: dict[int, str], other: int, full: bool
) -> None:
    table = " ".join(f'{raw} "{name}"' for raw, name in names.items())
    one = decoder(tmp_path, table=table, limits=(0, 655.35) if full else (0, 0))
    for raw in names:
        assert fed(one, raw) is None
    assert counted(one.counts) == {"not_available": len(names)}
    assume(other not in names)
    got = fed(one, other)
    assert got is not None
    assert got.amplitude == pytest.approx(other * 0.01)


def test_names_of_a_measured_number_are_none_such(tmp_path: Path) -> None:
    one = decoder(tmp_path, table='0 "Zero" 100 "1 mm/s" 65535 "SNA"')
    assert [fed(one, raw) is not None for raw in (0, 100, 65535)] == [True, True, False]


@given(st.integers(2, 32), st.integers(0, 2**32 - 1))
@quick
def test_j1939_keeps_the_upper_end(tmp_path: Path, length: int, raw: int) -> None:
    raw %= 1 << length
    one = decoder(tmp_path, ident=EXTENDED, top="node = 0x21", length=length, table='0 "0"', scale=1)
    kept = raw >> (length - 8) >= 0xFB if length in (8, 16, 24, 32) else raw >= (2**length - 2 if length > 2 else 2)
    assert (fed(one, raw, ident=EXTENDED) is None) == (kept or raw > 1e9)


@pytest.mark.parametrize(
    ("raw", "limits", "read"),
    [(0xFFFF, (0, 0), False), (0xFFFF, (0, 655.35), False), (0xFFFE, (0, 0), True), (0xFFFF, (0, 600), False)],
)
def test_all_bits_set_is_not_believed(tmp_path: Path, raw: int, limits: tuple[float, float], read: bool) -> None:
    assert (fed(decoder(tmp_path, limits=limits, table='1 "1"'), raw) is not None) == read


def test_a_phase_that_is_none_leaves_the_amplitude_and_is_counted(tmp_path: Path) -> None:
    one = decoder(tmp_path, table='1 "1"')
    got = fed(one, 300, phase=0xFFFF)
    assert got is not None
    assert (got.amplitude, got.phase_deg) == (3.0, None)
    assert counted(one.counts) == {"not_available": 1}
    assert fed(one, 300, phase=0xFFFD) is None, "6553.3 degrees are no phase"
    assert one.counts["out_of_range"] == 1


def test_the_mapping_has_the_last_word(tmp_path: Path) -> None:
    own = decoder(tmp_path, more=", not_available = [7, 65534]", table='65535 "SNA"')
    assert [fed(own, raw) is not None for raw in (6, 7, 65534, 65535)] == [True, False, False, True]
    limited = decoder(tmp_path, more=", min = 1.0, max = 2.0", limits=(0, 600), table='1 "1"')
    assert [fed(limited, raw) is not None for raw in (50, 150, 250)] == [False, True, False]


RULES = [
    ('"Flag"', lambda raw: raw == 1),
    ('{signal = "Flag", equals = 2}', lambda raw: raw == 2),
    ('{signal = "Flag", equals = "Measuring"}', lambda raw: raw == 2),
    ('{signal = "Flag", equals = ["Measuring", "Hold", 5]}', lambda raw: raw in (2, 3, 5)),
    ('{signal = "Flag", not = "Off"}', lambda raw: raw != 0),
    ('{signal = "Flag", not = [0, 15]}', lambda raw: raw not in (0, 15)),
    ('{signal = "Flag", bits = 0x0C, equals = 0x04}', lambda raw: raw & 0x0C == 0x04),
    ('{signal = "Flag", bits = 2}', lambda raw: raw & 2 == 2),
    ('{signal = "Flag", bits = 2, not = 2}', lambda raw: raw & 2 == 0),
]


@pytest.mark.parametrize(("rule", "holds"), RULES, ids=[rule for rule, _ in RULES])
def test_a_flag_means_what_the_mapping_says(tmp_path: Path, rule: str, holds: object) -> None:
    one = decoder(tmp_path, more=f", valid = {rule}", table='1 "1"')
    assert callable(holds)
    read = [raw for raw in range(16) if fed(one, 300, flag=raw) is not None]
    assert read == [raw for raw in range(16) if holds(raw)]
    assert one.counts["not_valid"] == 16 - len(read)


@pytest.mark.parametrize(
    "rule",
    [
        '{signal = "Flag"}',
        '{signal = "Flag", equals = 1, not = 2}',
        '{signal = "Flag", equals = "Gone"}',
        '{signal = "Flag", bits = 0, equals = 1}',
        '{signal = "Nope", equals = 1}',
        '{signal = "Flag", is = 1}',
        "3",
    ],
)
def test_a_wrong_rule_is_refused_with_its_line(tmp_path: Path, rule: str) -> None:
    with pytest.raises(InvalidSetting, match=r"a.toml, line 5: \[sensor\] amplitude "):
        decoder(tmp_path, more=f", valid = {rule}", table='1 "1"')


@given(st.frozensets(st.integers(0, 15), min_size=1, max_size=15), st.booleans(), st.none() | st.integers(1, 15))
def test_a_sender_finds_values_that_vouch_and_that_do_not(
    values: frozenset[int], negated: bool, bits: int | None
) -> None:
    rule = Validity("Flag", values, negated, bits)
    for good in (True, False):
        if any(rule.holds(raw) == good for raw in range(16)):
            assert rule.holds(rule.example(good, 4)) == good
