"""Group commit: small concurrent requests share one unit of work.

The first caller does the work of all who have come meanwhile, and hands the next batch to the first who came while
he did it. There is no pause: a request that is alone is done at once. Requests of an event loop wait in no thread: one
thread does their batches, and one call wakes all whose batch is done.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Generic, TypeVar

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")
Batch = Callable[[Sequence[Item]], Sequence[Outcome | Exception]]


class GroupCommit(Generic[Item, Outcome]):
    """Gathers items while a batch is under way and does them as the next batch.

    A `batch` is handed all items that wait and answers each; what it raises itself is raised to all of them, and where
    it is `hopeless` to those as well who have come meanwhile: they would only wait for the same.
    """

    def __init__(self, hopeless: Callable[[Exception], bool] = lambda _: False) -> None:
        self._hopeless = hopeless
        self._door = threading.Lock()
        self._waiting: list[_Waiting[Item, Outcome]] = []
        self._under_way = False
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="together")

    def do(self, item: Item, batch: Batch[Item, Outcome]) -> Outcome:
        """The outcome of an item, done in this thread or waited for; an exception among the outcomes is raised."""
        called = threading.Event()
        mine = _Waiting[Item, Outcome](item, called.set)
        if not self._enters(mine):
            called.wait()
        if not mine.outcome:
            self._do_all(batch)
        (found,) = mine.outcome
        if isinstance(found, Exception):
            raise found
        return found

    async def done(self, item: Item, batch: Batch[Item, Outcome]) -> Outcome:
        """As `do`, for a request of an event loop."""
        loop = asyncio.get_running_loop()
        mine = _Waiting[Item, Outcome](item, lambda: self._thread.submit(self._do_all, batch), loop)
        if self._enters(mine):
            mine.lead()
        return await mine.answer

    def _enters(self, mine: _Waiting[Item, Outcome]) -> bool:
        """Let an item in; True where it finds no batch under way, and has to lead the next."""
        with self._door:
            self._waiting.append(mine)
            leads, self._under_way = not self._under_way, True
        return leads

    def _do_all(self, batch: Batch[Item, Outcome]) -> None:
        with self._door:
            waiting, self._waiting = self._waiting, []
        outcomes: Sequence[Outcome | Exception]
        try:
            outcomes = batch([one.item for one in waiting])
            _require_whole(waiting, outcomes)
        except Exception as broken:
            if self._hopeless(broken):
                with self._door:
                    waiting, self._waiting = [*waiting, *self._waiting], []
            outcomes = [broken] * len(waiting)
        except BaseException:
            # The process is told to end: who waits must not take his item for done.
            outcomes = [RuntimeError("the service is stopping")] * len(waiting)
            raise
        finally:
            _tell(waiting, outcomes)
            self._hand_on()

    def _hand_on(self) -> None:
        with self._door:
            following = next(iter(self._waiting), None)
            self._under_way = following is not None
        if following is not None:
            following.lead()


class _Waiting(Generic[Item, Outcome]):
    """An item, and its outcome once there is one. lead: the waiting thread must do the next batch."""

    def __init__(self, item: Item, lead: Callable[[], object], loop: asyncio.AbstractEventLoop | None = None) -> None:
        self.item = item
        self.lead = lead
        self.loop = loop
        self.outcome: list[Outcome | Exception] = []
        if loop is not None:
            self.answer: asyncio.Future[Outcome] = loop.create_future()


def _require_whole(waiting: Sequence[object], outcomes: Sequence[object]) -> None:
    if len(outcomes) != len(waiting):
        raise RuntimeError(f"{len(outcomes)} outcomes of {len(waiting)} items")


def _tell(waiting: Sequence[_Waiting[Item, Outcome]], outcomes: Sequence[Outcome | Exception]) -> None:
    of_loops: dict[asyncio.AbstractEventLoop, list[_Waiting[Item, Outcome]]] = {}
    for one, outcome in zip(waiting, outcomes, strict=True):
        one.outcome.append(outcome)
        if one.loop is None:
            one.lead()  # it sees that there is nothing left to do
        else:
            of_loops.setdefault(one.loop, []).append(one)
    for loop, told in of_loops.items():
        with suppress(RuntimeError):  # the loop is over, and nobody waits in it any more
            loop.call_soon_threadsafe(_answer, told)


def _answer(told: Sequence[_Waiting[Item, Outcome]]) -> None:
    """Within the loop: set the answers that are still waited for."""
    for one in told:
        if one.answer.done():  # cancelled
            continue
        (found,) = one.outcome
        if isinstance(found, Exception):
            one.answer.set_exception(found)
        else:
            one.answer.set_result(found)
