"""Clocks of sources: whatever a source says of its time, nothing old is taken for new."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.app import PREFIX
from service.model.run import MassOnRotor
from service.model.stop import StopRequest
from service.usecases.readings import source_health
from service.usecases.readings.clocks import SETTLING_S, TOLERANCE_S, SourceClock, duration, measured_at, shown
from service.usecases.sessions import live, stops
from service.usecases.sessions.live import Live
from tests.support.http.workshop import Workshop

NOW = datetime(2026, 1, 1, tzinfo=UTC)
YEARS_S = 10 * 365.25 * 86_400.0
AHEAD_S = 60.0


class Source:
    """A source on a machine with a session, whose clock is off by so many seconds (above 0: ahead)."""

    def __init__(self, shop: Workshop, off_s: float = 0.0, *, states: bool = True) -> None:
        self.shop, self.off_s, self.states = shop, off_s, states
        machine = shop.machine()
        self.name = f"source {machine}"
        shop.ask("PUT", f"/sources/{self.name}", {"machine_id": machine})
        self.session = shop.session(machine)
        self.sequence = 0

    def measure(self, count: int = 6, amplitude: float = 3.0, age_s: float = 0.0) -> list[dict[str, Any]]:
        """Readings of both sensors that were taken just now, as the source dates them."""
        taken = self.shop.now.clock.now() + timedelta(seconds=self.off_s - age_s)
        out = []
        for n in range(count):
            for sensor in ("P", "Q"):
                self.sequence += 1
                moment = taken - timedelta(seconds=0.2 * (count - n))
                one: dict[str, Any] = {"source": self.name, "sequence": self.sequence, "taken_at": moment.isoformat()}
                out.append(
                    {**one, "sensor": sensor, "amplitude": amplitude + 1e-4 * n, "phase_deg": 20.0, "speed_rpm": 460.0}
                )
        return out

    def send(self, readings: list[dict[str, Any]]) -> dict[str, Any]:
        """The receipt."""
        said = (self.shop.now.clock.now() + timedelta(seconds=self.off_s)).isoformat()
        answer = self.shop.client.post(
            f"{PREFIX}/readings", json=readings, headers={"sent-at": said} if self.states else {}
        )
        assert answer.status_code == 201, answer.text
        found: dict[str, Any] = answer.json()
        return found

    def look(self, since: datetime | None = None) -> Live:
        return live.look(self.shop.work, self.session, since)

    def age_s(self) -> float:
        """How old the newest reading is by the service's clock."""
        seen = self.look().measured_at
        assert seen is not None
        return (self.shop.now.clock.now() - seen).total_seconds()

    def change_masses(self) -> datetime:
        """A stop for a trial mass; returns when the machine was released."""
        work = self.shop.work
        stop = stops.begin(work, self.session, StopRequest(purpose="trial", plane="1")).number
        stops.lock(work, self.session, stop)
        stops.change(work, self.session, stop, [MassOnRotor(plane="1", mass_g=50.0, angle_deg=20.0)])
        released = stops.release(work, self.session, stop).released_at
        assert released is not None
        return released


OFFSETS = [0.0, 5.0, -5.0, 40.0, 300.0, -300.0, 86_400.0, -86_400.0, YEARS_S, -YEARS_S]


@pytest.mark.parametrize("off_s", OFFSETS)
def test_after_a_stop_nothing_is_seen_until_a_reading_arrives_whatever_the_clock_says(
    shared_shop: Workshop, off_s: float
) -> None:
    source = Source(shared_shop, off_s)
    source.send(source.measure(amplitude=3.0))
    assert source.look().ready
    released = source.change_masses()
    found = source.look(released)
    assert (found.sensors, found.steady, found.ready, found.measured_at) == ((), False, False, None)
    assert live.window(shared_shop.work, source.session, released) is None
    shared_shop.now.clock.advance(30.0)
    source.send(source.measure(amplitude=5.0))
    found = source.look(released)
    assert found.ready
    assert [round(one.amplitude, 2) for one in found.sensors] == [5.0, 5.0]
    take = live.window(shared_shop.work, source.session, released)
    assert take is not None
    body = {"kind": "trial", "masses": [{"plane": "1", "mass_g": 50.0, "angle_deg": 20.0}]}
    said = {"source": take.source, "from": take.since.isoformat(), "to": take.until.isoformat()}
    assert take.received_from is not None
    said["received_from"] = take.received_from.isoformat()
    run = shared_shop.post(f"/sessions/{source.session}/runs", {**body, "take": said})
    assert [round(one["amplitude"], 2) for one in run["readings"]] == [5.0, 5.0]


