"""The spool: each reading once, in order, over any number of ends; full means refused, never broken."""

from __future__ import annotations

import json
import sqlite3
from collections import deque
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from drivers.bridge.spool import ANSWER, READING, Spool
from drivers.errors import InvalidSetting, SpoolFull, SpoolUnusable
from drivers.reading import Answer, Counter, Entry, Mark
from drivers.reading_json import reading_to_dict
from tests.support.drivers.frames import START, readings
from tests.support.drivers.full_disk import no_small_disk, run_on_small_disk


def test_entries_come_out_as_they_went_in(tmp_path: Path) -> None:
    some = readings(5)
    answer = Answer("can", 7, START, (("1", 170.2, 70.0),))
    with Spool(tmp_path / "deep" / "spool.db") as spool:
        assert spool.put([*some, answer]) == 6
        found = spool.first(100)
    assert [json.loads(one.body) for one in found[:5]] == [reading_to_dict(one) for one in some]
    assert [one.kind for one in found] == [READING] * 5 + [ANSWER]
    assert json.loads(found[5].body)["masses"] == [{"plane": "1", "mass_g": 170.2, "angle_deg": 70.0}]


def test_what_was_acknowledged_and_comes_again_is_not_kept_again(tmp_path: Path) -> None:
    some = readings(10)
    with Spool(tmp_path / "spool.db") as spool:
        spool.put(some)
        spool.done(spool.first(6))
    with Spool(tmp_path / "spool.db") as spool:
        assert spool.waiting() == 4
        assert spool.put(some) == 0
        assert spool.put([replace(some[0], source="other")]) == 1
        assert [one.sequence for one in spool.first(100)] == [7, 8, 9, 10, 1]
        assert (spool.highest("can"), spool.highest("other"), spool.highest("none")) == (10, 1, -1)


def fill(spool: Spool) -> None:
    for start in range(1, 100_000, 50):
        spool.put(readings(50, first=start))


def test_a_full_spool_refuses_the_new_and_keeps_the_old(tmp_path: Path) -> None:
    with Spool(tmp_path / "spool.db", max_bytes=200_000) as spool:
        with pytest.raises(SpoolFull, match="nothing new is kept until"):
            fill(spool)
        kept = spool.waiting()
        assert kept > 300
        assert [one.sequence for one in spool.first(10**6)] == list(range(1, kept + 1))
        spool.done(spool.first(100))
        assert spool.put(readings(50, first=kept + 1)) == 50
    assert sum(one.stat().st_size for one in tmp_path.iterdir()) < 2 * 200_000
    with sqlite3.connect(tmp_path / "spool.db") as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    database.close()


def test_set_aside_and_sent_again(tmp_path: Path) -> None:
    with Spool(tmp_path / "spool.db") as spool:
        spool.put(readings(3))
        spool.set_aside(spool.first(3)[1], "sensor unknown")
        assert [one.sequence for one in spool.first(9)] == [1, 3]
        assert spool.aside() == [("can", 2, "sensor unknown")]
        assert spool.send_again() == 1
        assert [one.sequence for one in spool.first(9)] == [1, 2, 3]
        assert spool.waiting() == 3


def test_a_spool_that_cannot_be_used_is_told_in_words(tmp_path: Path) -> None:
    (tmp_path / "text").write_bytes(b"this is no database, whatever else it may be" * 100)
    with pytest.raises(SpoolUnusable, match=r"text cannot be used .*not a database"):
        Spool(tmp_path / "text").open()
    with pytest.raises(SpoolUnusable, match="cannot be used"):
        Spool(tmp_path / "text" / "below").open()
    with Spool(tmp_path / "one") as held:
        held.put(readings(1))
        with pytest.raises(SpoolUnusable, match="is another bridge using it"):
            Spool(tmp_path / "one").open()
    with pytest.raises(SpoolUnusable, match="not open"):
        held.first(1)
    with pytest.raises(InvalidSetting):
        Spool(tmp_path / "two", max_bytes=1000)


def test_a_spool_of_a_later_format_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "spool.db"
    with sqlite3.connect(path) as database:
        database.execute("PRAGMA user_version=9")
    database.close()
    with pytest.raises(SpoolUnusable, match="format 9"):
        Spool(path).open()


