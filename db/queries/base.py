"""What every kind of query needs: the session of one unit of work, rows by key, pages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from sqlalchemy import Select, func, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from db.history import History
from db.rows import Base
from db.set_apart import fault_in_row, readable
from db.unreadable import Fault

Row = TypeVar("Row", bound=Base)


class Queries:
    """Queries over the session of one unit of work; `history` is that of a unit that writes."""

    def __init__(self, session: Session, history: History | None = None) -> None:
        self._session = session
        self._history = history
        self._apart: dict[tuple[str, str], tuple[tuple[int, Fault], ...]] = {}

    def add(self, row: Base) -> None:
        """Store a new row; constraints are checked at once."""
        self._session.add(row)
        self._session.flush()

    def delete(self, row: Base) -> None:
        """Remove a row at the end of the unit of work; the history tells of it."""
        self._session.delete(row)

    def added(self, row: Base) -> bool:
        """Store a new row in a part of the unit; False, and nothing is done, where another has its key or its name."""
        try:
            with self.part():
                self.add(row)
        except IntegrityError:
            return False
        return True

    def get(self, kind: type[Row], key: str) -> Row | None:
        """The row with this key, or None."""
        return self._session.get(kind, key)

    def lock(self, kind: type[Row], key: str) -> Row | None:
        """The row with this key, locked until the unit of work ends (SQLite holds its one write lock already)."""
        return self._session.get(kind, key, with_for_update=True, populate_existing=True)

    @contextmanager
    def part(self, actor: str | None = None) -> Iterator[None]:
        """A part of a unit that writes, maybe for another actor, which is undone by itself where its block raises."""
        assert self._history is not None, "a unit that only looks has no parts"  # noqa: S101
        with self._history.part(actor), self._session.begin_nested():
            yield

    def flush(self) -> None:
        """Send pending changes to the engine."""
        self._session.flush()

    def ping(self) -> None:
        """Ask the engine for a sign of life."""
        self._session.execute(select(1))

    def _note(self, *told: Any, **more: Any) -> None:
        if self._history is not None:
            self._history.note(*told, **more)

    def _page(self, query: Select[Any], limit: int, offset: int) -> Sequence[Any]:
        return self._session.scalars(query.limit(limit).offset(offset)).all()

    def set_apart(self, session_id: str) -> tuple[tuple[int, Fault], ...]:
        """Number and fault of each part of a session that this unit of work met and could not read."""
        return tuple(part for (_, owner), parts in self._apart.items() if owner == session_id for part in parts)

    def next_number(self, kind: Any, session_id: str) -> int:
        """The number of the next part of a session; parts that cannot be read keep theirs."""
        return 1 + (self._session.scalar(select(func.max(kind.number)).where(kind.session_id == session_id)) or 0)

    def _numbered(self, kind: Any, session_id: str) -> Sequence[Any]:
        query = select(kind).where(kind.session_id == session_id).order_by(kind.number)
        rows = self._session.scalars(query).all()
        faults = ((row.number, fault_in_row(row)) for row in rows)
        self._apart[kind.__tablename__, session_id] = tuple((number, fault) for number, fault in faults if fault)
        return readable(rows)
