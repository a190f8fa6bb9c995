"""The decoder: every frame is a reading or is counted under its reason; round trips; never an error."""

from __future__ import annotations

import math
import struct
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.can.decoder import FrameDecoder, Masses, Vector
from drivers.can.mapping import CanMapping
from drivers.can.mapping_file import read_mapping, standard_mapping
from drivers.can.sender import FrameEncoder
from drivers.errors import InvalidSetting
from drivers.reading import Answer
from tests.support.drivers.frames import START, feed, readings, sensor_frames, stranger


def counted(decoder: FrameDecoder) -> dict[str, int]:
    return {reason: count for reason, count in decoder.counts.items() if count}


def amplitudes(found: list[Vector | Masses]) -> list[int]:
    return [round(one.amplitude / 0.001) for one in found if isinstance(one, Vector)]


@given(
    st.floats(0.0, 1048.0),
    st.none() | st.floats(0.0, 359.94),
    st.none() | st.floats(0.1, 100_000.0),
    st.none() | st.floats(0.0, 1048.0),
    st.booleans(),
)
def test_what_is_sent_comes_back_to_half_a_step(
    amplitude: float, phase: float | None, speed: float | None, overall: float | None, j1939: bool
) -> None:
    mapping = standard_mapping(("P",), j1939=j1939)
    sent = replace(
        readings(1, sensors=("P",))[0], amplitude=amplitude, phase_deg=phase, speed_rpm=speed, overall_rms=overall
    )
    (got,) = feed(FrameDecoder(mapping), FrameEncoder(mapping).reading(sent))
    assert isinstance(got, Vector)
    assert (got.sensor, got.lost) == ("P", 0)
    assert got.amplitude == pytest.approx(amplitude, abs=0.00051)
    for there, back, step in (
        (phase, got.phase_deg, 0.1),
        (speed, got.speed_rpm, 0.1),
        (overall, got.overall_rms, 0.001),
    ):
        assert (there is None) == (back is None)
        if there is not None and back is not None:
            assert back == pytest.approx(there, abs=0.51 * step)


def test_a_value_beyond_its_signal_is_sent_as_not_valid() -> None:
    mapping = standard_mapping(("P",))
    decoder = FrameDecoder(mapping)
    loud = replace(readings(1)[0], amplitude=2000.0)
    assert feed(decoder, FrameEncoder(mapping).reading(loud)) == []
    assert counted(decoder) == {"not_valid": 1}


def test_lost_frames_are_counted_to_their_sensor() -> None:
    frames = sensor_frames(20)
    kept = frames[:5] + frames[8:]
    decoder = FrameDecoder(standard_mapping(("P",)))
    found = feed(decoder, kept)
    assert amplitudes(found) == [1, 2, 3, 4, *range(8, 21)]
    assert [one.lost for one in found if isinstance(one, Vector) and one.lost] == [3]
    assert decoder.lost_frames == 3
    assert counted(decoder) == {}


@pytest.mark.parametrize(("gap", "lost", "late"), [(100, 99, 0), (128, 127, 0), (129, 0, 1)])
def test_up_to_half_a_turn_of_the_counter_is_a_loss_and_more_is_a_frame_that_came_late(
    gap: int, lost: int, late: int
) -> None:
    """A counter of 256: one that is 128 ahead has missed 127 frames, one that is 129 ahead is 127 behind."""
    frames = sensor_frames(300)
    decoder = FrameDecoder(standard_mapping(("P",)))
    feed(decoder, [*frames[:6], frames[5 + gap]])
    assert (decoder.lost_frames, counted(decoder).get("late", 0)) == (lost, late)


def test_doubled_frames_are_read_once() -> None:
    frames = [frame for frame in sensor_frames(30) for _ in range(2)]
    decoder = FrameDecoder(standard_mapping(("P",)))
    assert amplitudes(feed(decoder, frames)) == list(range(1, 31))
    assert counted(decoder) == {"doubled": 31}  # 30 readings and the speed


def test_a_frame_behind_the_others_is_refused_and_the_count_goes_on() -> None:
    frames = sensor_frames(20)
    frames[5], frames[6] = frames[6], frames[5]
    decoder = FrameDecoder(standard_mapping(("P",)))
    assert amplitudes(feed(decoder, frames)) == [1, 2, 3, 4, 6, *range(7, 21)]
    assert counted(decoder) == {"late": 1}
    assert decoder.lost_frames == 1


