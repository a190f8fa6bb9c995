"""Set apart rows whose documents cannot be read: named when loaded, left out of lists."""

from __future__ import annotations

import logging
from collections.abc import Hashable, Iterator, Sequence
from functools import cache
from typing import Any, TypeVar, cast

from sqlalchemy import Connection, Table, Text, event, inspect, select, type_coerce
from sqlalchemy.orm import Mapper

from db.rows import AuditRow, Base
from db.types import Document
from db.unreadable import Fault, UnreadableRow, fault_of, name_fault

Row = TypeVar("Row", bound=Base)

_log = logging.getLogger("drumtrue.storage")
_MAX_TOLD = 1000
_told: set[tuple[str, str, str]] = set()
"""Rows that this process has logged, so that a page which is asked every second does not fill the log."""


@cache
def document_columns(kind: Hashable) -> tuple[str, ...]:
    """Names of the columns that hold documents; kind: the class of a row."""
    mapper = cast("Mapper[Any]", inspect(kind))
    return tuple(c.key for c in mapper.columns if isinstance(c.type, Document))


def fault_in_row(row: Base) -> Fault | None:
    """Why a row cannot be used as a whole; None where all its documents were read."""
    return next((fault for name in document_columns(type(row)) if (fault := fault_of(row.__dict__.get(name)))), None)


def readable(rows: Sequence[Row]) -> Sequence[Row]:
    """The rows whose documents can be read, in their order."""
    return [row for row in rows if fault_in_row(row) is None] if any(map(fault_in_row, rows)) else rows


def require_readable(row: Base) -> None:
    """Raise UnreadableRow where one of the row's documents cannot be read."""
    if (fault := fault_in_row(row)) is not None:
        raise UnreadableRow(fault)


def key_of(row: Base) -> str:
    """The key of a row, the parts of a composite one with blanks between."""
    return " ".join(str(getattr(row, str(column.key))) for column in row.__mapper__.primary_key)


def faults(connection: Connection) -> Iterator[tuple[Fault, str]]:
    """Every document of the database that cannot be read, and its text, table by table."""
    for mapper in Base.registry.mappers:
        kind = cast(Hashable, mapper.class_)
        for name in document_columns(kind):
            yield from _faults_of_column(connection, cast(Table, mapper.local_table), name)


def _faults_of_column(connection: Connection, table: Table, name: str) -> Iterator[tuple[Fault, str]]:
    keys = list(table.primary_key.columns)
    column = cast(Document, table.c[name].type)
    query = select(*keys, type_coerce(table.c[name], Text).label("text")).order_by(*keys)
    for *key, text in connection.execution_options(yield_per=500).execute(query):
        fault = fault_of(column.process_result_value(text, connection.dialect))
        if fault is not None:
            yield fault.at(table.name, " ".join(map(str, key)), name), text


def _name(row: Base, *_more: object) -> None:
    for column in document_columns(type(row)):
        fault = name_fault(row.__dict__.get(column), row.__tablename__, key_of(row), column)
        if fault is not None:
            _tell(fault)


def _tell(fault: Fault) -> None:
    place = (fault.table, fault.key, fault.column)
    if place not in _told and len(_told) < _MAX_TOLD:
        _told.add(place)
        _log.warning("a stored row cannot be read and is set apart: %s; `drumtrue repair` lists all", fault)


for _mapper in Base.registry.mappers:
    if document_columns(cast(Hashable, _mapper.class_)) and _mapper.class_ is not AuditRow:
        event.listen(_mapper.class_, "load", _name)
        event.listen(_mapper.class_, "refresh", _name)
