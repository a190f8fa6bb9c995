"""J1939: groups whatever priority, source and destination; nodes by their names; messages of several frames."""

from __future__ import annotations

from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.can.decoder import FrameDecoder, Vector
from drivers.can.j1939 import MAX_BYTES, Transfers, group_of
from drivers.can.mapping_file import read_mapping
from drivers.can.refusals import counted

DBC = """VERSION ""
NS_ :
BS_:
BU_: X
BO_ {ident} Vib: {size} X
 SG_ Amp : 0|16@1+ (0.01,0) [0|642.55] "mm/s" X
 SG_ Pha : {at}|16@1+ (0.1,0) [0|359.9] "deg" X
"""
TOML = """dbc = "a.dbc"
{top}
[[sensor]]
name = "P"
amplitude = {{message = "Vib", signal = "Amp"}}
phase = {{message = "Vib", signal = "Pha"}}
"""
DATA = bytes.fromhex("2C016004FFFFFFFF")
PDU1, PDU2 = 0x18EF00FE, 0x18FF1121
NAMES = (0x8000_0064_0000_0021, 0x0000_0064_0000_0099)
quick = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def decoder(folder: Path, ident: int, top: str = "", size: int = 8) -> FrameDecoder:
    at = 16 if size == 8 else 8 * size - 16
    (folder / "a.dbc").write_text(DBC.format(ident=ident | 1 << 31, size=size, at=at))
    (folder / "a.toml").write_text(TOML.format(top=top))
    return FrameDecoder(read_mapping(folder / "a.toml"))


def feed(one: FrameDecoder, ident: int, data: bytes = DATA, at: float = 0.0) -> int:
    found = one.feed(ident, True, data, at)
    assert all(isinstance(vector, Vector) and abs(vector.amplitude - 3.0) < 1e-9 for vector in found)
    return len(found)


def claim(one: FrameDecoder, source: int, name: int, at: float = 0.0) -> None:
    assert feed(one, 0x18EEFF00 | source, name.to_bytes(8, "little"), at) == 0


@given(st.integers(0, 7), st.integers(0, 253), st.integers(0, 255), st.booleans())
@quick
def test_a_group_is_known_by_its_number_alone(
    tmp_path: Path, priority: int, source: int, destination: int, pdu1: bool
) -> None:
    base = PDU1 if pdu1 else PDU2
    sent = priority << 26 | (base & 0x03FFFF00) | source
    if pdu1:
        sent = (sent & ~0xFF00) | destination << 8
    assert feed(decoder(tmp_path, base, f"node = {source}"), sent) == 1
    assert feed(decoder(tmp_path, base, f"node = {(source + 1) % 254}"), sent) == 0
    assert feed(decoder(tmp_path, base, 'node = "any"'), sent) == 1
    assert feed(decoder(tmp_path, (base & ~0xFF) | 0xFE), sent) == 1, "the null address in the DBC stands for any"
    assert feed(decoder(tmp_path, (base & ~0xFF) | 0x21), sent) == (sent == (base & ~0xFF) | 0x21)


def test_two_nodes_of_one_group_are_not_mixed(tmp_path: Path) -> None:
    one = decoder(tmp_path, PDU2, 'node = "any"')
    assert [feed(one, PDU2 & ~0xFF | source, at=at) for source, at in ((5, 0.0), (6, 0.1), (5, 0.2), (6, 9.0))] == [
        1,
        0,
        1,
        1,
    ]
    assert counted(one.counts) == {"other_node": 1}


def test_a_balancer_is_followed_to_another_address_by_its_name(tmp_path: Path) -> None:
    one = decoder(tmp_path, PDU2, "node = 0x21")
    claim(one, 0x21, NAMES[0])
    assert feed(one, 0x18FF1121) == 1
    claim(one, 0x21, NAMES[1])  # a lower name takes the address
    assert feed(one, 0x18FF1121) == 0
    claim(one, 0x80, NAMES[0])
    assert (feed(one, 0x18FF1180), feed(one, 0x18FF1121)) == (1, 0)


def test_a_name_in_the_mapping_waits_for_its_claim(tmp_path: Path) -> None:
    one = decoder(tmp_path, PDU2, f"node_name = {NAMES[1]}")
    assert feed(one, 0x18FF1121) == 0
    claim(one, 0x44, NAMES[1])
    assert feed(one, 0x18FF1144) == 1
    claim(one, 0xFE, NAMES[1])  # it cannot claim an address
    assert feed(one, 0x18FF1144) == 0


# ---------------------------------------------------------------- messages of several frames
def packets(group: int, data: bytes, source: int, destination: int = 255) -> list[tuple[int, bytes]]:
    count = (len(data) + 6) // 7
    control = 32 if destination == 255 else 16
    head = bytes([control]) + len(data).to_bytes(2, "little") + bytes([count, 255]) + group.to_bytes(3, "little")
    found = [(0x18EC0000 | destination << 8 | source, head)]
    for number in range(count):
        part = data[7 * number : 7 * number + 7].ljust(7, b"\xff")
        found.append((0x18EB0000 | destination << 8 | source, bytes([number + 1]) + part))
    return found


@given(st.binary(min_size=9, max_size=400), st.integers(0, 253), st.sampled_from([255, 3, 200]), st.data())
@quick
def test_a_long_message_is_put_together_among_others(
    data: bytes, source: int, destination: int, more: st.DataObject
) -> None:
    transfers = Transfers([0xFF11])
    mine = packets(0xFF11, data, source, destination)
    others = packets(0xFF11, data[::-1], (source + 1) % 254, destination) + packets(0xFE00, data, source, 77)
    order = more.draw(st.permutations([0] * len(mine) + [1] * len(others)))
    found, queues = [], [list(mine), list(others)]
    for which in order:
        ident, part = queues[which].pop(0)
        if (whole := transfers.take(ident, part, 0.0)) is not None:
            found.append(whole)
    assert {(ident & 0xFF, whole) for ident, whole in found} == {(source, data), ((source + 1) % 254, data[::-1])}
    assert {group_of(ident) for ident, _ in found} == {0xFF11}
    assert transfers.broken == 0


def test_a_long_message_gives_its_reading_and_a_broken_one_is_counted(tmp_path: Path) -> None:
    data = bytes.fromhex("2C01") + bytes(20) + bytes.fromhex("6004")
    one = decoder(tmp_path, 0x18FF11FE, size=24)
    assert [feed(one, *part) for part in packets(0xFF11, data, 7)] == [0, 0, 0, 0, 1]
    parts = packets(0xFF11, data, 7)
    assert [feed(one, *part) for part in (*parts[:2], *parts[3:])] == [0, 0, 0, 0]
    assert one.counts["incomplete"] == 1


@given(
    st.lists(st.tuples(st.sampled_from([0x18EC, 0x1CEB]), st.integers(0, 0xFFFF), st.binary(max_size=8)), max_size=60)
)
def test_any_frames_of_the_protocol_are_bounded(frames: list[tuple[int, int, bytes]]) -> None:
    transfers = Transfers([0xFF11])
    for at, (group, low, data) in enumerate(frames):
        whole = transfers.take(group << 16 | low, data, float(at) * 0.1)
        assert whole is None or 8 < len(whole[1]) <= MAX_BYTES