def test_a_balancer_that_starts_again_is_heard_after_one_frame() -> None:
    frames = sensor_frames(100) + sensor_frames(10)[1:]
    decoder = FrameDecoder(standard_mapping(("P",)))
    found = feed(decoder, frames)
    assert amplitudes(found) == [*range(1, 101), *range(2, 11)]
    assert counted(decoder) == {"late": 1}


def test_a_silence_is_no_loss_that_could_be_told() -> None:
    frames = sensor_frames(40)
    decoder = FrameDecoder(standard_mapping(("P",)))
    before = feed(decoder, frames[:10])
    after = [v for f in frames[30:] for v in decoder.feed(f.arbitration_id, False, f.data, 5.0)]
    assert amplitudes(before + after) == [*range(1, 10), *range(30, 41)]
    assert decoder.lost_frames == 0


def test_a_frame_that_lacks_a_mapped_signal_is_refused_and_a_padded_one_is_read() -> None:
    decoder = FrameDecoder(standard_mapping(("P",)))
    frame = sensor_frames(1)[1]
    for data in (b"", bytes(frame.data[:1]), bytes(frame.data[:7])):
        assert decoder.feed(frame.arbitration_id, False, data, 0.0) == []
    assert counted(decoder) == {"wrong_length": 3}
    assert amplitudes(decoder.feed(frame.arbitration_id, False, bytes(frame.data) + b"\xff" * 56, 0.0)) == [1]


def test_frames_of_another_node_or_kind_are_not_ours() -> None:
    decoder = FrameDecoder(standard_mapping(("P",)))
    frame = sensor_frames(1)[1]
    assert decoder.feed(frame.arbitration_id, True, frame.data, 0.0) == []  # same number, extended
    assert decoder.feed(0x7FF, False, frame.data, 0.0) == []
    assert decoder.feed(frame.arbitration_id, False, b"", 0.0, is_data=False) == []
    assert counted(decoder) == {"foreign": 2, "not_data": 1}
    assert decoder.refused == 1


def test_a_value_out_of_range_is_refused_though_cantools_takes_it() -> None:
    decoder = FrameDecoder(standard_mapping(("P",)))
    frame = sensor_frames(1)[1]
    phase_at_its_highest_raw = bytearray(frame.data)
    phase_at_its_highest_raw[2] |= 0xF0
    phase_at_its_highest_raw[3] = 0xFF
    message = decoder.mapping.database.get_message_by_name("Sensor1")
    assert message.decode(bytes(phase_at_its_highest_raw))["Phase"] == pytest.approx(409.5)  # type: ignore[call-overload]
    assert decoder.feed(frame.arbitration_id, False, phase_at_its_highest_raw, 0.0) == []
    assert counted(decoder) == {"out_of_range": 1}


def test_a_speed_that_is_old_is_not_put_into_a_reading() -> None:
    speed, first, second = sensor_frames(2)
    decoder = FrameDecoder(standard_mapping(("P",)))
    decoder.feed(speed.arbitration_id, False, speed.data, 0.0)
    (fresh,) = decoder.feed(first.arbitration_id, False, first.data, 0.9)
    (stale,) = decoder.feed(second.arbitration_id, False, second.data, 1.1)
    assert isinstance(fresh, Vector)
    assert isinstance(stale, Vector)
    assert fresh.speed_rpm == pytest.approx(460.0)
    assert stale.speed_rpm is None


def test_the_balancer_s_own_answer_comes_once_and_whole() -> None:
    mapping = standard_mapping(("P",), ("1", "2"))
    encoder, decoder = FrameEncoder(mapping), FrameDecoder(mapping)
    first = Answer("can", 1, START, (("1", 170.2, 70.0), ("2", 292.2, 113.0)))
    second = Answer("can", 2, START, (("1", 170.2, 71.0), ("2", 290.0, 113.0)))
    one, other = encoder.answer(first, 1)
    assert feed(decoder, [one]) == []
    (whole,) = feed(decoder, [other])
    assert isinstance(whole, Masses)
    rounded = tuple((plane, round(mass, 6), round(angle, 6)) for plane, mass, angle in whole.masses)
    assert rounded == first.masses
    assert feed(decoder, encoder.answer(first, 1)) == []
    torn, rest = encoder.answer(second, 2)
    assert feed(decoder, [torn]) == []
    assert len(feed(decoder, [rest])) == 1


