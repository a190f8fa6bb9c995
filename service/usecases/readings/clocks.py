"""Clocks of sources: how far each is off, and when a reading was measured by the service's own clock.

A source's clock may be wrong by any amount: a small computer that has lost its battery wakes in 1970, a balancer is set
by hand. What a source says of its time is therefore held against the moment at which the service received it. A batch
states `sent_at`, or the least (received - taken) of the last minutes tells: both are the offset of the clock, and the
time on the way. The least of them is nearest to the offset, since nothing is received before it is sent.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Any

from db.rows import ReadingRow, SourceClockRow
from db.store import Store
from service.messages import Message, Quantity, render
from service.model.base import document
from service.model.message import MessageData, message_data

TOLERANCE_S = 2.0
"""A clock that is off by less is right; an offset that moves by less is steady."""
SETTLING_S = 10.0
"""An offset is relied on once it has been steady for so long: the length of the window that a run is taken from."""
STATED_SPAN_S = 10.0
GUESSED_SPAN_S = 60.0
"""The least offset is that of this span and the one before it; where times are stated little depends on luck."""
NOTED_S = 0.02
"""Less is not worth a write."""
CLOCK_AHEAD = "clock_ahead"
"""`apart` of a reading that is dated after the moment at which it came."""
_EARLIEST = datetime(1, 1, 1, tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class Arrival:
    """When a batch was received by the service's clock, and when it was sent by its source's, where that says so."""

    received_at: datetime
    sent_at: datetime | None = None


@dataclass(frozen=True, slots=True)
class SourceClock:
    """What is known of a source's clock.

    offset_s: add it to the source's times to have the service's. stated: by `sent_at`. steady_from: when it is relied
    on. ahead_s, apart_at, apart: by how much the last reading that was set apart is ahead, when it came, how many were.
    """

    offset_s: float | None = None
    stated: bool | None = None
    bucket_at: datetime | None = None
    bucket_s: float | None = None
    before_s: float | None = None
    steady_from: datetime | None = None
    ahead_s: float | None = None
    apart_at: datetime | None = None
    apart: int = 0

    def steady(self, now: datetime) -> bool:
        """Whether the offset is known and has been the same for long enough."""
        return self.steady_from is not None and now >= self.steady_from

    def used_s(self, now: datetime) -> float:
        """The offset by which times are corrected: an uncertain one never makes a reading newer than it says."""
        offset = self.offset_s or 0.0
        return offset if self.steady(now) else min(offset, 0.0)

    def seen(self, offset_s: float, at: datetime, *, stated: bool) -> SourceClock:
        """The same after another observation; itself where nothing is new."""
        if self.bucket_at is None or self.bucket_s is None or self.offset_s is None or self.stated != stated:
            sure = stated or abs(offset_s) <= TOLERANCE_S
            settled = at if sure else at + timedelta(seconds=SETTLING_S)
            fresh = replace(self, offset_s=offset_s, stated=stated, bucket_at=at, bucket_s=offset_s, before_s=None)
            return replace(fresh, steady_from=settled)
        span = STATED_SPAN_S if stated else GUESSED_SPAN_S
        if (at - self.bucket_at).total_seconds() >= span:
            found = replace(self, bucket_at=at, bucket_s=offset_s, before_s=self.bucket_s)
        elif offset_s < self.bucket_s - NOTED_S:
            found = replace(self, bucket_s=offset_s)
        else:
            return self
        least = min(one for one in (found.bucket_s, found.before_s) if one is not None)
        if abs(least - self.offset_s) > TOLERANCE_S:
            return replace(found, offset_s=least, steady_from=at + timedelta(seconds=SETTLING_S))
        return replace(found, offset_s=least)


@document
class ClockOfSource:
    """How far a source's clock is off, and what that means for its readings."""

    source: str
    """The source."""
    offset_s: float | None
    """What is added to its times to have the service's, s: above 0 its clock is behind, below it is ahead."""
    stated: bool
    """Whether the source states its clock (`sent-at`); else the least delay of its readings tells."""
    steady: bool
    """Whether the offset is known and steady: no run is taken while it is not."""
    set_apart: int
    """Readings that were set apart for being dated ahead of the moment at which they came."""
    code: str | None
    """clock_unknown, clock_unsteady, clock_ahead, clock_behind or readings_set_apart; null: nothing to say."""
    message: str | None
    """What to know of it."""
    message_data: MessageData | None = None
    """The same as key and parameters, for other languages and units."""


