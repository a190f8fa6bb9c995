"""A source that gives what it is handed."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.base import BaseDriver
from drivers.reading import Reading


class Listed(BaseDriver):
    """Gives a list of readings; an error in the list is raised in its place."""

    def __init__(self, entries: Sequence[Reading | Exception]) -> None:
        super().__init__("can", sequence_start=0)
        self._entries = list(reversed(entries))
        self.opened = 0

    def _connect(self) -> None:
        self.opened += 1

    def _next(self) -> Reading | None:
        if not self._entries:
            return None
        entry = self._entries.pop()
        if isinstance(entry, Exception):
            raise entry
        return entry