def masses_of(decoder: FrameDecoder, frames: Sequence[can.Message], at: float) -> list[dict[str, float]]:
    """Masses by plane of the answers that come out of frames at a time."""
    found = [one for frame in frames for one in decoder.feed(frame.arbitration_id, False, frame.data, at)]
    return [{plane: round(mass, 6) for plane, mass, _ in one.masses} for one in found if isinstance(one, Masses)]


def test_answers_of_two_jobs_are_never_put_together() -> None:
    """Half of an answer is lost, and the next job counts from the same number."""
    mapping = standard_mapping(("P",), ("L", "R"))
    encoder, decoder = FrameEncoder(mapping), FrameDecoder(mapping)
    left_a, right_a = encoder.answer(Answer("can", 1, START, (("L", 120.0, 0.0), ("R", 80.0, 0.0))), 1)
    left_b, right_b = encoder.answer(Answer("can", 1, START, (("L", 55.0, 0.0), ("R", 66.0, 0.0))), 1)
    for first, second in (((right_a,), (left_b, right_b)), ((left_a,), (right_b, left_b))):
        assert masses_of(decoder, first, 0.0) == []
        assert masses_of(decoder, second, 3.0) == [{"L": 55.0, "R": 66.0}]
        decoder = FrameDecoder(mapping)
    # Nor where the second job begins at once: the first answer is used up.
    assert masses_of(decoder, (left_a, right_a), 10.0) == [{"L": 120.0, "R": 80.0}]
    assert masses_of(decoder, (left_b,), 10.1) == []
    assert masses_of(decoder, (right_b,), 10.2) == [{"L": 55.0, "R": 66.0}]


def test_the_first_answer_of_a_restarted_balancer_counts() -> None:
    mapping = standard_mapping(("P",), ("L", "R"))
    encoder, decoder = FrameEncoder(mapping), FrameDecoder(mapping)
    before = encoder.answer(Answer("can", 1, START, (("L", 120.0, 0.0), ("R", 80.0, 0.0))), 1)
    after = encoder.answer(Answer("can", 1, START, (("L", 55.0, 0.0), ("R", 66.0, 0.0))), 1)
    assert len(masses_of(decoder, before, 0.0)) == 1
    assert masses_of(decoder, after, 30.0) == [{"L": 55.0, "R": 66.0}]
    for second in range(31, 90):  # it goes on saying so
        assert masses_of(decoder, after, float(second)) == []
    assert masses_of(decoder, after, 1000.0) == [{"L": 55.0, "R": 66.0}]


def test_nothing_to_add_in_a_plane_is_an_answer() -> None:
    mapping = standard_mapping(("P",), ("L", "R"))
    frames = FrameEncoder(mapping).answer(Answer("can", 1, START, (("L", 0.0, 0.0), ("R", 66.0, 0.0))), 1)
    assert masses_of(FrameDecoder(mapping), frames, 0.0) == [{"L": 0.0, "R": 66.0}]


def test_status_and_heartbeat_are_told() -> None:
    mapping = standard_mapping(("P",))
    decoder = FrameDecoder(mapping)
    assert decoder.silent_s(100.0) is None
    (beat,) = FrameEncoder(mapping).heartbeat()
    decoder.feed(beat.arbitration_id, False, beat.data, 100.0)
    assert decoder.silent_s(104.0) == 4.0
    decoder.feed(0x300, False, bytes([2, 0, 0, 0, 0, 0, 0, 0]), 105.0)
    assert decoder.status == "Measuring"
    assert decoder.silent_s(106.0) == 6.0


def test_another_maker_s_balancer_in_other_units_and_senses(tmp_path: Path) -> None:
    decoder = FrameDecoder(read_mapping(stranger(tmp_path)))
    ids = {message.name: message.frame_id for message in decoder.mapping.messages()}
    payloads = {
        "Rot": struct.pack("<f", 7.5),  # Hz
        "Vib": bytes([0x10, 100, 0, 200, 0, 0, 0, 0]),  # 0.1 in/s peak; 0.2 in/s rms
        "Ang": b"\0" + struct.pack("<h", 1000) + b"\0",  # leads by 1 rad
    }
    frames = [can.Message(arbitration_id=ids[name] ^ (5 << 26), data=data) for name, data in payloads.items()]
    (got,) = feed(decoder, frames)  # of another priority, which is no matter
    assert isinstance(got, Vector)
    assert got.sensor == "left"
    assert got.amplitude == pytest.approx(0.1 * 25.4 / math.sqrt(2.0))
    assert got.overall_rms == pytest.approx(0.2 * 25.4)
    assert got.phase_deg == pytest.approx(360.0 - math.degrees(1.0))
    assert got.speed_rpm == pytest.approx(450.0)
    for frame in frames:
        frame.arbitration_id += 1  # another source address
    assert feed(decoder, frames) == []
    assert counted(decoder) == {"foreign": 3}


