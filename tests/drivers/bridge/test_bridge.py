"""The bridge: nothing lost, nothing doubled, while either side fails; loud and bounded where there is no room."""

from __future__ import annotations

import json
import random
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import httpx2
import pytest

from drivers import reading
from drivers.base import BaseDriver
from drivers.bridge.bridge import Bridge
from drivers.bridge.delivery import Backoff, HttpSender, Patience, Sender
from drivers.bridge.http import HttpOut
from drivers.bridge.read_buffer import Intake
from drivers.bridge.spool import Spool, Spooled
from drivers.clock import ManualClock
from drivers.errors import BrokenSource, BusUnavailable, DeliveryFailed, DeliveryGivenUp, DeliveryRefused
from drivers.reading import Answer, Mark, Reading
from tests.drivers.answering import answering
from tests.support.drivers.frames import START, readings
from tests.support.drivers.listed import Listed


class Service:
    """Stores each (source, sequence) once; `answer` may fail a request before or after it was stored."""

    def __init__(self, answer: Callable[[int], Exception | None] = lambda _: None, *, after: bool = False) -> None:
        self._answer, self._after = answer, after
        self.calls = 0
        self.stored: list[int] = []
        self.seen: Counter[int] = Counter()
        self.largest = 0
        self.closed = False

    def send(self, items: Sequence[Spooled]) -> None:
        self.calls += 1
        self.largest = max(self.largest, len(items))
        error = self._answer(self.calls)
        if error is None or self._after:
            for item in items:
                self.seen[item.sequence] += 1
                if self.seen[item.sequence] == 1:
                    self.stored.append(item.sequence)
        if error is not None:
            raise error

    def close(self) -> None:
        self.closed = True


def bridge(
    driver: BaseDriver,
    spool: Spool,
    service: Sender,
    lines: list[str],
    *,
    live: bool = False,
    stop_at: str = "never",
    patience: Patience | None = None,
) -> Bridge:
    stop = threading.Event()

    def report(line: str) -> None:
        lines.append(line)
        if stop_at in line:
            stop.set()

    return Bridge(
        driver,
        spool,
        service,
        stop=stop,
        clock=ManualClock(),
        rng=random.Random(1),
        report=report,
        live=live,
        batch_size=100,
        patience=patience,
    )


def test_everything_arrives_once_in_order_and_the_spool_is_empty(tmp_path: Path) -> None:
    service, lines = Service(), list[str]()
    with Spool(tmp_path / "s") as spool:
        carried = bridge(Listed(readings(1234)), spool, service, lines)
        assert carried.status() == "taken 0, waiting 0, delivered 0, service not asked yet"
        totals = carried.run()
        assert spool.waiting() == 0
    assert service.stored == list(range(1, 1235))
    assert (totals.taken, totals.kept, totals.delivered, totals.overflowed) == (1234, 1234, 1234, 0)
    assert service.largest <= 100
    assert service.closed
    assert lines[-1] == "taken 1234, waiting 0, delivered 1234, service answers"


@pytest.mark.parametrize("after", [False, True], ids=["request lost", "answer lost"])
def test_a_link_that_fails_half_the_time_loses_and_doubles_nothing(tmp_path: Path, after: bool) -> None:
    draw = random.Random(7)
    service = Service(lambda _: DeliveryFailed("away") if draw.random() < 0.5 else None, after=after)
    with Spool(tmp_path / "s") as spool:
        totals = bridge(Listed(readings(1000)), spool, service, []).run()
    assert service.stored == list(range(1, 1001))
    assert totals.delivered == 1000
    assert totals.retries > 0
    assert (max(service.seen.values()) > 1) == after


def test_a_bridge_that_is_stopped_while_the_service_is_away_goes_on_from_its_spool(tmp_path: Path) -> None:
    away, lines = Service(lambda _: DeliveryFailed("cable out")), list[str]()
    with Spool(tmp_path / "s") as spool:
        first = bridge(Listed(readings(500)), spool, away, lines, stop_at="500 waiting")
        first.run()
        assert spool.waiting() == 500
    assert "service away: cable out; next attempt in" in lines[0]
    back = Service()
    with Spool(tmp_path / "s") as spool:
        bridge(Listed(readings(520)), spool, back, []).run()
    assert back.stored == list(range(1, 521))


