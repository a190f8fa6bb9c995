"""What many follow is made once, and only for as long as somebody follows it."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator

import pytest

from service.runtime.shared_feed import Feeds

PATIENCE_S = 10.0


class Made:
    """A source of numbers that comes on when it is told."""

    def __init__(self, fails_at: int = 10**9) -> None:
        self.made = self.begun = self.ended = 0
        self.on = asyncio.Event()
        self._fails_at = fails_at

    async def values(self) -> AsyncGenerator[int]:
        self.begun += 1
        try:
            while True:
                self.made += 1
                if self.made >= self._fails_at:
                    raise ValueError("gone")
                yield self.made
                await self.on.wait()
                self.on.clear()
        finally:
            self.ended += 1


def test_fifty_followers_see_each_value_of_one_source() -> None:
    async def all_of_it() -> None:
        source, feeds = Made(), Feeds[int]()

        async def follow() -> list[int]:
            seen: list[int] = []
            version = 0
            async with feeds.following("a", source.values) as feed:
                while len(seen) < 3:
                    version = await feed.next(version, PATIENCE_S)
                    seen.append(feed.value)
            return seen

        async def lead() -> None:
            for _ in range(3):
                await asyncio.sleep(0.01)
                source.on.set()

        *seen, _ = await asyncio.gather(*(follow() for _ in range(50)), lead())
        assert all(one == [1, 2, 3] for one in seen)
        await asyncio.sleep(0)
        assert (source.begun, source.made <= 4) == (1, True)
        for _ in range(10):
            await asyncio.sleep(0)
        assert source.ended == 1

    asyncio.run(all_of_it())


def test_the_last_to_leave_ends_it_and_the_next_begins_anew() -> None:
    async def all_of_it() -> None:
        source, feeds = Made(), Feeds[int]()
        for turn in (1, 2):
            async with feeds.following("a", source.values) as feed:
                assert await feed.next(0, PATIENCE_S) == 1
                assert await feed.next(1, 0.001) == 1  # nothing came
            for _ in range(10):
                await asyncio.sleep(0)
            assert (source.begun, source.ended) == (turn, turn)

    asyncio.run(all_of_it())


def test_what_ends_a_feed_is_told_to_all_and_the_next_follower_begins_anew() -> None:
    async def all_of_it() -> None:
        source, feeds = Made(fails_at=2), Feeds[int]()
        async with feeds.following("a", source.values) as one, feeds.following("a", source.values) as other:
            assert one is other
            await one.next(0, PATIENCE_S)
            source.on.set()
            assert await one.next(1, PATIENCE_S) == 2
            for feed in (one, other):
                with pytest.raises(ValueError, match="gone"):
                    _ = feed.value
            async with feeds.following("a", source.values) as fresh:
                assert fresh is not one

    asyncio.run(all_of_it())
