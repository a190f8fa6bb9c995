"""How well the sources of readings are heard: when last, how often, and what is missing of late."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from itertools import pairwise

from service.model.base import document
from service.runtime.context import Work
from service.usecases.readings.sources import Source, bound

LOOKED_AT = 200
"""So many of the latest readings and answers tell of a source."""


@document
class SourceHealth(Source):
    """A source, and how well it was heard of late."""

    newest_at: datetime | None
    """When its newest reading or answer was taken, UTC; null before the first."""
    looked_at: int
    """How many of its latest readings and answers the rest is about."""
    rate_hz: float | None
    """Readings and answers a second over those; null for fewer than two, or where all have one time."""
    missing: int
    """Numbers left out between the lowest and the highest of them: sent, or to be sent, and not here."""
    longest_gap_s: float | None
    """Longest time without any between two of them, s; null for fewer than two."""


def health(work: Work) -> tuple[SourceHealth, ...]:
    """Bound sources with how well they are heard, by name."""
    mounted = bound(work)
    with work.read() as store:
        latest = [store.latest_of(source.name, LOOKED_AT) for source in mounted]
    return tuple(_of(source, found) for source, found in zip(mounted, latest, strict=True))


def _of(source: Source, found: Sequence[tuple[int, datetime]]) -> SourceHealth:
    """Health from numbers and times, the highest number first."""
    times = sorted(at for _number, at in found)
    span = (times[-1] - times[0]).total_seconds() if times else 0.0
    return SourceHealth(
        **vars(source),
        newest_at=times[-1] if times else None,
        looked_at=len(found),
        rate_hz=(len(times) - 1) / span if span > 0.0 else None,
        missing=found[0][0] - found[-1][0] + 1 - len({number for number, _at in found}) if found else 0,
        longest_gap_s=max(((b - a).total_seconds() for a, b in pairwise(times)), default=None),
    )
