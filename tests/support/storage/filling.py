"""A row for every table, whatever the tables are: read from the schema as it is, not from today's rows."""

from __future__ import annotations

import itertools
from datetime import datetime
from typing import Any

from sqlalchemy import Boolean, Column, DateTime, Engine, Float, LargeBinary, MetaData, Numeric, Table, func, select
from sqlalchemy.types import Integer, String

from db.database import Database

_numbers = itertools.count(1)


def reflected(engine: Engine) -> MetaData:
    """The tables there are, without the one that holds the revision."""
    tables = MetaData()
    tables.reflect(engine)
    tables.remove(tables.tables["alembic_version"])
    return tables


def counted(database: Database) -> dict[str, int]:
    """Rows in each table."""
    with database.engine.connect() as connection:
        return {
            table.name: connection.execute(select(func.count()).select_from(table)).scalar_one()
            for table in reflected(database.engine).sorted_tables
        }


def fill(engine: Engine) -> None:
    """Add a row to every table, each reference to the row that was added to the other table."""
    added: dict[tuple[str, str], Any] = {}
    with engine.begin() as connection:
        for table in reflected(engine).sorted_tables:
            values = {
                column.name: _value(table, column, added) for column in table.columns if not _counts_itself(column)
            }
            connection.execute(table.insert().values(values))
            row = connection.execute(select(table).order_by(*table.primary_key.columns)).mappings().all()[-1]
            added |= {(table.name, name): values.get(name, value) for name, value in row.items()}


def _counts_itself(column: Column[Any]) -> bool:
    """A key that the engine numbers: the only column of the key, and no reference."""
    alone = column.table.primary_key.columns.keys() == [column.name]
    return alone and isinstance(column.type, Integer) and not column.foreign_keys


def _value(table: Table, column: Column[Any], added: dict[tuple[str, str], Any]) -> Any:
    for key in column.foreign_keys:
        # None for a reference forward, or to the row itself.
        return added.get((key.column.table.name, key.column.name))
    number = next(_numbers)
    kind = column.type
    if isinstance(kind, Boolean):
        return True
    if isinstance(kind, Integer):
        return number
    if isinstance(kind, Float | Numeric):
        return 1.0 + number
    if isinstance(kind, DateTime):
        return datetime(2026, 3, 1, 12, number % 60)  # noqa: DTZ001 - either engine takes it, in its own zone
    if isinstance(kind, LargeBinary):
        return number.to_bytes(4, "big")
    if isinstance(kind, String):
        return f"{table.name[:10]}-{number}" if kind.length else "{}"
    raise NotImplementedError(f"no value for {table.name}.{column.name} of type {kind}")