@pytest.mark.parametrize("off_s", [off for off in OFFSETS if off > AHEAD_S])
def test_readings_dated_ahead_without_a_word_of_the_clock_are_set_apart(shared_shop: Workshop, off_s: float) -> None:
    source = Source(shared_shop, off_s, states=False)
    assert source.send(source.measure()) == {"accepted": 12, "duplicates": 0, "set_apart": 12}
    found = source.look()
    assert (found.sensors, found.newest_at, found.ready) == ((), None, False)
    (clock,) = found.clocks
    assert (clock.code, clock.set_apart) == ("readings_set_apart", 12)
    assert f"{duration(off_s)} ahead" in (clock.message or "")
    listed = shared_shop.get(f"/sources/{source.name}/readings")
    assert {one["apart"] for one in listed} == {"clock_ahead"}
    said = {"source": source.name, "from": "1990-01-01T00:00:00Z", "to": "2999-01-01T00:00:00Z"}
    body = {"kind": "initial", "take": said}
    shared_shop.refused("POST", f"/sessions/{source.session}/runs", body, 422, "nothing_to_take")


@pytest.mark.parametrize("off_s", [off for off in OFFSETS if abs(off) > TOLERANCE_S and off <= AHEAD_S])
def test_a_clock_that_is_off_and_does_not_say_so_is_relied_on_once_it_was_steady(
    shared_shop: Workshop, off_s: float
) -> None:
    source = Source(shared_shop, off_s, states=False)
    source.send(source.measure())
    found = source.look()
    assert (found.steady, found.ready, found.clocks[0].code) == (True, False, "clock_unsteady")
    for _ in range(4):
        shared_shop.now.clock.advance(4.0)
        source.send(source.measure())
    found = source.look()
    assert found.ready
    assert found.clocks[0].code == ("clock_ahead" if off_s > 0.0 else "clock_behind")
    assert found.clocks[0].offset_s == pytest.approx(-off_s, abs=TOLERANCE_S)
    assert 0.0 <= source.age_s() < 4.0


@pytest.mark.parametrize("states", [True, False])
@pytest.mark.parametrize("off_s", [0.0, -300.0, 30.0])
def test_a_spool_that_is_delivered_late_is_never_fresh(shared_shop: Workshop, off_s: float, states: bool) -> None:
    source = Source(shared_shop, off_s, states=states)
    spool = [source.measure(age_s=3600.0 - 60.0 * n) for n in range(6)]
    for batch in spool:
        source.send(batch)
        assert source.look().measured_at is None or source.age_s() > 3000.0 - max(off_s, 0.0)
    assert not source.look().ready or states


def test_one_reading_of_the_far_future_changes_nothing_for_those_that_follow(shared_shop: Workshop) -> None:
    source = Source(shared_shop, states=False)
    source.send(source.measure())
    (wild, *_) = source.measure(1)
    wild["taken_at"] = "2036-01-01T00:00:00Z"
    assert source.send([wild]) == {"accepted": 1, "duplicates": 0, "set_apart": 1}
    source.send(source.measure())
    found = source.look()
    assert found.ready
    assert found.newest_at is not None
    assert found.newest_at < shared_shop.now.clock.now()
    assert 0.0 <= source.age_s() < 4.0
    health = next(one for one in source_health.health(shared_shop.work) if one.name == source.name)
    assert health.longest_gap_s is not None
    assert health.longest_gap_s < 10.0
    metrics = shared_shop.client.get("/metrics").text
    assert f'drumtrue_source_readings_set_apart{{source="{source.name}"}} 1.0' in metrics


def test_a_clock_that_is_set_is_watched_before_it_is_relied_on_again(shared_shop: Workshop) -> None:
    source = Source(shared_shop, 300.0)
    source.send(source.measure())
    assert source.look().ready
    source.off_s = 0.0
    for _ in range(2):  # the span in which the least offset counts, and the one after
        shared_shop.now.clock.advance(12.0)
        source.send(source.measure())
    assert not source.look().ready
    for _ in range(2):
        shared_shop.now.clock.advance(6.0)
        source.send(source.measure())
    assert source.look().ready
    assert 0.0 <= source.age_s() < 4.0


def test_a_take_of_readings_from_before_the_release_is_refused(shared_shop: Workshop) -> None:
    source = Source(shared_shop, 40.0, states=False)
    source.send(source.measure())
    source.change_masses()
    take = {"source": source.name, "from": "2025-01-01T00:00:00Z", "to": "2100-01-01T00:00:00Z"}
    body = {"kind": "trial", "masses": [{"plane": "1", "mass_g": 50.0, "angle_deg": 20.0}], "take": take}
    shared_shop.refused("POST", f"/sessions/{source.session}/runs", body, 409, "readings_before_release")


def test_a_sender_without_a_clock_leaves_the_time_out_and_may_repeat_itself(shared_shop: Workshop) -> None:
    source = Source(shared_shop, states=False)
    batch = [{name: value for name, value in one.items() if name != "taken_at"} for one in source.measure()]
    assert source.send(batch) == {"accepted": 12, "duplicates": 0}
    shared_shop.now.clock.advance(5.0)
    assert source.send(batch) == {"accepted": 0, "duplicates": 12}
    assert source.look().ready
    changed = [{**batch[0], "amplitude": 9.0}]
    shared_shop.refused("POST", "/readings", changed, 409, "sequence_reused")
    dated = [{**batch[0], "taken_at": "2025-01-01T00:00:00Z"}]
    shared_shop.refused("POST", "/readings", dated, 409, "sequence_reused")


