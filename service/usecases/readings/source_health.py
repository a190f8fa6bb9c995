"""Health of the sources: last reading, rate and missing sequence numbers."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from itertools import pairwise

from db.queries.readings import LatestOf
from service.model.base import document
from service.runtime.context import AppContext
from service.usecases.readings.clocks import ClockOfSource, SourceClock, measured_at, of_sources, shown
from service.usecases.readings.sources import Source, bound

LOOKED_AT = 200
"""This many of the latest readings and answers tell of a source."""


@document
class SourceHealth(Source):
    """A source, and how well it was heard of late."""

    newest_at: datetime | None
    """When its newest reading or answer was taken by the service's clock, UTC; null before the first."""
    looked_at: int
    """How many of its latest readings and answers the rest is about."""
    rate_hz: float | None
    """Readings and answers a second over those; null for fewer than two, or where all have one time."""
    missing: int
    """Numbers left out between the lowest and the highest of them: sent, or to be sent, and not here."""
    longest_gap_s: float | None
    """Longest time without any between two of them, s; null for fewer than two."""
    clock: ClockOfSource
    """How far its clock is off."""


def health(work: AppContext, looked_at: int = LOOKED_AT) -> tuple[SourceHealth, ...]:
    """Bound sources with how well they are heard, by name; looked_at: by this many of their latest readings."""
    mounted = bound(work)
    with work.read() as store:
        latest = [store.latest_of(source.name, looked_at) for source in mounted]
        clocks = of_sources(store, [source.name for source in mounted])
    now = work.now()
    return tuple(_of(source, found, clocks[source.name], now) for source, found in zip(mounted, latest, strict=True))


def _of(source: Source, found: Sequence[LatestOf], clock: SourceClock, now: datetime) -> SourceHealth:
    """Health from numbers and times, the highest number first; what is set apart has a number and no time."""
    offset = clock.used_s(now)
    times = sorted(measured_at(one.taken_at, one.received_at, offset) for one in found if one.apart is None)
    span = (times[-1] - times[0]).total_seconds() if times else 0.0
    return SourceHealth(
        **vars(source),
        newest_at=times[-1] if times else None,
        looked_at=len(found),
        rate_hz=(len(times) - 1) / span if span > 0.0 else None,
        missing=found[0].sequence - found[-1].sequence + 1 - len({one.sequence for one in found}) if found else 0,
        longest_gap_s=max(((b - a).total_seconds() for a, b in pairwise(times)), default=None),
        clock=shown(source.name, clock, now),
    )


def metrics(work: AppContext) -> bytes:
    """Everything counted and how the sources are, in Prometheus' text format."""
    heard = health(work, looked_at=1)
    now = work.now()
    lags = {one.name: (now - one.newest_at).total_seconds() for one in heard if one.newest_at is not None}
    offsets = {one.name: one.clock.offset_s for one in heard if one.clock.offset_s is not None}
    apart = {one.name: one.clock.set_apart for one in heard}
    return work.meters.text(lags, work.listeners.states(), offsets_s=offsets, apart=apart)
