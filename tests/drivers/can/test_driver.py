"""The CAN driver beyond the contract: times, numbers, answers, counters."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from functools import partial
from itertools import islice, pairwise

import can
import pytest

from drivers.can.bus import BusAddress
from drivers.can.driver import CanDriver
from drivers.can.frames import FramesHere
from drivers.can.mapping_file import standard_mapping
from drivers.can.sender import CanOut, FrameEncoder
from drivers.clock import ManualClock
from drivers.reading import Answer, Mark, Reading
from tests.support.drivers.frames import START, readings, sensor_frames

MAPPING = standard_mapping(("P", "Q"), ("1", "2"))


class Tape(can.BusABC):
    """A bus on which these frames come, one every step_s, and then none: the driver is closed."""

    def __init__(self, frames: list[can.Message]) -> None:
        super().__init__(channel="tape")
        self.frames = list(reversed(frames))
        self.driver: CanDriver | None = None
        self.after_each: Callable[[], object] = int

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise NotImplementedError

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self.frames:
            assert self.driver is not None
            self.driver.close()
            return None, False
        self.after_each()
        return self.frames.pop(), False


class Passing:
    """A monotonic clock that a test moves."""

    seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


def driver_of(tape: Tape, clock: ManualClock, passing: Passing, answers: list[Answer] | None = None) -> CanDriver:
    tape.driver = CanDriver(
        BusAddress("virtual", "tape"),
        MAPPING,
        clock=clock,
        monotonic=passing,
        sequence_start=1000,
        on_answer=None if answers is None else answers.append,
        open_with=lambda _: FramesHere(tape),
    )
    return tape.driver


def read_all(driver: CanDriver) -> list[Reading]:
    with driver:
        return list(driver)


def test_a_clock_set_back_in_mid_stream_neither_stops_nor_loses_nor_doubles_readings() -> None:
    clock, passing, tape = ManualClock(START), Passing(), Tape(sensor_frames(50))

    def pass_time() -> None:
        passing.seconds += 0.01
        clock.advance(0.01)
        if len(tape.frames) == 25:
            clock.advance(-3600.0)

    tape.after_each = pass_time
    found = read_all(driver_of(tape, clock, passing))
    assert [round(one.amplitude * 1000) for one in found] == list(range(1, 51))
    assert [one.sequence for one in found] == list(range(1000, 1050))
    steps = {(b.taken_at - a.taken_at) for a, b in pairwise(found)}
    assert all(step == pytest.approx(timedelta(seconds=0.01), abs=timedelta(microseconds=5)) for step in steps)
    assert all(one.speed_rpm is not None for one in found)


def test_lost_readings_leave_a_gap_in_the_numbers_and_are_counted() -> None:
    frames = sensor_frames(20)
    tape = Tape(frames[:6] + frames[9:])
    driver = driver_of(tape, ManualClock(), Passing())
    found = read_all(driver)
    assert [one.sequence for one in found] == [*range(1000, 1005), *range(1008, 1020)]
    assert (driver.health().delivered, driver.health().missed, driver.health().refused) == (17, 3, 0)


def test_what_is_refused_is_counted_and_told() -> None:
    frames = sensor_frames(3)
    foreign = can.Message(arbitration_id=0x7FF, data=b"", is_extended_id=False)
    cut = can.Message(arbitration_id=0x321, data=b"\1", is_extended_id=False)
    remote = can.Message(arbitration_id=0x321, is_remote_frame=True, dlc=8, is_extended_id=False)
    driver = driver_of(Tape([*frames, frames[-1], foreign, cut, remote]), ManualClock(), Passing())
    assert len(read_all(driver)) == 3
    assert driver.health().refused == 3
    assert driver.bus_state() == "balancer not heard yet, foreign 1, not_data 1, wrong_length 1, doubled 1"


def test_a_balancer_s_answers_are_handed_over_with_numbers_of_their_own() -> None:
    encoder, answers = FrameEncoder(MAPPING), list[Answer]()
    masses = (("1", 170.2, 70.0), ("2", 292.2, 113.0))
    frames = [frame for number in (1, 1, 2) for frame in encoder.answer(Answer("x", 1, START, masses), number)]
    read_all(driver_of(Tape(sensor_frames(2) + frames), ManualClock(START), Passing(), answers))
    assert [(one.source, one.sequence) for one in answers] == [("can", 1000), ("can", 1001)]
    assert tuple((plane, round(mass, 6), round(angle, 6)) for plane, mass, angle in answers[0].masses) == masses


def test_thousands_of_readings_over_the_virtual_bus_none_lost() -> None:

    out = CanOut(BusAddress("virtual", "many"), MAPPING)
    driver = CanDriver(BusAddress("virtual", "many"), MAPPING, clock=ManualClock())
    got = []
    with driver:
        for start in range(1, 5001, 500):
            out.post(readings(500, first=start))
            got += list(islice(driver, 500))
    out.close()
    assert [round(one.amplitude * 1000) for one in got] == list(range(1, 5001))
    assert (driver.health().missed, driver.health().refused) == (0, 0)


def same(source: FramesHere, address: BusAddress) -> FramesHere:
    return source


def resumed(frames: list[can.Message], skipped: int, away_s: float, clock_error_s: float = 0.0) -> CanDriver:
    """A driver that reads what is left of the frames after half and a gap, from the last mark of one that read half.

    Frames come 10 ms apart; the gap lasts away_s.
    """
    half, marks = len(frames) // 2, list[Mark]()
    clock, passing = ManualClock(START), Passing()

    def pass_time() -> None:
        passing.seconds += 0.01
        clock.advance(0.01)

    for part, counters in ((frames[:half], ()), (frames[half + skipped :], None)):
        if counters is None:
            passing.seconds = 0.0  # another process, perhaps another start of the machine
            clock.advance(away_s - 0.01 + clock_error_s)
        tape = Tape(part)
        source = FramesHere(tape)
        tape.after_each = pass_time
        driver = CanDriver(
            BusAddress("virtual", "tape"),
            MAPPING,
            clock=clock,
            monotonic=passing,
            on_mark=marks.append,
            resume=marks[-1] if marks else None,
            open_with=partial(same, source),
        )
        tape.driver = driver
        read_all(driver)
    return driver


@pytest.mark.parametrize("skipped", [0, 1, 7, 255, 256, 700])
def test_frames_lost_while_nothing_read_the_bus_are_counted_by_the_next_driver(skipped: int) -> None:
    driver = resumed(sensor_frames(2000), skipped, 0.01 * (skipped + 1))
    assert driver.decoder.lost_unread == driver.decoder.lost_frames == skipped
    assert driver.health().missed == skipped
    told = f"frames lost {skipped} (about {skipped} while nothing read the bus)"
    assert (told in driver.bus_state()) == (skipped > 0)


def test_a_clock_set_back_meanwhile_leaves_what_the_counter_itself_tells() -> None:
    assert resumed(sensor_frames(2000), 40, 0.41, clock_error_s=-3600.0).decoder.lost_unread == 40


def test_after_a_long_time_nothing_is_said_of_frames_that_may_never_have_been_sent() -> None:
    assert resumed(sensor_frames(2000), 40, 3600.0).decoder.lost_unread == 0
