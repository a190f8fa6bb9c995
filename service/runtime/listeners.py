"""The buses that the service itself listens to: whether each is read, and what its frames were refused for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from service.model.base import document

State = Literal["listening", "reopening", "restarting"]


@document
class ListenerState:
    """A bus that is read into the database as a source."""

    source: str
    """Name of the source."""
    state: State
    """listening; reopening: the bus was lost and is opened again; restarting: its reader ended and is started again."""
    reason: str | None
    """What was lost or ended, as text; null while it is read."""
    reopened: int
    """How often the bus was opened again."""
    restarts: int
    """How often its reader was started again."""
    refused: dict[str, int]
    """Frames without a reading, by reason."""


class Listeners:
    """Those of one process, by source."""

    def __init__(self) -> None:
        self._looks: dict[str, Callable[[], ListenerState]] = {}

    def add(self, source: str, look: Callable[[], ListenerState]) -> None:
        """From now on this source is asked."""
        self._looks[source] = look

    def remove(self, source: str) -> None:
        """It is listened to no more."""
        self._looks.pop(source, None)

    def states(self) -> tuple[ListenerState, ...]:
        """How each is now, by source."""
        return tuple(look() for _, look in sorted(self._looks.items()))
