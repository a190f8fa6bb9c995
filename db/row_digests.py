"""Digests of rows, by which `verify` compares what is stored with what the history told. Format 1 must never change.

Every line of the history about a row holds the digest of the row as it was stored then, under `ROWS` in its changes,
within the chain. Canonical JSON and documents are as in `db.audit_chain`. What a table gains later is not in it: the
columns are listed here. A session's `version` is left out, it changes without a line of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, RowMapping, Text, select, type_coerce
from sqlalchemy.exc import DatabaseError

from db.audit_chain import digest, parsed
from db.rows import Base
from db.types import Document

FORMAT = 1
ROWS = "#rows"
"""Where a line of the history holds digests: {"run id-0007": SHA-256}."""
UNREADABLE = "unreadable"
"""Instead of the digest of a row that the engine itself cannot read."""
PARTS = frozenset({"session", "run", "correction", "plan", "stop"})
"""Tables that the seal of a closed session covers."""
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "machine": ("id", "name", "spec", "created_at", "updated_at"),
    "catalogue": ("id", "name", "items", "created_at"),
    "session": (
        *("id", "machine_id", "machine_name", "machine", "catalogue_id", "state", "technician", "note", "run_out"),
        *("on_rotor", "fitted_plan_id", "created_at", "closed_at"),
    ),
    "run": ("id", "session_id", "number", "run"),
    "correction": ("id", "session_id", "number", "correction"),
    "plan": ("id", "session_id", "number", "plan"),
    "stop": ("id", "session_id", "number", "stop"),
    "influence": ("id", "machine_id", "session_id", "machine_type", "learned_at", "learned"),
    "arrangement": ("id", "machine_id", "session_id", "created_at", "arrangement"),
    "design_study": ("id", "created_at", "updated_at", "study"),
    "design_run": ("id", "study_id", "created_at", "run"),
    "place_set": ("id", "machine_id", "name", "places", "updated_at"),
    "part_entry": ("id", "machine_id", "part", "arrangement_id", "record"),
    "source": ("name", "machine_id", "bound_at"),
    "token": ("id", "name", "scopes", "digest", "created_at", "expires_at", "revoked_at"),
    "balancer_answer": ("id", "source", "sequence", "machine_id", "session_id", "taken_at", "masses"),
    "stock_entry": (
        *("id", "catalogue_id", "item", "kind", "pieces", "held", "session_id", "plan_id", "until", "note", "at"),
    ),
}
_CHUNK = 400


def digests(connection: Connection, table: str, keys: Sequence[Any]) -> dict[str, str]:
    """Digest of each of these rows, by key as text; rows that are not there are left out."""
    found: dict[str, str] = {}
    for start in range(0, len(keys), _CHUNK):
        query = _query(table)
        for row in connection.execute(query.where(_key(table).in_(keys[start : start + _CHUNK]))).mappings():
            found[str(row[COLUMNS[table][0]])] = _digest(table, row)
    return found


def all_digests(connection: Connection, table: str) -> Iterator[tuple[str, str | None, str]]:
    """Key, session and digest of every row of a table; `UNREADABLE` where the engine cannot read the row."""
    keys = [key for (key,) in connection.execute(select(_key(table)).order_by(_key(table)))]
    for start in range(0, len(keys), _CHUNK):
        chunk = keys[start : start + _CHUNK]
        try:
            yield from _of_keys(connection, table, chunk)
        except (ValueError, TypeError, DatabaseError):
            yield from _one_by_one(connection, table, chunk)


def owner_column(table: str) -> str | None:
    """The column that names the session a row belongs to."""
    return "id" if table == "session" else "session_id" if "session_id" in COLUMNS[table] else None


def _of_keys(connection: Connection, table: str, keys: Sequence[Any]) -> list[tuple[str, str | None, str]]:
    owner = owner_column(table)
    rows = connection.execute(_query(table).where(_key(table).in_(keys))).mappings()
    return [(str(row[COLUMNS[table][0]]), owner and row[owner], _digest(table, row)) for row in rows]


def _one_by_one(connection: Connection, table: str, keys: Iterable[Any]) -> Iterator[tuple[str, str | None, str]]:
    for key in keys:
        try:
            yield from _of_keys(connection, table, [key])
        except (ValueError, TypeError, DatabaseError):
            yield str(key), None, UNREADABLE


def _key(table: str) -> Any:
    return Base.metadata.tables[table].c[COLUMNS[table][0]]


def _query(table: str) -> Any:
    columns = Base.metadata.tables[table].c
    return select(
        *(type_coerce(columns[c], Text).label(c) if _is_document(columns[c]) else columns[c] for c in COLUMNS[table])
    )


def _is_document(column: Any) -> bool:
    return isinstance(column.type, Document)


def _digest(table: str, row: RowMapping) -> str:
    columns = Base.metadata.tables[table].c
    values = {
        name: parsed(row[name]) if _is_document(columns[name]) and row[name] is not None else row[name]
        for name in COLUMNS[table]
    }
    return digest([FORMAT, table, values])
