"""Store readings from bridges, once however often they are sent."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from contextlib import nullcontext
from datetime import datetime
from typing import Annotated

from annotated_types import Len
from pydantic import Field
from sqlalchemy.exc import OperationalError

from db.bulk_insert import NewReading
from db.database import is_deadlock
from db.rows import BalancerAnswerRow, ReadingRow
from db.store import Store
from drivers.reading import NO_CLOCK, Reading
from service.errors import InvalidInput, NotFound, TooLarge, Unavailable
from service.messages import Message
from service.model.base import YEARS, Moment, Name, Reason, document, to_plain
from service.model.base import Sequence as Number
from service.runtime.context import AppContext, again_after_deadlock
from service.usecases.readings.clocks import CLOCK_AHEAD, Arrival, Observed, ahead_s
from service.usecases.readings.routing import Targets, reused

FEW = 50
"""Up to this many readings in a request share a unit of work with those of other requests."""


@document
class Receipt:
    """What became of readings sent in bulk."""

    accepted: int
    """Readings stored now."""
    duplicates: int
    """Readings that were stored before, with the same contents."""
    set_apart: Annotated[int, Field(exclude_if=lambda count: count == 0)] = 0
    """Readings among them that are dated ahead of the moment at which they came: stored with `apart` clock_ahead, and
    in no window, mean or run. Left out where there are none."""


@document
class Withdrawal:
    """Readings of a source that are to be taken out: either by their numbers, or by their times."""

    source: Name
    """The source."""
    sequences: Annotated[tuple[Number, ...], Len(1, 1000)] | None = None
    """Numbers of the readings."""
    since: Annotated[Moment | None, Field(alias="from")] = None
    """First moment, RFC 3339, as the source dated it."""
    until: Annotated[Moment | None, Field(alias="to")] = None
    """Last moment, RFC 3339, as the source dated it."""
    reason: Reason
    """Why."""


@document
class Withdrawn:
    """What became of a withdrawal."""

    withdrawn: int
    """Readings taken out now: they are kept and listed, and in no window, mean or run any more."""
    before: int
    """Readings among them that were taken out before."""


def ingest(work: AppContext, readings: Sequence[Reading], arrival: Arrival | None = None) -> Receipt:
    """Store readings, all or none; a repeated (source, sequence) with the same contents counts as a duplicate.

    arrival: when they came and were sent; None: now, by a source with the service's own clock. Readings dated further
    ahead than `work.max_ahead_s` are stored and set apart.

    Raises NotFound for an unknown session or an unbound source, InvalidInput for an unknown sensor, Conflict where a
    source and a session belong to different machines or a sequence number comes back with other contents, and TooLarge
    for too long a list.
    """
    _require_length(work, readings)
    receipt: Receipt
    arrived = arrival or _here(work)
    if len(readings) > FEW or work.joined is not None:
        # A unit of work that is joined has begun: who waits within it would keep others from ending theirs.
        turn = work.long_list if work.joined is None else nullcontext()
        with turn, work.write() as store:
            unit = _Unit(work, store)
            receipt = unit.stored(readings, arrived)
            unit.end()
    else:
        receipt = work.together.do((work, readings, arrived), _store_few)
    return _counted(work, readings, receipt)


async def ingest_few(work: AppContext, readings: Sequence[Reading], arrival: Arrival) -> Receipt:
    """As `ingest`, for a request of an event loop whose readings are no long list: it waits in no thread."""
    _require_length(work, readings)
    return _counted(work, readings, await work.together.done((work, readings, arrival), _store_few))


def withdraw(work: AppContext, request: Withdrawal) -> Withdrawn:
    """Take readings out for good: they stay stored and listed, and count for nothing. The history tells who and why.

    Raises InvalidInput unless either sequences or a time is stated, NotFound where the source has no such reading.
    """
    by_time = request.since is not None or request.until is not None
    if by_time == (request.sequences is not None):
        raise InvalidInput(Message("invalid_input.withdrawal"), field="sequences", value=None)
    with work.write() as store:
        done, before = store.withdraw(request.source, request.sequences, request.since, request.until)
        if not done + before:
            raise NotFound(Message("nothing_to_withdraw", source=request.source), field="source", value=request.source)
        stated = to_plain(request)
        del stated["source"]
        told = {name: value for name, value in stated.items() if value is not None}
        store.note_withdrawal(request.source, {**told, "readings": done})
    return Withdrawn(withdrawn=done, before=before)


def _here(work: AppContext) -> Arrival:
    now = work.now()
    return Arrival(now, now)


def _require_length(work: AppContext, readings: Sequence[Reading]) -> None:
    if len(readings) > work.max_readings:
        raise TooLarge(Message("too_large.readings", count=len(readings), most=work.max_readings), value=len(readings))


def _counted(work: AppContext, readings: Sequence[Reading], receipt: Receipt) -> Receipt:
    work.meters.stored(receipt.accepted, receipt.duplicates, {(r.source, r.sequence) for r in readings})
    return receipt


Batch = tuple[AppContext, Sequence[Reading], Arrival]
"""Of one request."""


@again_after_deadlock
def _store_few(batches: Sequence[Batch]) -> list[Receipt | Exception]:
    """Store batches of several requests in one unit of work, each whole or not at all."""
    work, first, arrived = batches[0]
    if len(batches) == 1:
        with work.write() as store:
            unit = _Unit(work, store)
            receipt = unit.stored(first, arrived)
            unit.end()
            return [receipt]
    if {other.actor for other, _, _ in batches} == {work.actor} and _store_new(work, batches):
        return [Receipt(accepted=len(readings), duplicates=0) for _, readings, _ in batches]
    outcomes: dict[int, Receipt | Exception] = {}
    with work.write() as store:
        unit = _Unit(work, store)
        # In one order in every process, so that two that store the same readings do not wait for each other.
        for index in sorted(range(len(batches)), key=lambda index: _lowest(batches[index][1])):
            other, readings, arrived = batches[index]
            try:
                with store.part(other.actor):
                    outcomes[index] = unit.stored(readings, arrived)
            except OperationalError:
                raise  # what ails the engine ails every batch: the unit tells it by name, and nothing is stored
            except Exception as refused:
                if is_deadlock(refused):
                    raise
                outcomes[index] = refused
        unit.end()
    return [outcomes[index] for index in range(len(batches))]


def _lowest(readings: Sequence[Reading]) -> tuple[str, int]:
    return min(((reading.source, reading.sequence) for reading in readings), default=("", 0))


def _store_new(work: AppContext, batches: Sequence[Batch]) -> bool:
    """Store batches that are all in order and all new, which most are; else nothing, and False."""
    try:
        with work.write() as store:
            unit = _Unit(work, store)
            rows = [row for _, readings, arrived in batches for row in unit.rows(readings, arrived)]
            if store.add_readings(rows) < len(rows) or len(rows) < sum(len(readings) for _, readings, _ in batches):
                raise _NotNew
            if apart_in(rows):
                raise _NotNew
            unit.end()
    except Unavailable:
        raise
    except Exception:  # whatever it is, each request is to be told its own
        return False
    return True


class _NotNew(Exception):
    """Some of the readings are stored already, or set apart; undoes the unit of work."""


def apart_in(rows: Sequence[NewReading]) -> int:
    """How many rows are set apart."""
    return sum(row.apart is not None for row in rows)


class _Unit:
    """Batches on their way into one unit of work; `end` is its last step."""

    def __init__(self, work: AppContext, store: Store) -> None:
        self._store, self._max_ahead_s = store, work.max_ahead_s
        self._targets, self._clocks = Targets(store), Observed(store)

    def stored(self, readings: Sequence[Reading], arrival: Arrival) -> Receipt:
        """Store a batch, all or none."""
        rows = self.rows(readings, arrival)
        accepted = self._store.add_readings(rows)
        if accepted < len(rows):
            # Only now is it worth looking: what was stored before must have been the same.
            _check_same(self._store, {(row.source, row.sequence): row for row in rows})
        return Receipt(accepted=accepted, duplicates=len(readings) - accepted, set_apart=apart_in(rows))

    def rows(self, readings: Sequence[Reading], arrival: Arrival) -> list[NewReading]:
        """Rows of a batch, one for each number; what it says of clocks is noted."""
        rows: dict[tuple[str, int], NewReading] = {}
        self._targets.expect({reading.source for reading in readings})
        delays: defaultdict[str, list[float]] = defaultdict(list)
        ahead: defaultdict[str, list[float]] = defaultdict(list)
        for index, reading in enumerate(readings):
            row = self._row(reading, index, arrival)
            key = (reading.source, reading.sequence)
            if rows.setdefault(key, row) != row:
                raise reused(key, f"[{index}].sequence")
            if row.apart is None:
                delays[row.source].append((arrival.received_at - row.taken_at).total_seconds())
            else:
                ahead[row.source].append(ahead_s(row.taken_at, arrival))
        for source in delays.keys() | ahead.keys():
            self._clocks.add(source, arrival, delays[source], ahead[source])
        return list(rows.values())

    def end(self) -> None:
        """Store what the batches said of their sources' clocks: after all readings, so that no two writers cross."""
        self._clocks.keep()

    def _row(self, reading: Reading, index: int, arrival: Arrival) -> NewReading:
        taken_at = arrival.received_at if reading.taken_at is NO_CLOCK else reading.taken_at
        _require_time(taken_at, index)
        return NewReading(
            reading.source,
            reading.sequence,
            self._targets.of_reading(reading, index),
            reading.session_id,
            taken_at,
            reading.sensor,
            reading.amplitude,
            reading.phase_deg,
            reading.speed_rpm,
            reading.scatter,
            reading.overall_rms,
            arrival.received_at,
            CLOCK_AHEAD if ahead_s(taken_at, arrival) > self._max_ahead_s else None,
        )


