"""Readings and balancer answers from bridges: stored once however often they are sent."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from datetime import datetime
from typing import Any

from db.bulk import NewReading
from db.documents.base import YEARS, document
from db.documents.findings import Findings
from db.documents.machine import Machine
from db.documents.run import BalancerAnswer
from db.rows import BalancerAnswerRow, MachineRow, ReadingRow, SessionRow, SourceRow
from db.store import Store
from drivers.reading import Reading
from service.errors import Conflict, DrumtrueError, InvalidInput, NotFound, TooLarge
from service.usecases import states
from service.usecases.rules import check_masses, sensor_index
from service.usecases.work import Work, require

FEW = 50
"""Up to so many readings in a request share a unit of work with those of other requests."""


@document
class Receipt:
    """What became of readings sent in bulk."""

    accepted: int
    """Readings stored now."""
    duplicates: int
    """Readings that were stored before, with the same contents."""


@document
class Source:
    """A source of readings and the machine it is mounted on."""

    name: str
    """Name of the source."""
    machine_id: str
    """Machine."""
    bound_at: datetime
    """When it was bound, UTC."""


@document
class StoredReading:
    """A raw reading as it is stored, until it is rolled up."""

    source: str
    """Who measured."""
    sequence: int
    """Its number."""
    machine_id: str
    """Machine it belongs to."""
    session_id: str | None
    """Session it was sent for; null for a source that is bound to the machine."""
    taken_at: datetime
    """When it was taken, UTC."""
    sensor: str
    """Sensor."""
    amplitude: float
    """1x amplitude, in the sensor's quantity, unit and detection."""
    phase_deg: float | None
    """1x phase, degrees, in the machine's phase sense."""
    speed_rpm: float | None
    """Speed, r/min."""
    scatter: float | None
    """Standard deviation of the 1x vector per real component, in the amplitude's unit."""
    overall_rms: float | None
    """Broadband value, rms, in the sensor's unit."""
    findings: Findings | None
    """What the signal chain found beside it, where it was measured from a block of waveforms."""


@document
class StoredAnswer:
    """A balancer's answer as it is stored."""

    id: str
    """Identifier, for a correction of source balancer."""
    session_id: str | None
    """Session it is meant for."""
    accepted: bool
    """False: it was stored before."""


def bind(work: Work, name: str, machine_id: str) -> Source:
    """Bind a source to the machine it is mounted on. Raises NotFound."""
    with work.write() as store:
        require(store, MachineRow, machine_id)
        row = store.get(SourceRow, name)
        if row is None:
            row = SourceRow(name=name, machine_id=machine_id, bound_at=work.now())
            store.add(row)
        else:
            row.machine_id, row.bound_at = machine_id, work.now()
        return Source(name=row.name, machine_id=row.machine_id, bound_at=row.bound_at)


def sources(work: Work) -> tuple[Source, ...]:
    """Bound sources, by name."""
    with work.read() as store:
        return tuple(Source(name=r.name, machine_id=r.machine_id, bound_at=r.bound_at) for r in store.sources())


def of_source(
    work: Work, name: str, since: datetime | None, until: datetime | None, limit: int, offset: int
) -> tuple[StoredReading, ...]:
    """Raw readings of a bound source with what was found beside them, newest first. Raises NotFound, InvalidInput."""
    if since is not None and until is not None and since > until:
        raise InvalidInput(
            "the first moment lies after the last", field="from", value=since.isoformat(), advice="swap from and to"
        )
    with work.read() as store:
        require(store, SourceRow, name)
        rows = store.readings_of(name, since, until, limit, offset)
        found = store.findings(name, [row.sequence for row in rows])
        columns = [column for column in StoredReading.__dataclass_fields__ if column != "findings"]
        return tuple(
            StoredReading(**{name: getattr(row, name) for name in columns}, findings=found.get(row.sequence))
            for row in rows
        )


def ingest(work: Work, readings: Sequence[Reading]) -> Receipt:
    """Store readings, all or none; a repeated (source, sequence) with the same contents counts as a duplicate.

    Raises NotFound for an unknown session or an unbound source, InvalidInput for an unknown sensor, Conflict where a
    source and a session belong to different machines or a sequence number comes back with other contents, and TooLarge
    for too long a list.
    """
    if len(readings) > work.max_readings:
        raise TooLarge(
            f"{len(readings)} readings in one request; {work.max_readings} are the most",
            value=len(readings),
            advice="send them in smaller batches",
        )
    receipt: Receipt
    if len(readings) > FEW or work.joined is not None:
        # A unit of work that is joined has begun: who waits within it would keep others from ending theirs.
        turn = work.long_list if work.joined is None else nullcontext()
        with turn, work.write() as store:
            receipt = _stored(_Targets(store), readings)
    else:
        receipt = work.together.do((work, readings), _store_few)
    work.meters.stored(receipt.accepted, receipt.duplicates, {(r.source, r.sequence) for r in readings})
    return receipt


def _store_few(batches: Sequence[tuple[Work, Sequence[Reading]]]) -> list[Receipt | Exception]:
    """Store batches of several requests in one unit of work, each whole or not at all."""
    work, first = batches[0]
    if len(batches) == 1:
        with work.write() as store:
            return [_stored(_Targets(store), first)]
    if {other.actor for other, _ in batches} == {work.actor} and _store_new(work, [r for _, rs in batches for r in rs]):
        return [Receipt(accepted=len(readings), duplicates=0) for _, readings in batches]
    outcomes: list[Receipt | Exception] = []
    with work.write() as store:
        targets = _Targets(store)
        for other, readings in batches:
            try:
                with store.part(other.actor):
                    outcomes.append(_stored(targets, readings))
            except Exception as refused:
                outcomes.append(refused)
    return outcomes


