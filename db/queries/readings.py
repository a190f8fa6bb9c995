"""Readings, balancers' answers and their sources."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from typing import Any, NamedTuple, cast

from sqlalchemy import ColumnElement, CursorResult, Select, delete, func, insert, literal, or_, select, update

from db.bulk_insert import NewReading, insert_new
from db.patience import be_patient
from db.pubsub import stream
from db.queries.base import Queries
from db.reading_batches import BATCH, Range, batch_digest, is_within, merged, ranges_of
from db.rows import (
    LIVE,
    LIVE_IN_SESSION,
    AuditRow,
    BalancerAnswerRow,
    MachineRow,
    ReadingFindingsRow,
    ReadingMinuteRow,
    ReadingRangeRow,
    ReadingRow,
    SourceClockRow,
    SourceMarkRow,
    SourceRow,
)
from db.set_apart import readable
from db.unreadable import fault_of
from service.model.counters import FrameCounter
from service.model.findings import Findings
from service.model.machine import Machine

_LOOKUP_CHUNK = 400
"""Numbers in one IN list: SQLite takes 32,766 variables, and short statements are cached."""

WITHDRAWN = "withdrawn"
"""`apart` of a reading that was taken out by hand."""

ROLLING_S = 600.0
"""How long a statement may take that rolls up an hour of readings, or waits for another that does."""
_ROLLING = 7_325_119
"""Advisory lock of PostgreSQL under which readings are rolled up."""


class LatestOf(NamedTuple):
    """What is asked of the latest readings and answers of a source."""

    sequence: int
    taken_at: datetime
    received_at: datetime | None
    apart: str | None


class Readings(Queries):
    """What sources say, as it arrives and as it grows old."""

    def sources(self) -> Sequence[SourceRow]:
        """Bound sources, by name."""
        return self._session.scalars(select(SourceRow).order_by(SourceRow.name)).all()

    def mounted(self, sources: Sequence[str]) -> dict[str, tuple[str, Machine]]:
        """Key and description of the machine of each of these sources that is bound to one."""
        found: dict[str, tuple[str, Machine]] = {}
        for start in range(0, len(sources), _LOOKUP_CHUNK):
            chunk = sources[start : start + _LOOKUP_CHUNK]
            query = select(SourceRow.name, MachineRow.id, MachineRow.spec).join(
                MachineRow, MachineRow.id == SourceRow.machine_id
            )
            rows = self._session.execute(query.where(SourceRow.name.in_(chunk)))
            found |= {name: (key, machine) for name, key, machine in rows if fault_of(machine) is None}
        return found

    def add_readings(self, rows: Sequence[NewReading]) -> int:
        """Insert readings whose (source, sequence) is not stored yet; returns how many were."""
        stream(self._session, {row.machine_id for row in rows})
        of_source: dict[str, list[NewReading]] = {}
        for row in self._not_rolled_up(rows):
            of_source.setdefault(row.source, []).append(row)
        fresh = [row for of_one in of_source.values() for row in of_one]
        added = insert_new(self._session.connection(), fresh) if fresh else 0
        if added:
            for source, sent in of_source.items():
                numbers = [row.sequence for row in sent]
                stored = sent if added == len(fresh) else self._stored(source, numbers)
                batch = {"sequences": ranges_of(numbers), "sha256": batch_digest(stored)}
                told = {"new": added, "last_sequence": sent[-1].sequence, BATCH: batch}
                self._note("sent", ReadingRow.__tablename__, source, told, chained=False)
        return added

    def _not_rolled_up(self, rows: Sequence[NewReading]) -> Sequence[NewReading]:
        """The readings whose numbers were not rolled up; others wait with that until the unit of work ends."""
        if self._session.get_bind().dialect.name == "postgresql":
            self._session.execute(select(func.pg_advisory_xact_lock_shared(_ROLLING)))
        lowest: dict[str, int] = {}
        for row in rows:
            lowest[row.source] = min(row.sequence, lowest.get(row.source, row.sequence))
        gone: dict[str, list[Range]] = {}
        kind = ReadingRangeRow
        for source, least in lowest.items():
            query = select(kind.first, kind.last).where(kind.source == source, kind.last >= least)
            if found := [(first, last) for first, last in self._session.execute(query)]:
                gone[source] = found
        return [row for row in rows if not is_within(row.sequence, gone.get(row.source, ()))] if gone else rows

    def _stored(self, source: str, numbers: Sequence[int]) -> Sequence[Any]:
        return list(self.known(ReadingRow, [(source, number) for number in numbers]).values())

    def put_mark(self, source: str, number: int, counters: tuple[FrameCounter, ...]) -> None:
        """Store how far the counters of a source's frames are, in place of what was stored before."""
        values = {"number": number, "counters": counters}
        known = update(SourceMarkRow).where(SourceMarkRow.source == source).values(values)
        if not cast("CursorResult[Any]", self._session.execute(known)).rowcount:
            self._session.execute(insert(SourceMarkRow).values(source=source, **values))

    def add_findings(self, source: str, taken_at: datetime, found: Mapping[int, Findings]) -> None:
        """Store what was found beside readings of a source, by their numbers; what is stored already stays."""
        known = self.findings(source, list(found))
        rows = [
            {"source": source, "sequence": number, "taken_at": taken_at, "findings": one}
            for number, one in found.items()
            if number not in known
        ]
        if rows:
            self._session.execute(insert(ReadingFindingsRow), rows)

    def findings(self, source: str, sequences: Sequence[int]) -> dict[int, Findings]:
        """What was found beside these readings of a source, by their numbers; most have nothing."""
        found: dict[int, Findings] = {}
        kind = ReadingFindingsRow
        for start in range(0, len(sequences), _LOOKUP_CHUNK):
            chunk = sequences[start : start + _LOOKUP_CHUNK]
            query = select(kind.sequence, kind.findings).where(kind.source == source, kind.sequence.in_(chunk))
            found |= _readable(self._session.execute(query))
        return found

    def findings_between(self, source: str, since: datetime, until: datetime) -> dict[int, Findings]:
        """What was found beside readings of a source between two times, by their numbers, in their order."""
        kind = ReadingFindingsRow
        query = select(kind.sequence, kind.findings).where(
            kind.source == source, kind.taken_at >= since, kind.taken_at <= until
        )
        return _readable(self._session.execute(query.order_by(kind.sequence)))

    def readings_of(
        self, source: str, since: datetime | None, until: datetime | None, limit: int, offset: int
    ) -> Sequence[ReadingRow]:
        """Raw readings of a source, from and until these times where they are stated; newest first."""
        query = select(ReadingRow).where(ReadingRow.source == source)
        if since is not None:
            query = query.where(ReadingRow.taken_at >= since)
        if until is not None:
            query = query.where(ReadingRow.taken_at <= until)
        return self._page(query.order_by(ReadingRow.taken_at.desc(), ReadingRow.sequence.desc()), limit, offset)

    def known(
        self, kind: type[ReadingRow | BalancerAnswerRow], keys: Sequence[tuple[str, int]]
    ) -> dict[tuple[str, int], ReadingRow | BalancerAnswerRow]:
        """The rows stored under these (source, sequence)."""
        found: dict[tuple[str, int], ReadingRow | BalancerAnswerRow] = {}
        of_source: dict[str, list[int]] = {}
        for source, sequence in keys:
            of_source.setdefault(source, []).append(sequence)
        for source, sequences in of_source.items():
            for start in range(0, len(sequences), _LOOKUP_CHUNK):
                # One source at a time: for pairs in a list SQLite takes no index, and reads the table to its end.
                chunk = sequences[start : start + _LOOKUP_CHUNK]
                query: Select[Any] = select(kind).where(kind.source == source, kind.sequence.in_(chunk))
                found.update({(row.source, row.sequence): row for row in self._session.scalars(query)})
        return found

    def received_of_source(self, source: str, machine_id: str, since: datetime, most: int) -> Sequence[ReadingRow]:
        """The readings of a source that were received last, for whatever session is open on its machine."""
        # One index gives them in order: what a machine said since its session was opened may be millions.
        query = select(ReadingRow).where(ReadingRow.source == source, LIVE, ReadingRow.machine_id == machine_id)
        return self._received(query, since, most)

    def received_for_session(self, session_id: str, since: datetime, most: int) -> Sequence[ReadingRow]:
        """The readings sent for a session that were received last."""
        query = select(ReadingRow).where(ReadingRow.session_id == session_id, LIVE_IN_SESSION)
        return self._received(query, since, most)

    def _received(self, query: Select[Any], since: datetime, most: int) -> Sequence[ReadingRow]:
        recent = query.where(ReadingRow.received_at >= since)
        return self._session.scalars(
            recent.order_by(ReadingRow.received_at.desc(), ReadingRow.id.desc()).limit(most)
        ).all()

    def latest_of(self, source: str, most: int) -> list[LatestOf]:
        """The latest readings and answers of a source, the highest number first."""
        found: list[LatestOf] = []
        # One look at the end of each index: there are few sources, and many readings.
        for kind, apart in ((ReadingRow, ReadingRow.apart), (BalancerAnswerRow, literal(None))):
            query = select(kind.sequence, kind.taken_at, kind.received_at, apart).where(kind.source == source)
            rows = self._session.execute(query.order_by(kind.sequence.desc()).limit(most))
            found += [LatestOf(*row) for row in rows]
        return sorted(found, key=lambda one: one.sequence, reverse=True)[:most]

    # ------------------------------------------------------------ clocks of sources
    def clocks(self, sources: Iterable[str]) -> dict[str, SourceClockRow]:
        """What is known of the clocks of sources, by name."""
        names, found = sorted(set(sources)), dict[str, SourceClockRow]()
        for start in range(0, len(names), _LOOKUP_CHUNK):
            query = select(SourceClockRow).where(SourceClockRow.source.in_(names[start : start + _LOOKUP_CHUNK]))
            found |= {row.source: row for row in self._session.scalars(query)}
        return found

    def put_clocks(self, values: Mapping[str, Mapping[str, Any]]) -> None:
        """Store what is known of clocks now, by source; in the order of names, so that two writers do not cross."""
        for source in sorted(values):
            known = update(SourceClockRow).where(SourceClockRow.source == source).values(values[source])
            if not cast("CursorResult[Any]", self._session.execute(known)).rowcount:
                self._session.execute(insert(SourceClockRow).values(source=source, **values[source]))

    # ------------------------------------------------------------ readings that are taken out
    def withdraw(
        self, source: str, sequences: Sequence[int] | None, since: datetime | None, until: datetime | None
    ) -> tuple[int, int]:
        """Set readings of a source apart, by number or by time; how many, and how many were withdrawn before."""
        rules: list[ColumnElement[bool]] = [] if sequences is None else [ReadingRow.sequence.in_(sequences)]
        if since is not None:
            rules.append(ReadingRow.taken_at >= since)
        if until is not None:
            rules.append(ReadingRow.taken_at <= until)
        mine = ReadingRow.source == source, *rules
        before = self._session.scalar(
            select(func.count()).select_from(ReadingRow).where(*mine, ReadingRow.apart == WITHDRAWN)
        )
        still = or_(ReadingRow.apart.is_(None), ReadingRow.apart != WITHDRAWN)
        stream(self._session, set(self._session.scalars(select(ReadingRow.machine_id).where(*mine).distinct())))
        done = self._session.execute(update(ReadingRow).where(*mine, still).values(apart=WITHDRAWN))
        return cast("CursorResult[Any]", done).rowcount, int(before or 0)

    def note_withdrawal(self, source: str, told: Mapping[str, Any]) -> None:
        """Put a withdrawal into the history, in its chain."""
        self._note("withdrawn", "source", source, told)

    def highest_sequence(self, kind: type[ReadingRow | BalancerAnswerRow], source: str) -> int:
        """The highest number stored of a source; -1 for none."""
        highest = [self._session.scalar(select(func.max(kind.sequence)).where(kind.source == source))]
        if kind is ReadingRow:
            rolled = select(func.max(ReadingMinuteRow.last_sequence)).where(ReadingMinuteRow.source == source)
            highest.append(self._session.scalar(rolled))
        return max((int(found) for found in highest if found is not None), default=-1)

    def answers(self, machine_id: str, session_id: str, limit: int, offset: int) -> Sequence[BalancerAnswerRow]:
        """Balancers' answers on a machine for a session, or for none; newest first."""
        query = (
            select(BalancerAnswerRow)
            .where(
                BalancerAnswerRow.machine_id == machine_id,
                or_(BalancerAnswerRow.session_id == session_id, BalancerAnswerRow.session_id.is_(None)),
            )
            .order_by(BalancerAnswerRow.taken_at.desc(), BalancerAnswerRow.id)
        )
        return readable(self._page(query, limit, offset))

    def readings_between(self, source: str, machine_id: str, since: datetime, until: datetime) -> Sequence[ReadingRow]:
        """Readings of a source on a machine between two times, in order of sequence; none that is set apart."""
        return self._session.scalars(
            select(ReadingRow)
            .where(
                ReadingRow.source == source,
                ReadingRow.machine_id == machine_id,
                ReadingRow.apart.is_(None),
                ReadingRow.taken_at >= since,
                ReadingRow.taken_at <= until,
            )
            .order_by(ReadingRow.sequence)
        ).all()

    # ------------------------------------------------------------ raw readings that grow old
    def sources_of_readings(self) -> Sequence[str]:
        """Names of all sources that raw readings are stored of."""
        found: list[str] = []
        query = select(ReadingRow.source).order_by(ReadingRow.source).limit(1)
        name = self._session.scalar(query)
        # From one name to the next by the index: there are few sources, and many readings.
        while name is not None:
            found.append(name)
            name = self._session.scalar(query.where(ReadingRow.source > name))
        return found

    def roll_up_alone(self) -> None:
        """Wait for others that roll up, until the unit of work ends: each reading is to go into one row only."""
        if self._session.get_bind().dialect.name == "postgresql":  # SQLite has one writer at a time anyhow
            be_patient(self._session.connection(), ROLLING_S)
            self._session.execute(select(func.pg_advisory_xact_lock(_ROLLING)))

    def oldest_reading(self, source: str) -> datetime | None:
        """When the oldest raw reading of a source was taken."""
        query = select(ReadingRow.taken_at).where(ReadingRow.source == source)
        return self._session.scalar(query.order_by(ReadingRow.taken_at).limit(1))

    def readings_before(self, source: str, until: datetime) -> Sequence[ReadingRow]:
        """Raw readings of a source from before a moment."""
        query = select(ReadingRow).where(ReadingRow.source == source, ReadingRow.taken_at < until)
        return self._session.scalars(query).all()

    def roll_up(
        self, source: str, until: datetime, readings: int, minutes: list[dict[str, Any]], forget: datetime
    ) -> None:
        """Remove raw readings of a source from before a moment, and store what is left of them.

        forget: lines of history from before it, that tell of readings sent, go too.
        """
        self._session.execute(insert(ReadingMinuteRow), minutes)
        self._remember_numbers(source, until)
        self._session.execute(delete(ReadingRow).where(ReadingRow.source == source, ReadingRow.taken_at < until))
        old = ReadingFindingsRow.source == source, ReadingFindingsRow.taken_at < until
        self._session.execute(delete(ReadingFindingsRow).where(*old))
        self._forget_arrivals(source, forget)
        if self._history is not None:
            changes = {"rolled_up_before": [None, until.isoformat()], "readings": [readings, 0]}
            self._history.note("changed", "source", source, changes)

    def _remember_numbers(self, source: str, until: datetime) -> None:
        """Keep the numbers of the raw readings of a source from before a moment, joined with those kept already."""
        query = select(ReadingRow.sequence).where(ReadingRow.source == source, ReadingRow.taken_at < until)
        if not (new := ranges_of(self._session.scalars(query))):
            return
        kind = ReadingRangeRow
        near = kind.source == source, kind.last >= new[0][0] - 1, kind.first <= new[-1][1] + 1
        kept = [(first, last) for first, last in self._session.execute(select(kind.first, kind.last).where(*near))]
        self._session.execute(delete(kind).where(*near))
        joined = merged([*kept, *new])
        self._session.execute(insert(kind), [{"source": source, "first": a, "last": b} for a, b in joined])

    def _forget_arrivals(self, source: str, until: datetime) -> None:
        """Remove the lines of history that tell of readings sent before a moment: a bridge makes a million a day."""
        lines = AuditRow.kind == ReadingRow.__tablename__, AuditRow.key == source, AuditRow.number.is_(None)
        # The history is in the order of time: the first line that stays ends the search.
        first = select(AuditRow.id).where(*lines, AuditRow.at >= until).order_by(AuditRow.id).limit(1)
        kept = self._session.scalar(first)
        gone = delete(AuditRow).where(*lines, AuditRow.at < until)
        self._session.execute(gone if kept is None else gone.where(AuditRow.id < kept))

    def rolled_up_between(self, source: str, since: datetime, until: datetime) -> datetime | None:
        """The first minute between two times of which a source's raw readings were removed."""
        query = select(ReadingMinuteRow.minute).where(
            ReadingMinuteRow.source == source,
            ReadingMinuteRow.minute >= since.replace(second=0, microsecond=0),
            ReadingMinuteRow.minute <= until,
        )
        return self._session.scalar(query.order_by(ReadingMinuteRow.minute).limit(1))

    def sources_on(self, machine_id: str) -> Sequence[SourceRow]:
        """Sources that are bound to a machine, by name."""
        query = select(SourceRow).where(SourceRow.machine_id == machine_id)
        return self._session.scalars(query.order_by(SourceRow.name)).all()


def _readable(rows: Iterable[Any]) -> dict[int, Findings]:
    return {number: found for number, found in rows if fault_of(found) is None}
