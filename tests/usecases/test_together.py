"""Requests that come while another is stored are stored together, each with its own outcome."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from service.usecases.together import Together


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


def outcomes(first: int, others: Sequence[int]) -> tuple[Slow, list[Future[int]]]:
    """What became of the first item and of others that came while it was done."""
    slow, together = Slow(), Together[int, int]()
    with ThreadPoolExecutor(len(others) + 1) as threads:
        found = [threads.submit(together.do, first, slow)]
        assert slow.begun.wait(10)
        found += [threads.submit(together.do, item, slow) for item in others]
        while len(together._waiting) < len(others):
            threading.Event().wait(0.001)
        slow.go.set()
    return slow, found


def test_those_who_come_meanwhile_are_done_together() -> None:
    slow, found = outcomes(1, [2, 3, 4])
    assert [one.result() for one in found] == [2, 4, 6, 8]
    assert slow.batches == [[1], [2, 3, 4]]


def test_a_refusal_is_told_to_whom_it_concerns() -> None:
    _, (_, good, refused) = outcomes(1, [5, 13])
    assert good.result() == 10
    with pytest.raises(ValueError, match="13"):
        refused.result()


def test_what_breaks_a_batch_is_told_to_all_of_it() -> None:
    _, (first, *others) = outcomes(1, [5, 99])
    assert first.result() == 2
    for one in others:
        with pytest.raises(OSError, match="the disk is full"):
            one.result()


def test_alone_there_is_nobody_to_wait_for() -> None:
    slow = Slow()
    slow.go.set()
    together = Together[int, int]()
    assert [together.do(item, slow) for item in (1, 2)] == [2, 4]
    assert slow.batches == [[1], [2]]