def _store_new(work: Work, readings: Sequence[Reading]) -> bool:
    """Store readings that are all in order and all new, which most are; else nothing, and False."""
    try:
        with work.write() as store:
            if _stored(_Targets(store), readings).duplicates:
                raise _NotNew
    except (DrumtrueError, _NotNew):
        return False
    return True


class _NotNew(Exception):
    """Some of the readings are stored already; undoes the unit of work."""


def _stored(targets: _Targets, readings: Sequence[Reading]) -> Receipt:
    rows: dict[tuple[str, int], NewReading] = {}
    for index, reading in enumerate(readings):
        row = _row(targets, reading, index)
        key = (reading.source, reading.sequence)
        if rows.setdefault(key, row) != row:
            raise _reused(key, f"[{index}].sequence")
    accepted = targets.store.add_readings(list(rows.values()))
    if accepted < len(rows):
        # Only now is it worth looking: what was stored before must have been the same.
        _check_same(targets.store, rows)
    return Receipt(accepted=accepted, duplicates=len(readings) - accepted)


def highest_sequence(work: Work, source: str) -> int:
    """The highest number stored of a source, of readings or answers; -1 for none."""
    with work.read() as store:
        return max(store.highest_sequence(ReadingRow, source), store.highest_sequence(BalancerAnswerRow, source))


def machine_behind(store: Store, source: str, session_id: str | None) -> Machine:
    """The machine that readings of this source and session belong to. Raises NotFound and Conflict as `ingest` does."""
    targets = _Targets(store)
    machine: Machine = targets.machine(targets.machine_of(source, session_id, "session_id"))
    return machine


def ingest_answer(work: Work, answer: BalancerAnswer) -> StoredAnswer:
    """Store a balancer's answer once. Raises as `ingest` does."""
    with work.write() as store:
        targets = _Targets(store)
        machine_id = targets.machine_of(answer.source, answer.session_id, "session_id")
        check_masses(targets.machine(machine_id), answer.masses)
        session_id = answer.session_id or next((s.id for s in store.open_sessions(machine_id)), None)
        key = (answer.source, answer.sequence)
        stored = store.known(BalancerAnswerRow, [key]).get(key)
        if isinstance(stored, BalancerAnswerRow):
            same_session = answer.session_id in (None, stored.session_id)
            if not same_session or (stored.taken_at, stored.masses) != (answer.taken_at, answer.masses):
                raise _reused(key, "sequence")
            return StoredAnswer(id=stored.id, session_id=stored.session_id, accepted=False)
        row = BalancerAnswerRow(
            id=work.new_id(),
            source=answer.source,
            sequence=answer.sequence,
            machine_id=machine_id,
            session_id=session_id,
            taken_at=answer.taken_at,
            masses=answer.masses,
        )
        store.add(row)
        return StoredAnswer(id=row.id, session_id=session_id, accepted=True)


class _Targets:
    """Which machine a reading belongs to, looked up once per source and session."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self._of: dict[tuple[str, str | None], str] = {}
        self._of_sensor: dict[tuple[str, str | None, str], str] = {}

    def of_reading(self, reading: Reading, index: int) -> str:
        """The machine, once source, session and sensor are known to fit; thousands of readings ask for the same."""
        key = (reading.source, reading.session_id, reading.sensor)
        found = self._of_sensor.get(key)
        if found is None:
            _check_source(reading.source, f"[{index}].source")
            found = self.machine_of(reading.source, reading.session_id, f"[{index}].session_id")
            sensor_index(self.machine(found), reading.sensor, f"[{index}].sensor")
            self._of_sensor[key] = found
        return found

    def machine_of(self, source: str, session_id: str | None, field: str) -> str:
        key = (source, session_id)
        if key not in self._of:
            self._of[key] = self._look_up(source, session_id, field)
        return self._of[key]

    def machine(self, machine_id: str) -> Any:
        return require(self.store, MachineRow, machine_id).spec

    def _look_up(self, source: str, session_id: str | None, field: str) -> str:
        bound = self.store.get(SourceRow, source)
        if session_id is None:
            if bound is None:
                raise NotFound(
                    f"source {source!r} is bound to no machine",
                    code="source_not_bound",
                    field=field,
                    value=source,
                    advice="bind it to its machine (page Sources, or PUT /sources/{name}), or state the session_id",
                )
            return bound.machine_id
        session = require(self.store, SessionRow, session_id)
        states.after(session, "run")
        if bound is not None and bound.machine_id != session.machine_id:
            raise Conflict(
                f"source {source!r} is bound to another machine than session {session_id}",
                code="source_of_other_machine",
                field=field,
                value=session_id,
                advice="leave session_id out, or bind the source to the session's machine",
            )
        return session.machine_id


def _row(targets: _Targets, reading: Reading, index: int) -> NewReading:
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
            raise _reused(key, "sequence")


def _check_source(source: str, field: str) -> None:
    """Refuse what a Reading's type lets pass and no table takes: a name with control signs."""
    if not source.isprintable():
        raise InvalidInput(
            "the name of the source holds signs that cannot be printed",
            field=field,
            value=source,
            advice="name the source in letters, figures and signs",
        )


def _reused(key: tuple[str, int], field: str) -> Conflict:
    return Conflict(
        f"source {key[0]!r} used sequence {key[1]} before, with other contents",
        code="sequence_reused",
        field=field,
        value=key[1],
        advice="a source counts on from its last number; give a restarted source a new name",
    )
