"""Requests that come while another is stored are stored together, each with its own outcome."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from service.runtime.group_commit import GroupCommit


class Slow:
    """Doubles numbers, refuses 13, and breaks at 99; the first batch waits until it is let go."""

    def __init__(self) -> None:
        self.batches: list[list[int]] = []
        self.begun, self.go = threading.Event(), threading.Event()

    def __call__(self, items: Sequence[int]) -> list[int | Exception]:
        self.batches.append(sorted(items))
        self.begun.set()
        assert self.go.wait(10)
        if 99 in items:
            raise OSError("the disk is full")
        return [ValueError(item) if item == 13 else 2 * item for item in items]


WAYS = ("thread", "loop")


def outcomes(first: tuple[str, int], *others: tuple[str, int]) -> tuple[Slow, list[Future[int]]]:
    """What became of the first item and of others that came while it was done; each in a thread or in a loop."""
    slow, together, loop = Slow(), GroupCommit[int, int](), asyncio.new_event_loop()

    def come(way: str, item: int) -> Future[int]:
        if way == "loop":
            return asyncio.run_coroutine_threadsafe(together.done(item, slow), loop)
        return threads.submit(together.do, item, slow)

    with ThreadPoolExecutor(len(others) + 2) as threads:
        threads.submit(loop.run_forever)
        found = [come(*first)]
        assert slow.begun.wait(10)
        found += [come(*other) for other in others]
        while len(together._waiting) < len(others):
            threading.Event().wait(0.001)
        slow.go.set()
        for one in found:
            one.exception(10)
        loop.call_soon_threadsafe(loop.stop)
    loop.close()
    return slow, found


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("others", [("loop", "loop", "loop"), ("thread", "loop", "thread"), ("loop", "thread", "loop")])
def test_those_who_come_meanwhile_are_done_together(way: str, others: tuple[str, ...]) -> None:
    slow, found = outcomes((way, 1), *zip(others, (2, 3, 4), strict=True))
    assert [one.result() for one in found] == [2, 4, 6, 8]
    assert slow.batches == [[1], [2, 3, 4]]


@pytest.mark.parametrize("way", WAYS)
def test_a_refusal_is_told_to_whom_it_concerns(way: str) -> None:
    _, (_, good, refused) = outcomes((way, 1), (way, 5), (way, 13))
    assert good.result() == 10
    with pytest.raises(ValueError, match="13"):
        refused.result()


@pytest.mark.parametrize("way", WAYS)
def test_what_breaks_a_batch_is_told_to_all_of_it(way: str) -> None:
    _, (first, *others) = outcomes((way, 1), (way, 5), (way, 99))
    assert first.result() == 2
    for one in others:
        with pytest.raises(OSError, match="the disk is full"):
            one.result()


def test_alone_there_is_nobody_to_wait_for() -> None:
    slow = Slow()
    slow.go.set()
    together = GroupCommit[int, int]()
    assert [together.do(item, slow) for item in (1, 2)] == [2, 4]
    assert slow.batches == [[1], [2]]


def test_an_outcome_too_few_is_told_to_all() -> None:
    def forgetful(_items: Sequence[int]) -> list[int | Exception]:
        return []

    with pytest.raises(RuntimeError, match="0 outcomes of 1 items"):
        GroupCommit[int, int]().do(1, forgetful)


def test_a_request_that_is_given_up_leaves_the_others_their_turn() -> None:
    async def two() -> int:
        slow, together = Slow(), GroupCommit[int, int]()
        given_up = asyncio.create_task(together.done(1, slow))
        await asyncio.sleep(0)
        given_up.cancel()
        other = asyncio.create_task(together.done(2, slow))
        await asyncio.sleep(0)
        slow.go.set()
        return await other

    assert asyncio.run(two()) == 4


@pytest.mark.parametrize("way", WAYS)
def test_under_many_requests_each_is_done_once(way: str) -> None:
    seen: list[int] = []

    def batch(items: Sequence[int]) -> list[int | Exception]:
        seen.extend(items)
        return [2 * item for item in items]

    together = GroupCommit[int, int]()

    async def in_a_loop() -> list[int]:
        return list(await asyncio.gather(*(together.done(item, batch) for item in range(300))))

    with ThreadPoolExecutor(9) as threads:
        looped = threads.submit(asyncio.run, in_a_loop()) if way == "loop" else None
        found = list(threads.map(lambda item: together.do(item, batch), range(300, 600)))
        assert found == [2 * item for item in range(300, 600)]
        assert looped is None or looped.result() == [2 * item for item in range(300)]
    assert sorted(seen) == list(range(0 if looped else 300, 600))


def test_what_is_hopeless_for_one_batch_is_told_to_those_who_wait_for_the_next() -> None:
    slow, together = Slow(), GroupCommit[int, int](lambda error: isinstance(error, OSError))
    with ThreadPoolExecutor(3) as threads:
        first = threads.submit(together.do, 99, slow)
        assert slow.begun.wait(10)
        others = [threads.submit(together.do, item, slow) for item in (1, 2)]
        while len(together._waiting) < len(others):
            threading.Event().wait(0.001)
        slow.go.set()
        for one in (first, *others):
            assert isinstance(one.exception(10), OSError)
    assert slow.batches == [[99]]
    assert together.do(3, slow) == 6