def highest_sequence(work: AppContext, source: str) -> int:
    """The highest number stored of a source, of readings or answers; -1 for none."""
    with work.read() as store:
        return max(store.highest_sequence(ReadingRow, source), store.highest_sequence(BalancerAnswerRow, source))


def _require_time(taken_at: datetime, index: int) -> None:
    if taken_at.tzinfo is None:
        raise InvalidInput(
            Message("invalid_input.time_without_zone"), field=f"[{index}].taken_at", value=taken_at.isoformat()
        )
    if taken_at.year not in YEARS:
        raise InvalidInput(
            Message("invalid_input.year", year=str(taken_at.year), first=str(YEARS.start), last=str(YEARS.stop - 1)),
            field=f"[{index}].taken_at",
            value=taken_at.isoformat(),
        )


_OF_THE_SERVICE = frozenset({"machine_id", "received_at", "apart"})
"""Not sent: a source that was moved since, or whose clock was set, still sent the same reading."""


def _check_same(store: Store, rows: dict[tuple[str, int], NewReading]) -> None:
    for key, stored in store.known(ReadingRow, list(rows)).items():
        sent = rows[key]._asdict()
        without_clock = sent["taken_at"] == sent["received_at"] and stored.taken_at == stored.received_at
        left = _OF_THE_SERVICE | ({"taken_at"} if without_clock else set())
        if any(getattr(stored, name) != value for name, value in sent.items() if name not in left):
            raise reused(key, "sequence")
