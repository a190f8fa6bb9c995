"""Bounded queue between the thread that reads and the one that spools."""

from __future__ import annotations

import threading
from collections import deque

from drivers.reading import Answer, Mark, Reading

MAX_WAITING = 100_000


class Intake:
    """A queue that never blocks a live source: what finds no place is lost and counted. Others wait for a place."""

    def __init__(self, *, live: bool, stop: threading.Event, most: int = MAX_WAITING) -> None:
        self._live, self._stop, self._most = live, stop, most
        self._entries: deque[Reading | Answer | Mark] = deque()
        self._changed = threading.Condition()
        self.taken = 0
        self.overflowed = 0
        self.ended = False

    def put(self, entry: Reading | Answer) -> None:
        """Add one."""
        # No lock on this way: a deque is safe between one thread that appends and one that takes.
        while len(self._entries) >= self._most:
            if self._live or self._stop.is_set():
                self.overflowed += 1
                return
            with self._changed:
                self._changed.wait(0.05)
        self.taken += 1
        self._entries.append(entry)

    def mark(self, mark: Mark) -> None:
        """Add how far the counters are, behind all that was put before."""
        self._entries.append(mark)

    def take(self, most: int, patience_s: float) -> list[Reading | Answer | Mark]:
        """Take up to `most`; waits patience_s where there is nothing, and returns an empty list.

        What was put behind the last mark that is found waits for its own, so that both are kept together.
        """
        if not self._entries and not self.ended:
            self._stop_or_pause(patience_s)
        found: list[Reading | Answer | Mark] = []
        marked = 0
        while self._entries and len(found) < most:
            entry = self._entries.popleft()
            found.append(entry)
            if isinstance(entry, Mark):
                marked = len(found)
        if marked and not self.ended:
            self._entries.extendleft(reversed(found[marked:]))
            del found[marked:]
        return found

    def lose(self, count: int) -> None:
        """Count some that were taken and could not be kept."""
        self.overflowed += count

    def end(self) -> None:
        """Nothing more will be put."""
        self.ended = True

    def _stop_or_pause(self, seconds: float) -> None:
        with self._changed:
            self._changed.notify_all()
            self._changed.wait(seconds)
