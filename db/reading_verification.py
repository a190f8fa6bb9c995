"""Compares the readings that are stored with the digests of the batches in which they came."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Text, select, type_coerce
from sqlalchemy.exc import DatabaseError
from sqlalchemy.orm import Session

from db.audit_chain import parsed
from db.reading_batches import BATCH, Range, batch_digest, is_within
from db.rows import AuditRow, ReadingRangeRow, ReadingRow
from service.model.history import Finding

_CHUNK = 500
_SPREAD = 4
"""Batches are read together where at most this many numbers lie between the first and the last for each of theirs."""


@dataclass(frozen=True)
class _Batch:
    source: str
    sequences: list[Range]
    sha256: str

    @property
    def count(self) -> int:
        return sum(last - first + 1 for first, last in self.sequences)


def reading_findings(session: Session) -> Iterator[Finding]:
    """Batches of which a reading was altered, or removed without being rolled up."""
    rolled: dict[str, list[Range]] = {}
    for source, first, last in session.execute(
        select(ReadingRangeRow.source, ReadingRangeRow.first, ReadingRangeRow.last)
    ):
        rolled.setdefault(source, []).append((first, last))
    for source, batches in _batches(session):
        for batch, rows in _with_rows(session, source, batches):
            yield from _compared(batch, rows, rolled.get(source, ()))


def _batches(session: Session) -> Iterator[tuple[str, list[_Batch]]]:
    """Batches of each source, some at a time, in the order in which they came."""
    sources = session.scalars(select(AuditRow.key).where(AuditRow.kind == "reading").distinct()).all()
    for source in sources:
        last = 0
        query = select(AuditRow.id, type_coerce(AuditRow.changes, Text)).where(
            AuditRow.kind == "reading", AuditRow.key == source
        )
        while lines := session.execute(query.where(AuditRow.id > last).order_by(AuditRow.id).limit(_CHUNK)).all():
            yield source, [batch for _, text in lines if (batch := _batch(source, parsed(text or ""))) is not None]
            last = lines[-1][0]


def _batch(source: str, told: Any) -> _Batch | None:
    batch = told.get(BATCH) if isinstance(told, dict) else None
    try:
        ranges = [(int(first), int(last)) for first, last in batch["sequences"]] if batch else []
        return _Batch(source, ranges, str(batch["sha256"])) if ranges and batch else None
    except (ValueError, TypeError, KeyError):
        return _Batch(source, [], "")


def _with_rows(session: Session, source: str, batches: Sequence[_Batch]) -> Iterator[tuple[_Batch, list[Any] | None]]:
    """Each batch with its readings as they are stored; None where the engine cannot read them."""
    numbers = [edge for batch in batches for edges in batch.sequences for edge in edges]
    span = max(numbers) - min(numbers) + 1 if numbers else 0
    if span and span <= _SPREAD * sum(batch.count for batch in batches):
        rows = _read(session, source, (min(numbers), max(numbers)))
        if rows is not None:
            known = {row.sequence: row for row in rows}
            for batch in batches:
                wanted = (number for first, last in batch.sequences for number in range(first, last + 1))
                yield batch, [known[number] for number in wanted if number in known]
            return
    for batch in batches:
        parts = [_read(session, source, edges) for edges in batch.sequences]
        yield batch, None if None in parts else [row for part in parts for row in part or ()]


def _read(session: Session, source: str, edges: Range) -> Sequence[Any] | None:
    columns = [getattr(ReadingRow, name) for name in ReadingRow.__mapper__.columns.keys() if name != "id"]  # noqa: SIM118
    query = select(*columns).where(ReadingRow.source == source, ReadingRow.sequence.between(*edges))
    try:
        return session.execute(query).all()
    except (ValueError, TypeError, DatabaseError):
        return None


def _compared(batch: _Batch, rows: list[Any] | None, rolled: Sequence[Range]) -> Iterator[Finding]:
    if not batch.sequences:
        yield _finding("readings_altered", f"a line of readings of source {batch.source!r} was altered")
        return
    where = f"source {batch.source!r}, numbers {', '.join(f'{a} to {b}' for a, b in batch.sequences[:5])}"
    if rows is None:
        yield _finding("readings_altered", f"{where}: readings were altered behind the service")
    elif len(rows) < batch.count:
        known = {row.sequence for row in rows}
        gone = [n for first, last in batch.sequences for n in range(first, last + 1) if n not in known]
        if left := [number for number in gone if not is_within(number, rolled)]:
            yield _finding("readings_missing", f"{where}: {len(left)} readings were removed behind the service")
    elif _digest(rows) != batch.sha256:
        yield _finding("readings_altered", f"{where}: readings were altered behind the service")


def _digest(rows: list[Any]) -> str:
    try:
        return batch_digest(rows)
    except (ValueError, TypeError, ArithmeticError, struct.error):
        return ""


def _finding(code: str, detail: str) -> Finding:
    return Finding(code=code, detail=detail, session_id=None)
