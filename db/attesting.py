"""Lines of history with the digests of rows that are stored already; used by migration 0012.

What was altered before them is not found by them. Parts of closed sessions have their seal.
"""

from __future__ import annotations

from itertools import islice
from typing import Any

from sqlalchemy import Connection, inspect, select
from sqlalchemy.orm import Session

from db.history import History
from db.row_digests import COLUMNS, PARTS, owner_column
from db.rows import Base

_CHUNK = 400


def attest(session: Session, history: History) -> None:
    """Tell of every row there is that no seal covers; the caller finishes the history."""
    connection = session.connection()
    closed = set(
        connection.scalars(_column("session", "id").where(Base.metadata.tables["session"].c.state == "closed"))
    )
    there = set(inspect(connection).get_table_names())
    for table in COLUMNS:
        if table not in there:
            continue  # a table of a later revision: its rows are told from the first on
        rows = _rows(connection, table)
        open_rows = iter([key for key, owner in rows if not (table in PARTS and owner in closed)])
        while keys := list(islice(open_rows, _CHUNK)):
            history.note("attested", table, "", {}, rows=[(table, key) for key in keys])


def _rows(connection: Connection, table: str) -> list[tuple[Any, Any]]:
    columns = Base.metadata.tables[table].c
    key, owner = columns[COLUMNS[table][0]], owner_column(table)
    query = select(key, columns[owner]) if owner else select(key, key)
    return [(row[0], row[1]) for row in connection.execute(query.order_by(key))]


def _column(table: str, name: str) -> Any:
    return select(Base.metadata.tables[table].c[name])
