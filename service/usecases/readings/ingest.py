"""Readings from bridges: stored once however often they are sent."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext

from db.bulk_insert import NewReading
from db.database import is_deadlock
from db.rows import BalancerAnswerRow, ReadingRow
from db.store import Store
from drivers.reading import Reading
from service.errors import InvalidInput, TooLarge, Unavailable
from service.model.base import YEARS, document
from service.runtime.context import Work, again_after_deadlock
from service.usecases.readings.routing import Targets, reused

FEW = 50
"""Up to so many readings in a request share a unit of work with those of other requests."""


@document
class Receipt:
    """What became of readings sent in bulk."""

    accepted: int
    """Readings stored now."""
    duplicates: int
    """Readings that were stored before, with the same contents."""


def ingest(work: Work, readings: Sequence[Reading]) -> Receipt:
    """Store readings, all or none; a repeated (source, sequence) with the same contents counts as a duplicate.

    Raises NotFound for an unknown session or an unbound source, InvalidInput for an unknown sensor, Conflict where a
    source and a session belong to different machines or a sequence number comes back with other contents, and TooLarge
    for too long a list.
    """
    _require_length(work, readings)
    receipt: Receipt
    if len(readings) > FEW or work.joined is not None:
        # A unit of work that is joined has begun: who waits within it would keep others from ending theirs.
        turn = work.long_list if work.joined is None else nullcontext()
        with turn, work.write() as store:
            receipt = _stored(Targets(store), readings)
    else:
        receipt = work.together.do((work, readings), _store_few)
    return _counted(work, readings, receipt)


async def ingest_few(work: Work, readings: Sequence[Reading]) -> Receipt:
    """As `ingest`, for a request of an event loop whose readings are no long list: it waits in no thread."""
    _require_length(work, readings)
    return _counted(work, readings, await work.together.done((work, readings), _store_few))


def _require_length(work: Work, readings: Sequence[Reading]) -> None:
    if len(readings) > work.max_readings:
        raise TooLarge(
            f"{len(readings)} readings in one request; {work.max_readings} are the most",
            value=len(readings),
            advice="send them in smaller batches",
        )


def _counted(work: Work, readings: Sequence[Reading], receipt: Receipt) -> Receipt:
    work.meters.stored(receipt.accepted, receipt.duplicates, {(r.source, r.sequence) for r in readings})
    return receipt


@again_after_deadlock
def _store_few(batches: Sequence[tuple[Work, Sequence[Reading]]]) -> list[Receipt | Exception]:
    """Store batches of several requests in one unit of work, each whole or not at all."""
    work, first = batches[0]
    if len(batches) == 1:
        with work.write() as store:
            return [_stored(Targets(store), first)]
    if {other.actor for other, _ in batches} == {work.actor} and _store_new(work, [r for _, rs in batches for r in rs]):
        return [Receipt(accepted=len(readings), duplicates=0) for _, readings in batches]
    outcomes: dict[int, Receipt | Exception] = {}
    with work.write() as store:
        targets = Targets(store)
        # In one order in every process, so that two that store the same readings do not wait for each other.
        for index in sorted(range(len(batches)), key=lambda index: _lowest(batches[index][1])):
            other, readings = batches[index]
            try:
                with store.part(other.actor):
                    outcomes[index] = _stored(targets, readings)
            except Exception as refused:
                if is_deadlock(refused):
                    raise
                outcomes[index] = refused
    return [outcomes[index] for index in range(len(batches))]


def _lowest(readings: Sequence[Reading]) -> tuple[str, int]:
    return min(((reading.source, reading.sequence) for reading in readings), default=("", 0))


def _store_new(work: Work, readings: Sequence[Reading]) -> bool:
    """Store readings that are all in order and all new, which most are; else nothing, and False."""
    try:
        with work.write() as store:
            if _stored(Targets(store), readings).duplicates:
                raise _NotNew
    except Unavailable:
        raise
    except Exception:  # whatever it is, each request is to be told its own
        return False
    return True


class _NotNew(Exception):
    """Some of the readings are stored already; undoes the unit of work."""


def _stored(targets: Targets, readings: Sequence[Reading]) -> Receipt:
    rows: dict[tuple[str, int], NewReading] = {}
    targets.expect({reading.source for reading in readings})
    for index, reading in enumerate(readings):
        row = _row(targets, reading, index)
        key = (reading.source, reading.sequence)
        if rows.setdefault(key, row) != row:
            raise reused(key, f"[{index}].sequence")
    accepted = targets.store.add_readings(list(rows.values()))
    if accepted < len(rows):
        # Only now is it worth looking: what was stored before must have been the same.
        _check_same(targets.store, rows)
    return Receipt(accepted=accepted, duplicates=len(readings) - accepted)


def highest_sequence(work: Work, source: str) -> int:
    """The highest number stored of a source, of readings or answers; -1 for none."""
    with work.read() as store:
        return max(store.highest_sequence(ReadingRow, source), store.highest_sequence(BalancerAnswerRow, source))


def _row(targets: Targets, reading: Reading, index: int) -> NewReading:
    if reading.taken_at.tzinfo is None:
        raise InvalidInput(
            "the time has no zone",
            field=f"[{index}].taken_at",
            value=reading.taken_at.isoformat(),
            advice="send the time as RFC 3339 with its zone, such as 2026-03-01T12:00:00Z",
        )
    if reading.taken_at.year not in YEARS:
        raise InvalidInput(
            f"the year {reading.taken_at.year} is not within {YEARS.start} and {YEARS.stop - 1}",
            field=f"[{index}].taken_at",
            value=reading.taken_at.isoformat(),
            advice="set the clock of the source, and send the reading with the time it was taken at",
        )
    return NewReading(
        reading.source,
        reading.sequence,
        targets.of_reading(reading, index),
        reading.session_id,
        reading.taken_at,
        reading.sensor,
        reading.amplitude,
        reading.phase_deg,
        reading.speed_rpm,
        reading.scatter,
        reading.overall_rms,
    )


def _check_same(store: Store, rows: dict[tuple[str, int], NewReading]) -> None:
    for key, stored in store.known(ReadingRow, list(rows)).items():
        # The machine is not sent: a source that was moved since still sent the same reading.
        sent = rows[key]._replace(machine_id=stored.machine_id)
        if any(getattr(stored, name) != value for name, value in sent._asdict().items()):
            raise reused(key, "sequence")
