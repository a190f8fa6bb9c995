"""Wait for a change notification, whichever process made the change."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Iterable
from contextlib import suppress

from service.runtime.context import AppContext

SOONEST_S = 0.2
"""A source delivers many times a second; no one can read more than a few changes in it."""
LATEST_S = 1.0
"""Look this often without any word: a notice may have been lost with a connection."""


async def news(
    work: AppContext, topics: Iterable[str], *, soonest_s: float = SOONEST_S, latest_s: float = LATEST_S
) -> AsyncGenerator[None]:
    """One turn whenever something may have been stored of these machines or sessions (keys), without end.

    A turn comes no sooner than `soonest_s` after the one before, and after `latest_s` without any word.
    """
    loop = asyncio.get_running_loop()
    told = asyncio.Event()

    def wake() -> None:
        if not loop.is_closed():
            loop.call_soon_threadsafe(told.set)

    with work.database.notices.waiting(topics, wake):
        while True:
            await asyncio.sleep(soonest_s)
            with suppress(TimeoutError):
                await asyncio.wait_for(told.wait(), latest_s - soonest_s)
            told.clear()
            yield