def test_amplitude_and_phase_in_two_messages_are_paired_within_their_round(tmp_path: Path) -> None:
    mapping = read_mapping(stranger(tmp_path))
    decoder, encoder = FrameDecoder(mapping), FrameEncoder(mapping)
    rounds = [
        encoder.reading(replace(one, sensor="left", amplitude=index + 1.0)) for index, one in enumerate(readings(6))
    ]
    frames = [frame for index, one in enumerate(rounds) for frame in (one if index != 2 else one[:-1])]
    found = feed(decoder, frames)
    assert [round(one.amplitude) for one in found if isinstance(one, Vector)] == [1, 2, 4, 5, 6]
    assert counted(decoder) == {"unpaired": 1}


def test_a_sensor_without_a_signal_cannot_be_sent() -> None:
    with pytest.raises(InvalidSetting, match="sensor 'Q' has no signal"):
        FrameEncoder(standard_mapping(("P",))).reading(readings(2)[1])


FRAMES = st.tuples(
    st.sampled_from([0x300, 0x301, 0x310, 0x321, 0x331, 0x332]) | st.integers(0, 0x1FFFFFFF),
    st.booleans(),
    st.binary(min_size=8, max_size=8) | st.binary(max_size=64),
    st.floats(0.0, 1e6),
)


@given(st.lists(FRAMES, max_size=60))
@settings(max_examples=300)
def test_any_bytes_are_a_valid_reading_or_counted(frames: list[tuple[int, bool, bytes, float]]) -> None:
    decoder = FrameDecoder(standard_mapping(("P", "Q"), ("1", "2")))
    for identifier, extended, data, at in frames:
        for found in decoder.feed(identifier, extended, data, at):
            if isinstance(found, Vector):
                assert 0.0 <= found.amplitude <= 1048.6
                assert found.phase_deg is None or 0.0 <= found.phase_deg < 360.0
                assert found.speed_rpm is None or found.speed_rpm > 0.0
    assert decoder.frames == len(frames)


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> CanMapping:
    return read_mapping(stranger(tmp_path_factory.mktemp("strange")))


@given(st.lists(st.tuples(st.sampled_from(["Rot", "Vib", "Ang"]), st.binary(max_size=9)), max_size=40))
def test_any_bytes_in_another_maker_s_frames_too(strange: CanMapping, frames: list[tuple[str, bytes]]) -> None:
    decoder = FrameDecoder(strange)
    ids = {message.name: message.frame_id for message in decoder.mapping.messages()}
    for name, data in frames:
        for found in decoder.feed(ids[name], True, data, 0.0):
            assert isinstance(found, Vector)
            assert math.isfinite(found.amplitude)
            assert found.speed_rpm is None or 0.0 < found.speed_rpm <= 30_001.0


@given(st.data())
@settings(max_examples=60)
def test_faults_of_the_bus_add_up(data: st.DataObject) -> None:
    """Whatever is lost, doubled or truncated in less than half a turn of the counter: no reading twice, all counted."""
    frames = sensor_frames(60)[1:]
    fate = st.sampled_from(["ok"] * 4 + ["lost", "doubled", "cut"])
    fates = data.draw(st.lists(fate, min_size=60, max_size=60))
    sent: list[can.Message] = []
    for frame, what in zip(frames, fates, strict=True):
        if what == "cut":
            sent.append(can.Message(arbitration_id=frame.arbitration_id, is_extended_id=False, data=frame.data[:5]))
        sent += [] if what in ("lost", "cut") else [frame] * (2 if what == "doubled" else 1)
    decoder = FrameDecoder(standard_mapping(("P",)))
    found = amplitudes(feed(decoder, sent))
    assert found == [index + 1 for index, what in enumerate(fates) if what in ("ok", "doubled")]
    fate_counts = Counter(fates)
    assert decoder.counts["doubled"] == fate_counts["doubled"]
    assert decoder.counts["wrong_length"] == fate_counts["cut"]
    if found:
        inside = fates[found[0] - 1 : found[-1]]
        assert decoder.lost_frames == sum(what in ("lost", "cut") for what in inside)
