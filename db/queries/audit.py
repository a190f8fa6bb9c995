"""The history of changes, and what `verify` compares with it."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import select

from db.mending import mend
from db.queries.base import Queries
from db.rows import AuditRow
from db.set_apart import faults, readable
from db.unreadable import Fault
from db.verification import Walk, chained


class Past(Queries):
    """The history: who, when, what."""

    def history(
        self,
        limit: int,
        offset: int,
        *,
        session_id: str | None = None,
        kind: str | None = None,
        key: str | None = None,
        actor: str | None = None,
    ) -> Sequence[AuditRow]:
        """Changes, newest first: of a session, of one thing, by one actor."""
        query = select(AuditRow).order_by(AuditRow.id.desc())
        wanted = {"session_id": session_id, "kind": kind, "key": key, "actor": actor}
        for name, value in wanted.items():
            if value is not None:
                query = query.where(getattr(AuditRow, name) == value)
        return readable(self._page(query, limit, offset))

    def walk(self) -> Walk:
        """A walk along the chain and through the tables that compares the two."""
        return Walk(self._session)

    def is_on_chain(self, number: int, digest: str) -> bool:
        """Whether the chain has this entry."""
        return any((line.number, line.hash) == (number, digest) for line in chained(self._session, number - 1, 1))

    def faults(self) -> Sequence[Fault]:
        """Every document there is that cannot be read."""
        return [fault for fault, _ in faults(self._session.connection())]

    def mend(self) -> Sequence[tuple[str, str]]:
        """Mend what needs no guess; kind and key of each thing that was mended."""
        assert self._history is not None, "a unit that only looks mends nothing"  # noqa: S101
        return mend(self._session, self._history)
