"""The history of changes, and what `verify` compares with it."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import select

from db.audit_chain import record_digest
from db.mending import mend
from db.queries.base import Queries
from db.rows import AuditRow, SessionRow
from db.set_apart import faults, readable
from db.unreadable import Fault


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

    def chained(self, after: int, most: int) -> Sequence[AuditRow]:
        """Entries of the chain above a number, in order."""
        query = select(AuditRow).where(AuditRow.number > after).order_by(AuditRow.number).limit(most)
        rows = self._session.scalars(query).all()
        self._session.expunge_all()
        return rows

    def faults(self) -> Sequence[Fault]:
        """Every document there is that cannot be read."""
        return [fault for fault, _ in faults(self._session.connection())]

    def mend(self) -> Sequence[tuple[str, str]]:
        """Mend what needs no guess; kind and key of each thing that was mended."""
        assert self._history is not None, "a unit that only looks mends nothing"  # noqa: S101
        return mend(self._session, self._history)

    def closed_sessions(self) -> Sequence[str]:
        """Identifiers of all closed sessions."""
        return self._session.scalars(select(SessionRow.id).where(SessionRow.state == "closed")).all()

    def record_digest(self, session_id: str) -> str | None:
        """Digest of all that is stored of a session, as `db.audit_chain` says; None where it is not stored."""
        return record_digest(self._session, session_id)