def of_row(row: SourceClockRow | None) -> SourceClock:
    """What is stored of a clock; of none, that nothing is known."""
    if row is None:
        return SourceClock()
    return SourceClock(**{name: getattr(row, name) for name in SourceClock.__dataclass_fields__})


def measured_at(taken_at: datetime, received_at: datetime | None, offset_s: float) -> datetime:
    """When a reading was measured by the service's clock: not after it was received."""
    if received_at is None:
        return taken_at
    late = (received_at - taken_at).total_seconds() - offset_s
    try:
        return received_at - timedelta(seconds=max(late, 0.0))
    except OverflowError:
        return _EARLIEST


def measured(row: ReadingRow, clock: SourceClock, now: datetime) -> datetime:
    """When a stored reading was measured by the service's clock."""
    return measured_at(row.taken_at, row.received_at, clock.used_s(now))


def ahead_s(taken_at: datetime, arrival: Arrival) -> float:
    """How far a reading is dated after the batch that brought it, s: by its source's own clock where that is stated."""
    return (taken_at - (arrival.sent_at or arrival.received_at)).total_seconds()


class Observed:
    """What the batches of one unit of work say of their sources' clocks, until it is stored with them."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._known: dict[str, SourceClock] = {}
        self._now: dict[str, SourceClock] = {}

    def expect(self, sources: Iterable[str]) -> None:
        """Look up what is known of these sources' clocks."""
        unknown = {source for source in sources if source not in self._known and source.isprintable()}
        if unknown:
            rows = self._store.clocks(unknown)
            self._known |= {source: of_row(rows.get(source)) for source in unknown}

    def add(self, source: str, arrival: Arrival, delays_s: Iterable[float], ahead: Iterable[float]) -> None:
        """Note a source's part of a batch: received - taken of its readings, and how far those set apart are ahead."""
        self.expect((source,))
        clock = self._now.get(source, self._known[source])
        if arrival.sent_at is not None:
            offset = (arrival.received_at - arrival.sent_at).total_seconds()
            clock = clock.seen(offset, arrival.received_at, stated=True)
        elif delays := list(delays_s):
            clock = clock.seen(min(delays), arrival.received_at, stated=False)
        if found := list(ahead):
            apart = clock.apart + len(found)
            clock = replace(clock, ahead_s=max(found), apart_at=arrival.received_at, apart=apart)
        self._now[source] = clock

    def keep(self) -> None:
        """Store what is new of them."""
        changed: dict[str, Mapping[str, Any]] = {
            source: {name: getattr(clock, name) for name in SourceClock.__dataclass_fields__}
            for source, clock in self._now.items()
            if clock != self._known[source]
        }
        if changed:
            self._store.put_clocks(changed)
            self._known |= self._now
        self._now = {}


def of_sources(store: Store, sources: Iterable[str]) -> dict[str, SourceClock]:
    """Clocks of sources by name; of one that nothing is known of, that."""
    names = set(sources)
    rows = store.clocks(names)
    return {name: of_row(rows.get(name)) for name in names}


def shown(source: str, clock: SourceClock, now: datetime) -> ClockOfSource:
    """A clock as it is told to people."""
    message = _state_of(source, clock, now)
    return ClockOfSource(
        source=source,
        offset_s=clock.offset_s,
        stated=bool(clock.stated),
        steady=clock.steady(now),
        set_apart=clock.apart,
        code=None if message is None else message.code,
        message=None if message is None else render(message),
        message_data=message_data(message),
    )


def _state_of(source: str, clock: SourceClock, now: datetime) -> Message | None:
    since = float("inf") if clock.apart_at is None else (now - clock.apart_at).total_seconds()
    if clock.ahead_s is not None and (since <= SETTLING_S or clock.offset_s is None):
        return Message("readings_set_apart", source=source, ahead=duration(clock.ahead_s))
    if clock.offset_s is None:
        return Message("clock_unknown", source=source)
    off = duration(abs(clock.offset_s))
    if not clock.steady(now):
        return Message("clock_unsteady", source=source, off=off, settling=Quantity(SETTLING_S, "s"))
    if abs(clock.offset_s) <= TOLERANCE_S:
        return None
    if clock.offset_s > 0.0:
        return Message("clock_behind", source=source, off=off)
    return Message("clock_ahead", source=source, off=off)


def duration(seconds: float) -> str:
    """A length of time in its largest whole unit: 12 s, 3 min, 5 h, 9 d."""
    for unit, size in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"
