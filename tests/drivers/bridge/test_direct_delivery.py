"""Past the spool: nothing lost and nothing doubled while the direct way fails, is slow, or breaks."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

from drivers.bridge.bridge import Bridge
from drivers.bridge.direct_delivery import Express
from drivers.bridge.spool import Spool, Spooled
from drivers.clock import ManualClock
from drivers.errors import DeliveryError, DeliveryFailed, DeliveryRefused
from drivers.reading import Answer, Counter, Entry, Mark, Reading
from tests.support.drivers.frames import START, readings
from tests.support.drivers.listed import Listed


def mark(number: int) -> Mark:
    return Mark("can", number, (Counter("Sensor1", number % 256, START, 0.01),))


class Home:
    """A database of this process: each (source, sequence) once, whichever way it comes. fail: what a call raises."""

    def __init__(self, fail: Callable[[int], Exception | None] = lambda _: None) -> None:
        self._fail = fail
        self.calls = self.spooled = 0
        self.stored: list[int] = []
        self.mark: Mark | None = None

    def store(self, entries: Sequence[Entry], mark: Mark | None) -> None:
        self.calls += 1
        if (error := self._fail(self.calls)) is not None:
            raise error
        self._keep(one.sequence for one in entries)
        self.mark = mark or self.mark

    def send(self, items: Sequence[Spooled]) -> None:
        self.spooled += len(items)
        self._keep(item.sequence for item in items)

    def _keep(self, sequences: Iterator[int]) -> None:
        self.stored += [one for one in sequences if one not in self.stored]

    def close(self) -> None:
        return


class Marking(Listed):
    """A source that tells after every tenth reading how far its counters are."""

    bridge: Bridge

    def _next(self) -> Reading | None:
        if self._last_sequence > 0 and self._last_sequence % 10 == 0:
            self.bridge.mark(mark(self._last_sequence))
        return super()._next()


def bridged(spool: Spool, home: Home, entries: Sequence[Reading | Exception]) -> Bridge:
    driver = Marking(entries)
    bridge = Bridge(
        driver,
        spool,
        home,
        stop=threading.Event(),
        clock=ManualClock(),
        rng=random.Random(1),
        report=lambda _: None,
        live=False,
        direct=home,
    )
    driver.bridge = bridge
    return bridge


def test_everything_is_stored_with_its_mark_and_nothing_touches_the_spool(tmp_path: Path) -> None:
    home = Home()
    with Spool(tmp_path / "s") as spool:
        totals = bridged(spool, home, readings(500)).run()
        assert spool.highest("can") == -1
        assert spool.mark("can") is None
    assert home.stored == list(range(1, 501))
    assert home.mark == mark(500)
    assert (totals.taken, totals.kept, totals.delivered) == (500, 0, 500)


@pytest.mark.parametrize(
    "error", [DeliveryFailed("database is locked"), DeliveryRefused("not bound", status=404, detail="")]
)
def test_a_batch_that_is_not_taken_goes_by_the_spool_and_later_ones_directly_again(
    tmp_path: Path, error: DeliveryError
) -> None:
    home = Home(lambda call: error if call == 1 else None)
    with Spool(tmp_path / "s") as spool:
        first = bridged(spool, home, readings(30))
        totals = first.run()
        assert spool.waiting() == 0
        kept = totals.kept
        assert kept > 0
        assert home.spooled == kept
        assert totals.delivered == 30
        bridged(spool, home, readings(60)[30:]).run()
    assert home.stored == list(range(1, 61))
    assert home.spooled == kept, "with an empty spool the second bridge had no need of it"


def test_while_something_waits_in_the_spool_all_goes_behind_it(tmp_path: Path) -> None:
    home = Home()
    with Spool(tmp_path / "s") as spool:
        spool.put(readings(20))
        bridge = bridged(spool, home, readings(40)[20:])
        assert not bridge._carried(readings(1)), "older ones wait"
        bridge.run()
    assert sorted(home.stored) == list(range(1, 41))


def test_a_way_that_breaks_ends_the_bridge_and_what_it_held_is_in_the_spool(tmp_path: Path) -> None:
    home = Home(lambda _: ZeroDivisionError("a fault of ours"))
    with Spool(tmp_path / "s") as spool:
        with pytest.raises(ZeroDivisionError):
            bridged(spool, home, readings(25)).run()
        assert spool.highest("can") == 25
    with Spool(tmp_path / "s") as spool:
        again = Home()
        bridged(spool, again, []).run()
    assert sorted({*home.stored, *again.stored}) == list(range(1, 26))


class Slow:
    """A way that holds a batch until it is let go."""

    def __init__(self) -> None:
        self.begun, self.go = threading.Event(), threading.Event()
        self.stored: list[Entry] = []

    def store(self, entries: Sequence[Entry], _: Mark | None) -> None:
        self.begun.set()
        assert self.go.wait(30.0)
        self.stored += entries


def test_a_batch_that_takes_too_long_is_handed_back_and_counts_once() -> None:
    way = Slow()
    batch: list[Entry | Mark] = [*readings(3), Answer("can", 1, START, (("1", 1.0, 2.0),)), mark(1)]
    express, counts = Express(way, lambda: None), list[int]()

    def deliver() -> None:
        while not counts:
            if (count := express.deliver()) is not None:
                counts.append(count)

    thread = threading.Thread(target=deliver)
    thread.start()
    while not way.begun.is_set():
        assert not express.carry(batch, 0.01), "nobody has let it go"
    way.go.set()
    thread.join()
    assert way.stored == batch[:-1], "stored in the end, as the spool will find when it sends them again"
    assert counts == [0], "the spool counts them"
    assert express.deliver() is None


def test_a_batch_that_nobody_fetched_is_taken_back() -> None:
    way = Slow()
    express = Express(way, lambda: None)
    assert not express.carry(readings(2), 0.0)
    assert express.deliver() is None
    assert not way.begun.is_set()
