"""How far the counters of a source's frames were with the last reading that was stored past the spool."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Ge

from service.model.base import Moment, document


@document
class FrameCounter:
    """The counter of one message of a bus."""

    name: str
    """Message."""
    count: Annotated[int, Ge(0)]
    """Count in the last frame of it."""
    at: Moment
    """When that came."""
    period_s: float | None
    """Seconds from one frame to the next; null where too few came to tell."""
