"""Column types: times in UTC on every engine, documents as JSON text."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import lru_cache
from typing import Any

from sqlalchemy import DateTime, Text
from sqlalchemy.engine import Dialect
from sqlalchemy.types import TypeDecorator

from db.unreadable import DocumentRefused, Unreadable, fault_in, require_finite
from service.model.base import read_json, to_plain, write_json


class UtcTime(TypeDecorator[datetime]):
    """An aware UTC time; SQLite keeps no zone, so it is put back on the way out."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:  # noqa: ARG002, D102
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError(f"time {value!r} has no zone; state it in UTC")
        return value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:  # noqa: ARG002, D102
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


class Document(TypeDecorator[Any]):
    """A document of one type (or a tuple of them), stored as JSON text; checked when written and when read.

    Writing raises DocumentRefused (in a StatementError of SQLAlchemy) for a document that could not be read again.
    Reading gives an `Unreadable` for a text that breaks a rule, so that the rows around it are read all the same.

    recurring: the same text comes again and again, as a machine's with each of its readings; since no document ever
    changes, the one that was read before serves.
    """

    impl = Text
    cache_ok = True

    def __init__(self, kind: Any, *, recurring: bool = False) -> None:
        super().__init__()
        self.kind = kind
        self.recurring = recurring

    def process_bind_param(self, value: Any, dialect: Dialect) -> str | None:  # noqa: ARG002, D102
        if value is None:
            return None
        text = write_json(value, self.kind)
        try:
            again = read_json(self.kind, text)
        except ValueError as wrong:
            raise DocumentRefused(fault_in(wrong)) from wrong
        if again != value:
            # A NaN is written as null, which an optional field takes: it would come back as another document.
            require_finite(to_plain(value, self.kind))
        return text

    def process_result_value(self, value: str | None, dialect: Dialect) -> Any:  # noqa: ARG002, D102
        if value is None:
            return None
        try:
            return _read_before(self.kind, value) if self.recurring else read_json(self.kind, value)
        except ValueError as wrong:
            return Unreadable(fault_in(wrong))


@lru_cache(maxsize=64)
def _read_before(kind: Any, text: str) -> Any:
    return read_json(kind, text)
