"""One look that many follow: what is shown of a session is read once, however many watch it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Hashable
from contextlib import aclosing, asynccontextmanager, suppress
from typing import Any, Generic, TypeVar

Value = TypeVar("Value")


class Feed(Generic[Value]):
    """The latest of values that come one after another."""

    def __init__(self) -> None:
        self.version = 0
        """How many came so far, the end among them."""
        self.followers = 0
        self._latest: list[Value] = []
        self._failure: Exception | None = None
        self._told = asyncio.Event()

    @property
    def value(self) -> Value:
        """The latest. Raises what ended the feed; LookupError before the first."""
        if self._failure is not None:
            raise self._failure
        if not self._latest:
            raise LookupError("nothing came yet")
        return self._latest[0]

    async def next(self, seen: int, patience_s: float) -> int:
        """Wait for a version other than `seen`, no longer than `patience_s`; returns the present one."""
        if self.version == seen:
            with suppress(TimeoutError):
                await asyncio.wait_for(self._told.wait(), patience_s)
        return self.version

    async def run(self, values: AsyncGenerator[Value]) -> None:
        """Take values until they end."""
        try:
            async with aclosing(values):
                async for value in values:
                    self._latest[:] = [value]
                    self._tell()
            self._failure = LookupError("the feed has ended")
        except Exception as failed:
            self._failure = failed
        self._tell()

    def _tell(self) -> None:
        self.version += 1
        told, self._told = self._told, asyncio.Event()
        told.set()


class Feeds(Generic[Value]):
    """Feeds by key, each kept for as long as somebody follows it; of one event loop."""

    def __init__(self) -> None:
        self._feeds: dict[Hashable, tuple[Feed[Value], asyncio.Task[None]]] = {}

    @asynccontextmanager
    async def following(self, key: Hashable, values: Callable[[], AsyncGenerator[Value]]) -> AsyncIterator[Feed[Value]]:
        """The feed under a key within a block; made of `values` where no one follows it yet, or it has ended."""
        held = self._feeds.get(key)
        if held is None or held[1].done():
            feed = Feed[Value]()
            held = self._feeds[key] = feed, asyncio.create_task(feed.run(values()))
        feed, task = held
        feed.followers += 1
        try:
            yield feed
        finally:
            feed.followers -= 1
            if not feed.followers:
                task.cancel()
                if self._feeds.get(key) is held:
                    del self._feeds[key]


def feeds_of(state: Any) -> Feeds[Any]:
    """The feeds of an application, kept in its state."""
    if not hasattr(state, "feeds"):
        state.feeds = Feeds()
    feeds: Feeds[Any] = state.feeds
    return feeds
