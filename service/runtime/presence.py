"""Whether the client of a request is still there, asked from the thread that computes for it."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from typing import Protocol

from anyio import from_thread

LOOK_EVERY_S = 0.25
"""A look goes through the event loop: more often it would cost what it saves."""


class Asked(Protocol):
    """A request of the web framework."""

    def is_disconnected(self) -> Awaitable[bool]:
        """Whether its connection is closed."""


class Presence:
    """Called, it says whether the client has hung up; outside a thread of the event loop's never."""

    def __init__(self, request: Asked, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._request = request
        self._monotonic = monotonic
        self._next_look = monotonic() + LOOK_EVERY_S
        self._gone = False

    def __call__(self) -> bool:
        """Look, no more often than every quarter of a second."""
        if self._gone or (now := self._monotonic()) < self._next_look:
            return self._gone
        self._next_look = now + LOOK_EVERY_S
        try:
            self._gone = bool(from_thread.run(self._look))
        except RuntimeError:  # no event loop waits for this thread: nobody can hang up
            self._next_look = float("inf")
        return self._gone

    async def _look(self) -> bool:
        return await self._request.is_disconnected()
