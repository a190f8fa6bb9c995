"""What balancers answered themselves, for a session to be corrected by."""

from __future__ import annotations

from datetime import datetime

from db.documents.base import document
from db.documents.run import MassOnRotor
from db.rows import SessionRow
from service.usecases.work import Work, require


@document
class ListedAnswer:
    """A balancer's answer that a session may be corrected by."""

    id: str
    """Identifier: `answer_id` of a correction of source balancer."""
    source: str
    """Who answered."""
    sequence: int
    """Its number at the source."""
    taken_at: datetime
    """When, UTC."""
    session_id: str | None
    """Session it is meant for; null where none was open on the machine."""
    masses: tuple[MassOnRotor, ...]
    """Continuous masses, the total to have on the as-found rotor: g and degrees in the machine's `angle_sense`."""


def of_session(work: Work, session_id: str, limit: int, offset: int) -> tuple[ListedAnswer, ...]:
    """Answers on the session's machine that are meant for it or for no session, newest first. Raises NotFound."""
    with work.read() as store:
        session = require(store, SessionRow, session_id)
        return tuple(
            ListedAnswer(
                id=row.id,
                source=row.source,
                sequence=row.sequence,
                taken_at=row.taken_at,
                session_id=row.session_id,
                masses=row.masses,
            )
            for row in store.answers(session.machine_id, session.id, limit, offset)
        )
