"""Bulk insert of readings past the ORM, in few statements a batch.

SQLite takes hundreds of rows a statement. Its driver lets other threads go on during each statement, and where one of
them computes, the interpreter comes back milliseconds later: once a row, with `executemany`. PostgreSQL takes one array
a column in binary form: one statement whatever the length, and its row count says how many were new.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache, lru_cache
from typing import Any, NamedTuple, cast

from sqlalchemy import Connection, CursorResult


class NewReading(NamedTuple):
    """A row of `reading` to be; the fields are its columns, times have a zone."""

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
    received_at: datetime
    apart: str | None = None


_COLUMNS = ", ".join(NewReading._fields)
_TYPES = ("text", "int8", "text", "text", "timestamptz", "text", *["float8"] * 5, "timestamptz", "text")
_TIME, _RECEIVED = NewReading._fields.index("taken_at"), NewReading._fields.index("received_at")
_INTO = f"INSERT INTO reading ({_COLUMNS})"
_ROWS_AT_ONCE = (500, 50, 5, 1)
"""Few lengths, so that each statement is prepared once. SQLite takes 32,766 values in one."""
_ARRAYS = ", ".join(f"%b::{kind}[]" for kind in _TYPES)
_POSTGRESQL = f"{_INTO} SELECT * FROM unnest({_ARRAYS}) ON CONFLICT DO NOTHING"  # noqa: S608 - no value of a reading is in the text


def insert_new(connection: Connection, rows: Sequence[NewReading]) -> int:
    """Insert the rows whose (source, sequence) is not stored yet; returns how many were."""
    if connection.dialect.name == "postgresql":
        # In the order of the keys, so that two batches with the same readings wait for each other, not both at once.
        columns = [list(column) for column in zip(*sorted(rows, key=lambda row: row[:2]), strict=True)]
        return _run(connection, _POSTGRESQL, columns)
    added = start = 0
    for size in _ROWS_AT_ONCE:
        while len(rows) - start >= size:
            values = [value for row in rows[start : start + size] for value in _for_sqlite(row)]
            added += _run(connection, _for_rows(size), values)
            start += size
    return added


def _run(connection: Connection, statement: str, values: Sequence[Any]) -> int:
    return cast("CursorResult[Any]", connection.exec_driver_sql(statement, tuple(values))).rowcount


@cache
def _for_rows(count: int) -> str:
    row = f"({', '.join('?' * len(_TYPES))})"
    return f"{_INTO} VALUES {', '.join([row] * count)} ON CONFLICT DO NOTHING"


def _for_sqlite(row: NewReading) -> tuple[Any, ...]:
    taken, received = _in_text(row.taken_at), _received_in_text(row.received_at)
    return (*row[:_TIME], taken, *row[_TIME + 1 : _RECEIVED], received, *row[_RECEIVED + 1 :])


def _in_text(moment: datetime) -> str:
    """A time as SQLAlchemy writes it: UTC, without a zone."""
    return moment.astimezone(UTC).isoformat(" ", "microseconds")[:26]


_received_in_text = lru_cache(maxsize=16)(_in_text)
"""All readings of a request were received at one time."""
