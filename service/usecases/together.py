"""Many small requests in one unit of work: a commit is what costs, and it costs the same for one reading as for fifty.

Whoever comes first does the work of all who have come meanwhile; the others wait for him. There is no thread of its own
and no pause: a request that is alone is done at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")


class Together(Generic[Item, Outcome]):
    """Gathers items while a batch is under way and does them as the next batch."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._door = threading.Lock()
        self._waiting: list[_Waiting[Item, Outcome]] = []

    def do(self, item: Item, batch: Callable[[Sequence[Item]], Sequence[Outcome | Exception]]) -> Outcome:
        """The outcome of an item; an exception among the outcomes is raised to him whose item it was.

        `batch` is handed all items that wait and answers each; what it raises itself is raised to all of them.
        """
        mine = _Waiting[Item, Outcome](item)
        with self._door:
            self._waiting.append(mine)
        with self._turn:
            if not mine.outcome:
                self._do_all(batch)
        found = mine.outcome[0]
        if isinstance(found, Exception):
            raise found
        return found

    def _do_all(self, batch: Callable[[Sequence[Item]], Sequence[Outcome | Exception]]) -> None:
        with self._door:
            waiting, self._waiting = self._waiting, []
        outcomes: Sequence[Outcome | Exception]
        try:
            outcomes = batch([one.item for one in waiting])
        except Exception as broken:
            outcomes = [broken] * len(waiting)
        except BaseException:
            # The process is told to end: who waits must not take his item for done.
            outcomes = [RuntimeError("the service is stopping")] * len(waiting)
            raise
        finally:
            for one, outcome in zip(waiting, outcomes, strict=True):
                one.outcome.append(outcome)


class _Waiting(Generic[Item, Outcome]):
    """An item, and its outcome once there is one."""

    def __init__(self, item: Item) -> None:
        self.item = item
        self.outcome: list[Outcome | Exception] = []