@pytest.mark.parametrize("by_time", [True, False])
def test_what_is_withdrawn_is_kept_and_counts_for_nothing(shared_shop: Workshop, by_time: bool) -> None:
    source = Source(shared_shop)
    wrong, right = source.measure(amplitude=9.0), source.measure(amplitude=3.0)
    for one in right:
        one["taken_at"] = (datetime.fromisoformat(one["taken_at"]) + timedelta(seconds=2.0)).isoformat()
    source.send(wrong + right)
    which: dict[str, Any] = {"sequences": [one["sequence"] for one in wrong]}
    if by_time:
        which = {"from": wrong[0]["taken_at"], "to": wrong[-1]["taken_at"]}
    body = {"source": source.name, "reason": "the sensor hung loose", **which}
    assert shared_shop.post("/readings/withdrawals", body) == {"withdrawn": 12, "before": 0}
    assert shared_shop.post("/readings/withdrawals", body) == {"withdrawn": 0, "before": 12}
    assert [round(one.amplitude, 2) for one in source.look().sensors] == [3.0, 3.0]
    take = {"source": source.name, "from": wrong[0]["taken_at"], "to": right[-1]["taken_at"]}
    run = shared_shop.post(f"/sessions/{source.session}/runs", {"kind": "initial", "take": take})
    assert [round(one["amplitude"], 2) for one in run["readings"]] == [3.0, 3.0]
    listed = shared_shop.get(f"/sources/{source.name}/readings?limit=200")
    assert sorted(one["sequence"] for one in listed if one["apart"]) == [one["sequence"] for one in wrong]
    assert source.send(wrong) == {"accepted": 0, "duplicates": 12}
    told = shared_shop.get(f"/history?kind=source&key={source.name}")[-2]
    assert (told["action"], told["changes"]["reason"], told["changes"]["readings"]) == ("withdrawn", body["reason"], 12)


@pytest.mark.parametrize("which", [{}, {"sequences": [1], "from": "2026-01-01T00:00:00Z"}])
def test_a_withdrawal_states_numbers_or_times(shared_shop: Workshop, which: dict[str, Any]) -> None:
    body = {"source": "any", "reason": "wrong", **which}
    shared_shop.refused("POST", "/readings/withdrawals", body, 422, "invalid_input")


def test_a_withdrawal_of_nothing_is_refused(shared_shop: Workshop) -> None:
    body = {"source": "nobody's", "reason": "wrong", "sequences": [1]}
    shared_shop.refused("POST", "/readings/withdrawals", body, 404, "nothing_to_withdraw")


# ------------------------------------------------------------ the rules by themselves
DATES = st.integers(-2_208_988_800, 253_370_764_800).map(
    lambda second: datetime.fromtimestamp(0, UTC) + timedelta(seconds=second)
)


@given(DATES, DATES, st.floats(-1e12, 1e12))
def test_nothing_is_measured_after_it_was_received(taken: datetime, received: datetime, offset: float) -> None:
    assert measured_at(taken, received, offset) <= received


@given(st.floats(-YEARS_S, YEARS_S), st.lists(st.floats(0.0, 1.5), min_size=20, max_size=60))
def test_a_steady_clock_is_known_to_within_what_the_way_takes(offset: float, delays: list[float]) -> None:
    clock, at = SourceClock(), NOW
    for delay in delays:
        at += timedelta(seconds=1.0)
        clock = clock.seen(offset + delay, at, stated=True)
    assert clock.steady(at)
    assert offset <= clock.used_s(at) <= offset + TOLERANCE_S


@given(st.lists(st.tuples(st.floats(0.1, 120.0), st.floats(-1e8, 1e8)), min_size=1, max_size=40), st.booleans())
def test_an_offset_that_moved_of_late_is_not_relied_on(seen: list[tuple[float, float]], stated: bool) -> None:
    clock, at, moved = SourceClock(), NOW, None
    for pause, offset in seen:
        at += timedelta(seconds=pause)
        before = clock.offset_s
        clock = clock.seen(offset, at, stated=stated)
        if before is not None and clock.offset_s is not None and abs(clock.offset_s - before) > TOLERANCE_S:
            moved = at
        if moved is not None and (at - moved).total_seconds() < SETTLING_S:
            assert not clock.steady(at)
            assert clock.used_s(at) <= 0.0


@given(st.floats(-1e12, 1e12))
def test_a_clock_is_told_with_its_code(offset: float) -> None:
    told = shown("s", SourceClock().seen(offset, NOW, stated=True), NOW)
    wanted = None if abs(offset) <= TOLERANCE_S else "clock_behind" if offset > 0.0 else "clock_ahead"
    assert told.code == wanted
    assert (told.message is None) == (wanted is None)
