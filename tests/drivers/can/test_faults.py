"""Frames lost, doubled, out of order, truncated and of another node, a clock set back: all of it accounted for.

From the bus through the spool to a service: each reading that was sent is stored once, or counted as missed.
"""

from __future__ import annotations

import json
import random
import threading
from collections.abc import Sequence
from pathlib import Path

import can
import pytest

from drivers.bridge.bridge import Bridge
from drivers.bridge.spool import Spool, Spooled
from drivers.can.bus import BusAddress
from drivers.can.driver import CanDriver
from drivers.can.frames import Frame
from drivers.can.mapping_file import parse_mapping, standard_mapping_text
from drivers.clock import ManualClock, SystemClock
from tests.support.drivers.frames import START, sensor_frames

COUNT = 3000
NODE, OTHER = 0x80, 0x81


class Damaged:
    """Frames with faults of a kind at random places, never two within a few frames, and how many there are."""

    def __init__(self, frames: Sequence[can.Message], kinds: Sequence[str], rng: random.Random) -> None:
        self.counts = dict.fromkeys(kinds, 0)
        self.frames: list[can.Message] = list(frames[:20])
        place = 20
        while place < len(frames) - 20:
            kind = rng.choice(kinds)
            self.counts[kind] += 1
            self.frames += self.made(kind, frames[place], frames[place + 1])
            healthy = rng.randint(4, 20)
            self.frames += frames[place + 2 : place + 2 + healthy]
            place += 2 + healthy
        self.frames += frames[place:]

    def made(self, kind: str, one: can.Message, other: can.Message) -> list[can.Message]:
        """What comes in place of two frames."""
        if kind == "lost":
            return [other]
        if kind == "doubled":
            return [one, one, other]
        if kind == "late":
            return [other, one]
        if kind == "wrong_length":
            return [changed(one, data=one.data[:5], dlc=5), other]
        assert kind == "foreign"
        return [one, changed(one, arbitration_id=one.arbitration_id & ~0xFF | OTHER), other]


def changed(frame: can.Message, **fields: object) -> can.Message:
    stated = {"arbitration_id": frame.arbitration_id, "data": frame.data, "is_extended_id": frame.is_extended_id}
    return can.Message(**(stated | fields))  # type: ignore[arg-type]


class Given:
    """These frames, some at a time, a millisecond apart; the clock is set back in the middle."""

    def __init__(self, frames: Sequence[can.Message], clock: ManualClock) -> None:
        self.frames, self.clock, self.passed = frames, clock, 0.0
        self.driver: CanDriver | None = None
        self.at = 0

    def monotonic(self) -> float:
        return self.passed

    def take(self, timeout_s: float) -> list[Frame]:
        some = self.frames[self.at : self.at + 97]
        if not some:
            assert self.driver is not None
            threading.Thread(target=self.driver.close).start()
            return []
        found: list[Frame] = []
        for frame in some:
            self.passed += 0.001
            self.clock.advance(0.001)
            found.append((self.passed, frame.arbitration_id, frame.is_extended_id, frame.data, True))
        if self.at <= len(self.frames) // 2 < self.at + len(some):
            self.clock.advance(-7200.0)
        self.at += len(some)
        return found

    def close(self) -> None: ...


class Stored:
    """A service that stores what it is sent."""

    def __init__(self) -> None:
        self.readings: list[dict[str, object]] = []

    def send(self, items: Sequence[Spooled]) -> None:
        self.readings += (json.loads(item.body) for item in items)

    def close(self) -> None: ...


ONE_READING = frozenset({"lost", "late", "wrong_length"})
"""Faults that cost a reading: a late one comes when its place is taken."""
ALL = ("lost", "doubled", "late", "wrong_length", "foreign")


@pytest.mark.parametrize("kinds", [*((one,) for one in ALL), ALL], ids=[*ALL, "all"])
def test_every_reading_is_stored_once_or_counted(tmp_path: Path, kinds: tuple[str, ...]) -> None:
    mapping = parse_mapping(f"node = {NODE}\n" + standard_mapping_text(("P",), j1939=True))
    sent = sensor_frames(COUNT, j1939=True)
    mine = [changed(one, arbitration_id=one.arbitration_id & ~0xFF | NODE) for one in sent]
    damaged = Damaged(mine, kinds, random.Random(3))
    assert all(count > 30 for count in damaged.counts.values())
    clock = ManualClock(START)
    given, service = Given(damaged.frames, clock), Stored()
    driver = given.driver = CanDriver(
        BusAddress("given"), mapping, clock=clock, monotonic=given.monotonic, open_with=lambda _: given
    )
    with Spool(tmp_path / "spool.db") as spool:
        totals = Bridge(
            driver,
            spool,
            service,
            stop=threading.Event(),
            clock=SystemClock(),
            rng=random.Random(1),
            report=lambda _: None,
        ).run()
        assert spool.waiting() == 0
    missed = sum(damaged.counts.get(kind, 0) for kind in ONE_READING)
    health, counts = driver.health(), driver.decoder.counts
    assert {kind: counts[kind] for kind in kinds if kind != "lost"} == {
        kind: count for kind, count in damaged.counts.items() if kind != "lost"
    }
    assert (health.missed, health.delivered) == (missed, COUNT - missed)
    assert totals.delivered == len(service.readings) == COUNT - missed
    amplitudes = [one["amplitude"] for one in service.readings]
    assert amplitudes == sorted(set(amplitudes))  # type: ignore[type-var]
    sequences = [int(str(one["sequence"])) for one in service.readings]
    assert sequences[-1] - sequences[0] + 1 == COUNT  # what was missed is a gap in the numbers
    times = [str(one["taken_at"]) for one in service.readings]
    assert times == sorted(times)
