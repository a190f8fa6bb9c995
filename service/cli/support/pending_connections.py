"""Connections on which no whole request has come yet: this many are kept, then the oldest make room."""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Callable
from typing import Protocol

MAX_OF_ADDRESS = 200
MAX_IN_ALL = 400
"""systemd gives a service 1,024 descriptors unless its unit says more."""
TOLD_EVERY_S = 10.0
_log = logging.getLogger("drumtrue.connections")


class Connection(Protocol):
    """One that can be ended."""

    def give_up(self) -> None:
        """End it without a word."""
        ...


class PendingConnections:
    """Bounds what somebody without a token can hold open. monotonic: s, for how often a line is written to the log."""

    def __init__(
        self, monotonic: Callable[[], float], *, of_address: int = MAX_OF_ADDRESS, in_all: int = MAX_IN_ALL
    ) -> None:
        self._monotonic, self._of_address, self._in_all = monotonic, of_address, in_all
        self._all: OrderedDict[Connection, str] = OrderedDict()
        self._by_address: dict[str, OrderedDict[Connection, None]] = {}
        self._ended, self._told_at = 0, -TOLD_EVERY_S

    def __len__(self) -> int:
        return len(self._all)

    def add(self, connection: Connection, address: str) -> None:
        """Count a connection of an address; its oldest, or the oldest of all, is ended where there are too many."""
        self._all[connection] = address
        mine = self._by_address.setdefault(address, OrderedDict())
        mine[connection] = None
        if len(mine) > self._of_address:
            self._end(next(iter(mine)))
        elif len(self._all) > self._in_all:
            self._end(next(iter(self._all)))

    def discard(self, connection: Connection) -> None:
        """Forget one that has sent its request, or has gone."""
        address = self._all.pop(connection, None)
        if address is not None:
            mine = self._by_address[address]
            del mine[connection]
            if not mine:
                del self._by_address[address]

    def count_late(self, address: str) -> None:
        """One was ended since its request did not come in time."""
        self._ended += 1
        now = self._monotonic()
        if now - self._told_at >= TOLD_EVERY_S:
            _log.warning(
                "%d connections ended on which no whole request came, the last of them from %s", self._ended, address
            )
            self._ended, self._told_at = 0, now

    def _end(self, connection: Connection) -> None:
        address = self._all[connection]
        self.discard(connection)
        self.count_late(address)
        connection.give_up()