def test_what_the_service_will_never_take_is_set_aside_and_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    class Picky(Service):
        def send(self, items: Sequence[Spooled]) -> None:
            if any(item.sequence in (17, 300) for item in items):
                raise DeliveryRefused("sensor is unknown", status=422, detail="")
            super().send(items)

    service, lines = Picky(), list[str]()
    with Spool(tmp_path / "s") as spool:
        totals = bridge(Listed(readings(500)), spool, service, lines).run()
        assert [(sequence, reason) for _, sequence, reason in spool.aside()] == [
            (17, "sensor is unknown"),
            (300, "sensor is unknown"),
        ]
    assert service.stored == [one for one in range(1, 501) if one not in (17, 300)]
    assert (totals.delivered, totals.set_aside) == (498, 2)
    assert lines.count("SET ASIDE: sensor is unknown") == 2


def test_a_source_that_is_bound_to_no_machine_waits_until_it_is(tmp_path: Path) -> None:
    service = Service(lambda call: DeliveryRefused("not bound", status=404, detail="") if call < 4 else None)
    lines: list[str] = []
    with Spool(tmp_path / "s") as spool:
        totals = bridge(Listed(readings(50)), spool, service, lines).run()
        assert spool.aside() == []
    assert (totals.delivered, totals.retries) == (50, 3)
    assert "service refuses: not bound; next attempt" in lines[0]


@pytest.mark.parametrize(
    ("error", "patience", "retries"),
    [
        (DeliveryRefused("not bound", status=404, detail=""), Patience(), 0),
        (DeliveryRefused("not bound", status=404, detail=""), Patience(refused_s=3.0), 4),
        (DeliveryFailed("not now"), Patience(away_s=3.0), 4),
    ],
)
def test_a_file_is_given_up_with_what_is_left_in_the_spool(
    tmp_path: Path, error: Exception, patience: Patience, retries: int
) -> None:
    lines: list[str] = []
    with Spool(tmp_path / "s") as spool:
        one = bridge(Listed(readings(50)), spool, Service(lambda _: error), lines, patience=patience)
        with pytest.raises(DeliveryGivenUp, match=r"not .*\n  given up: 50 wait in the spool .*the same command"):
            one.run()
        assert spool.waiting() == 50
        assert one.totals.retries == retries
        again = bridge(Listed([]), spool, service := Service(), lines, patience=patience)
        assert again.run().delivered == 50
    assert service.stored == list(range(1, 51))


def test_a_full_spool_is_told_and_a_source_that_can_wait_loses_nothing(tmp_path: Path) -> None:
    lines: list[str] = []
    with Spool(tmp_path / "s", max_bytes=150_000) as spool:
        # Nothing is taken until the spool has refused.
        service = Service(lambda _: None if any("FULL" in line for line in lines) else DeliveryFailed("away"))
        totals = bridge(Listed(readings(3000)), spool, service, lines).run()
    assert service.stored == list(range(1, 3001))
    assert (totals.overflowed, totals.delivered) == (0, 3000)
    assert any(line.startswith("FULL: spool") for line in lines)


def test_a_live_source_overflows_by_the_newest_and_every_one_is_counted() -> None:
    intake = Intake(live=True, stop=threading.Event(), most=100)
    for one in readings(130):
        intake.put(one)
    assert intake.take(1000, 0.0) == readings(130)[:100]
    assert (intake.taken, intake.overflowed) == (100, 30)


def test_a_lost_bus_is_opened_again(tmp_path: Path) -> None:
    some: list[Reading | Exception] = list(readings(20))
    some.insert(5, BusUnavailable("can0 was lost."))
    driver, service, lines = Listed(some), Service(), list[str]()
    with Spool(tmp_path / "s") as spool:
        bridge(driver, spool, service, lines, live=True).run()
    assert service.stored == list(range(1, 21))
    assert driver.opened == 2
    assert "can0 was lost. Next attempt in" in lines[0]


