"""Readings by the thousand: past the ORM, one statement a batch.

SQLite takes them by the driver's `executemany`, which loops in C. PostgreSQL takes one array a column in binary form:
one statement whatever the length, and its row count says how many were new (of `executemany` nothing says it there).
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple, cast

from sqlalchemy import Connection, CursorResult


class NewReading(NamedTuple):
    """A row of `reading` to be; the fields are its columns, `taken_at` has a zone."""

    source: str
    sequence: int
    machine_id: str
    session_id: str | None
    taken_at: datetime
    sensor: str
    amplitude: float
    phase_deg: float | None
    speed_rpm: float | None
    scatter: float | None
    overall_rms: float | None


_COLUMNS = ", ".join(NewReading._fields)
_TYPES = ("text", "int8", "text", "text", "timestamptz", "text", "float8", "float8", "float8", "float8", "float8")
_TIME = NewReading._fields.index("taken_at")
_INTO = f"INSERT INTO reading ({_COLUMNS})"
_SQLITE = f"{_INTO} VALUES ({', '.join('?' * len(_TYPES))}) ON CONFLICT DO NOTHING"
_ARRAYS = ", ".join(f"%b::{kind}[]" for kind in _TYPES)
_POSTGRESQL = f"{_INTO} SELECT * FROM unnest({_ARRAYS}) ON CONFLICT DO NOTHING"  # noqa: S608 - no value of a reading is in the text


def insert_new(connection: Connection, rows: Sequence[NewReading]) -> int:
    """Insert the rows whose (source, sequence) is not stored yet; returns how many were."""
    if connection.dialect.name == "postgresql":
        # In the order of the keys, so that two batches with the same readings wait for each other, not both at once.
        columns = [list(column) for column in zip(*sorted(rows, key=lambda row: row[:2]), strict=True)]
        result = connection.exec_driver_sql(_POSTGRESQL, tuple(columns))
    else:
        result = connection.exec_driver_sql(_SQLITE, [_for_sqlite(row) for row in rows])
    return cast("CursorResult[Any]", result).rowcount


def _for_sqlite(row: NewReading) -> tuple[Any, ...]:
    """The row with its time as SQLAlchemy writes it: UTC, without a zone."""
    text = row.taken_at.astimezone(UTC).isoformat(" ", "microseconds")[:26]
    return (*row[:_TIME], text, *row[_TIME + 1 :])