def test_a_spool_of_the_first_format_is_gone_on_with(tmp_path: Path) -> None:
    path = tmp_path / "spool.db"
    with Spool(path) as spool:
        spool.put([*readings(2), Mark("can", 7, (Counter("Sensor1", 9, START, None),))])
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("ALTER TABLE counter DROP COLUMN mark")
        database.execute("PRAGMA user_version=1")
    for _ in range(2):
        with Spool(path) as spool:
            assert spool.waiting() == 2
            assert spool.mark("can") == Mark("can", 0, (Counter("Sensor1", 9, START, None),))


@pytest.mark.skipif(no_small_disk() is not None, reason=no_small_disk() or "")
def test_a_spool_that_fills_its_own_disk_is_emptied_again_and_goes_on(tmp_path: Path) -> None:
    seen = json.loads(run_on_small_disk(tmp_path))
    first, opened, *later = seen["kept"]
    assert first == opened
    assert min(first, *later[2::3]) > 10, "there is room whenever all is delivered"
    assert seen["delivered"] == list(range(1, first + sum(later[:-1]) + 1))
    assert seen["highest"] == first + sum(later)
    assert seen["mark"]


class SpoolAgainstList(RuleBasedStateMachine):
    """Puts, repeats, acknowledgements and ends in any order, against a plain queue."""

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(self.make_folder())
        self.spool = Spool(self.folder / "spool.db", most_held=25)
        self.spool.open()
        self.model: deque[int] = deque()
        self.next = 1

    @staticmethod
    def make_folder() -> str:
        import tempfile

        return tempfile.mkdtemp()

    @rule(count=st.integers(1, 20), again=st.integers(0, 10))
    def put(self, count: int, again: int) -> None:
        first = max(1, self.next - again)
        entries = readings(self.next + count - first, first=first)
        assert self.spool.put(entries) == count
        self.model.extend(range(self.next, self.next + count))
        self.next += count

    @rule(count=st.integers(1, 30))
    def acknowledge(self, count: int) -> None:
        items = self.spool.first(count)
        assert [one.sequence for one in items] == list(self.model)[:count]
        self.spool.done(items)
        for _ in items:
            self.model.popleft()

    @precondition(lambda self: self.model)
    @rule()
    def set_aside(self) -> None:
        self.spool.set_aside(self.spool.first(1)[0], "no")
        self.model.popleft()

    @rule()
    def close_and_open(self) -> None:
        self.spool.close()
        self.spool.open()

    @invariant()
    def same(self) -> None:
        assert self.spool.waiting() == len(self.model)

    def teardown(self) -> None:
        import shutil

        assert [one.sequence for one in self.spool.first(10**6)] == list(self.model)
        self.spool.close()
        shutil.rmtree(self.folder)


TestSpoolAgainstList = SpoolAgainstList.TestCase
TestSpoolAgainstList.settings = settings(max_examples=15, stateful_step_count=20, deadline=None)


def test_it_comes_back_as_itself_whether_still_at_hand_or_from_the_disk(tmp_path: Path) -> None:
    entries: list[Entry] = [*readings(3), Answer("can", 7, START, (("1", 170.2, 70.0),))]
    with Spool(tmp_path / "spool.db") as spool:
        spool.put(entries)
        assert [one.entry() for one in spool.first(9)] == entries
    with Spool(tmp_path / "spool.db") as spool:
        assert [one.held for one in spool.first(9)] == [None] * 4
        assert [one.entry() for one in spool.first(9)] == entries


def test_the_newest_mark_of_each_source_is_kept_with_what_came_before_it(tmp_path: Path) -> None:
    def mark(source: str, count: int) -> Mark:
        return Mark(source, count, (Counter("Sensor1", count, START, 0.01), Counter("Speed", count + 1, START, None)))

    with Spool(tmp_path / "spool.db") as spool:
        assert spool.put([mark("can", 3), *readings(2), mark("can", 5), mark("other", 9)]) == 2
    with Spool(tmp_path / "spool.db") as spool:
        assert spool.mark("can") == mark("can", 5)
        assert spool.mark("other") == mark("other", 9)
        assert spool.mark("none") is None
