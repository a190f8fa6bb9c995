"""A bus that goes down and comes back, an adapter that is pulled and plugged in: picked up again each time."""

from __future__ import annotations

import random
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import can
import pytest

from drivers.bridge.bridge import Bridge
from drivers.bridge.spool import Spool, Spooled
from drivers.can.bus import BusAddress
from drivers.can.driver import CanDriver
from drivers.can.frames import Frame, Frames
from drivers.can.mapping_file import standard_mapping
from drivers.clock import ManualClock
from drivers.errors import BusUnavailable
from tests.support.drivers.frames import START, sensor_frames

TIMES = 200
RAISED: list[type[Exception]] = [BusUnavailable, OSError, can.CanError, RuntimeError, KeyError, ValueError, MemoryError]


class Flaky:
    """Gives a few frames, then raises; opening it again fails now and then, with anything."""

    def __init__(self, frames: Sequence[can.Message], stop: threading.Event, rng: random.Random) -> None:
        self.rest, self._stop, self._rng = list(frames), stop, rng
        self.lost = self.refused = 0
        self._left = 0

    def open(self, _address: BusAddress) -> Frames:
        if self._rng.random() < 0.3:
            self.refused += 1
            raise self._rng.choice(RAISED)("no such adapter")
        self._left = self._rng.randint(0, 4)
        return self

    def take(self, timeout_s: float) -> Sequence[Frame]:
        if self.lost >= TIMES and not self.rest:
            self._stop.set()
            return ()
        if not self._left and self.lost < TIMES:
            self.lost += 1
            raise self._rng.choice(RAISED)("unplugged")
        self._left -= 1
        if not self.rest:
            return ()
        one = self.rest.pop(0)
        return ((None, one.arbitration_id, one.is_extended_id, one.data, True),)

    def close(self) -> None:
        if self._rng.random() < 0.1:
            raise OSError("gone already")


class Stored:
    def __init__(self) -> None:
        self.sequences: list[int] = []

    def send(self, items: Sequence[Spooled]) -> None:
        self.sequences += [one.sequence for one in items]

    def close(self) -> None:
        return


@pytest.mark.parametrize("seed", range(3))
def test_a_bus_that_is_lost_is_picked_up_again(tmp_path: Path, seed: int) -> None:
    told: list[str] = []
    stop, clock = threading.Event(), ManualClock(START)
    frames = sensor_frames(TIMES)
    flaky, service = Flaky(frames, stop, random.Random(seed)), Stored()
    driver = CanDriver(
        BusAddress("flaky"), standard_mapping(("P",)), clock=clock, monotonic=lambda: 0.0, open_with=flaky.open
    )
    with Spool(tmp_path / "spool.db") as spool:
        while driver.health().state == "closed":
            with suppress(Exception):
                driver.open()
        bridge = Bridge(driver, spool, service, stop=stop, clock=clock, rng=random.Random(1), report=told.append)
        bridge.run()
        assert spool.waiting() == 0
    assert flaky.lost == TIMES == bridge.reopened
    assert bridge.trouble is None
    assert len(service.sequences) == len(set(service.sequences)) == len(frames) - 1  # one holds the speed
    assert f"reopened {TIMES}" in told[-1]