def test_a_source_that_breaks_its_promise_ends_the_bridge_with_what_came_before_delivered(tmp_path: Path) -> None:
    service = Service()
    with Spool(tmp_path / "s") as spool, pytest.raises(BrokenSource, match="after 3"):
        bridge(Listed([*readings(3), *readings(1)]), spool, service, []).run()
    assert service.stored == [1, 2, 3]


def test_answers_go_their_own_way(tmp_path: Path) -> None:
    seen: list[tuple[str, int]] = []

    def take(request: httpx2.Request) -> httpx2.Response:
        body = json.loads(request.content)
        seen.append((request.url.path, len(body) if isinstance(body, list) else body["sequence"]))
        receipt = {"accepted": 1, "duplicates": 2} if isinstance(body, list) else {"id": "a1", "accepted": True}
        return httpx2.Response(201, json=receipt)

    client = answering(take)
    with Spool(tmp_path / "s") as spool:
        spool.put([*readings(3), Answer("can", 5, START, (("1", 1.0, 2.0),))])
        HttpSender(HttpOut("http://service.test", client=client)).send(spool.first(10))
    assert seen == [("/api/v1/readings", 3), ("/api/v1/balancer-answers", 5)]


@pytest.mark.parametrize("status", [200, 201, 204, 302, 400, 404, 409, 413, 422])
def test_what_is_no_drumtrue_has_nothing_acknowledged_and_nothing_set_aside(tmp_path: Path, status: int) -> None:
    page = httpx2.Response(status, html="<h1>Welcome to the guests' network</h1>")
    client = answering(lambda _: page)
    lines: list[str] = []
    with Spool(tmp_path / "s") as spool:
        sender = HttpSender(HttpOut("http://service.test", client=client))
        away = bridge(Listed(readings(50)), spool, sender, lines, patience=Patience(away_s=3.0))
        with pytest.raises(DeliveryGivenUp, match="no Drumtrue"):
            away.run()
        assert (spool.waiting(), spool.aside()) == (50, [])
        assert (away.totals.delivered, away.totals.set_aside) == (0, 0)
        assert "no Drumtrue" in away.status()
        back = Service()
        bridge(Listed([]), spool, back, lines).run()
    assert back.stored == list(range(1, 51))


def test_pauses_double_up_to_a_bound_with_jitter() -> None:
    backoff = Backoff(random.Random(3))
    pauses = [backoff.next_s() for _ in range(12)]
    nominal = [min(0.5 * 2**n, 30.0) for n in range(12)]
    assert all(0.5 * whole <= pause <= whole for pause, whole in zip(pauses, nominal, strict=True))
    assert len(set(pauses)) == 12
    backoff.reset()
    assert backoff.next_s() <= 0.5


def test_what_comes_behind_a_mark_waits_for_its_own_so_that_both_are_kept_together() -> None:
    intake, some = Intake(live=True, stop=threading.Event()), readings(6)
    marks = [Mark("can", count, (reading.Counter("Sensor1", count, START, 0.01),)) for count in (2, 5)]
    for one in some[:2]:
        intake.put(one)
    intake.mark(marks[0])
    for one in some[2:4]:
        intake.put(one)
    assert intake.take(100, 0.0) == [*some[:2], marks[0]]
    intake.put(some[4])
    intake.mark(marks[1])
    intake.put(some[5])
    assert intake.take(100, 0.0) == [*some[2:5], marks[1]]
    intake.end()
    assert intake.take(100, 0.0) == [some[5]]
    assert intake.taken == 6


@pytest.mark.parametrize("replaced", [False, True], ids=["deleted", "replaced"])
def test_a_spool_whose_file_is_gone_is_told(tmp_path: Path, replaced: bool) -> None:
    path = tmp_path / "spool.db"
    with Spool(path) as spool:
        carried = bridge(Listed([]), spool, Service(), [])
        assert "SPOOL GONE" not in carried.status()
        path.rename(tmp_path / "elsewhere")
        if replaced:
            path.touch()
        assert f"SPOOL GONE: {path}" in carried.status()
        (tmp_path / "elsewhere").replace(path)
        assert "SPOOL GONE" not in carried.status()
