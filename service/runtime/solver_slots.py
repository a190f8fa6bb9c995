"""Limit concurrent selections in a process, so that ingest stays responsive."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from service.errors import Unavailable
from service.messages import Message

WAIT_S = 5.0
"""How long a selection waits for its turn; most take a tenth of a second."""
MAX_WAITING = 16
"""Waiting requests hold a thread each: above this number the next is refused at once, so that others find one."""
RETRY_AFTER_S = 2


class SolverSlots:
    """Turns to compute, safe between threads. at_once: how many at a time; None: one a core, two at least."""

    def __init__(self, at_once: int | None = None, *, wait_s: float = WAIT_S) -> None:
        self.at_once = at_once or max(2, os.cpu_count() or 1)
        self._wait_s = wait_s
        self._free = threading.Semaphore(self.at_once)
        self._queue = threading.Semaphore(MAX_WAITING)

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Have a turn for the length of the block. Raises Unavailable (`too_many_solves`) where none comes in time."""
        if not self._free.acquire(blocking=False):
            self._wait()
        try:
            yield
        finally:
            self._free.release()

    def _wait(self) -> None:
        if self._queue.acquire(blocking=False):
            try:
                if self._free.acquire(timeout=self._wait_s):
                    return
            finally:
                self._queue.release()
        raise Unavailable(Message("too_many_solves", slots=self.at_once), retry_after_s=RETRY_AFTER_S)
