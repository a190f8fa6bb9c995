"""A bus drained by a process of its own, here a serial adapter: every frame in order; its ends told in words."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import islice

import can
import pytest

from drivers.can.bus import BusAddress, parse_bus
from drivers.can.driver import CanDriver
from drivers.can.frames import FramesApart, FramesHere, open_frames
from drivers.can.mapping_file import standard_mapping
from drivers.can.sender import CanOut
from drivers.clock import SystemClock
from drivers.errors import BusUnavailable
from tests.support.drivers.frames import readings, sensor_frames
from tests.support.drivers.slcan import Adapter

COUNT = 3000


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    with Adapter() as one:
        yield one


def address_of(adapter: Adapter) -> BusAddress:
    return parse_bus(f"slcan:{adapter.port},bitrate=500000,sleep_after_open=0")


@pytest.mark.parametrize("j1939", [False, True], ids=["standard", "extended"])
def test_thousands_of_readings_over_a_serial_adapter_none_lost(adapter: Adapter, j1939: bool) -> None:
    driver = CanDriver(address_of(adapter), standard_mapping(("P",), j1939=j1939), clock=SystemClock())
    with driver:
        assert adapter.opened.wait(10.0)
        adapter.receive(sensor_frames(COUNT, j1939=j1939))
        found = list(islice(driver, COUNT))
    assert [round(one.amplitude * 1000) for one in found] == [
        round(one.amplitude * 1000) for one in readings(COUNT, sensors=("P",))
    ]
    assert [one.sequence for one in found] == list(range(1, COUNT + 1))
    assert [one.taken_at for one in found] == sorted(one.taken_at for one in found)
    assert (driver.health().missed, driver.health().refused) == (0, 0)
    assert adapter.said[:2] == ["C", "S6"]
    assert "O" in adapter.said
    assert adapter.said[-1] == "C"  # let go of in order


def test_what_is_no_frame_on_the_line_is_passed_over_or_refused(adapter: Adapter) -> None:
    frames = sensor_frames(4)
    remote = can.Message(arbitration_id=0x321, is_remote_frame=True, dlc=8, is_extended_id=False)
    cut = can.Message(arbitration_id=0x321, data=b"\1\2", is_extended_id=False)
    driver = CanDriver(address_of(adapter), standard_mapping(("P",)), clock=SystemClock())
    with driver:
        assert adapter.opened.wait(10.0)
        adapter.receive(frames[:2])
        adapter.write(b"\r\x07V1013\r")
        adapter.receive([remote, cut, *frames[2:]])
        found = list(islice(driver, 4))
    assert len(found) == 4
    assert (driver.decoder.counts["not_data"], driver.decoder.counts["wrong_length"]) == (1, 1)


def test_frames_are_sent_through_the_adapter(adapter: Adapter) -> None:
    out = CanOut(address_of(adapter), standard_mapping(("P",)))
    assert adapter.opened.wait(10.0)
    out.post(readings(3, sensors=("P",)))
    out.close()
    end = time.monotonic() + 10.0
    while adapter.said[-1] != "C":
        assert time.monotonic() < end, adapter.said
        time.sleep(0.01)
    assert len(adapter.sent) == 1 + 3 * 2  # a heartbeat, then speed and vibration of each
    assert all(line.startswith("t") for line in adapter.sent)


def test_an_adapter_that_is_not_there_is_told_with_what_to_do() -> None:
    with pytest.raises(BusUnavailable, match=r"slcan:/dev/nothing cannot be opened .*check the serial port"):
        open_frames(BusAddress("slcan", "/dev/nothing", {"sleep_after_open": 0}))


def test_a_reader_that_is_killed_is_a_lost_bus_and_a_closed_one_an_end(adapter: Adapter) -> None:
    frames = open_frames(address_of(adapter))
    assert isinstance(frames, FramesApart)
    frames._process.kill()
    with pytest.raises(BusUnavailable, match="its reader has ended"):
        frames.take(5.0)
    frames.close()
    frames.close()
    assert frames.take(0.0) == ()


def test_a_reader_ends_with_whoever_started_it(adapter: Adapter) -> None:
    program = (
        "from drivers.can.bus import BusAddress; from drivers.can.frames import open_frames; import os, sys\n"
        f"frames = open_frames(BusAddress('slcan', {adapter.port!r}, {{'sleep_after_open': 0}}))\n"
        "print(frames._process.pid, flush=True); os.kill(os.getpid(), 9)"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (ran.returncode, ran.stdout.strip().isdigit()) == (-9, True), ran.stderr
    end = time.monotonic() + 10.0
    while list(adapter.said)[-1:] != ["C"]:  # it shut the channel on its way out
        assert time.monotonic() < end, adapter.said
        time.sleep(0.01)


def test_a_bus_of_one_process_is_read_in_it() -> None:
    frames = open_frames(BusAddress("virtual", "here"))
    assert isinstance(frames, FramesHere)
    frames.close()
