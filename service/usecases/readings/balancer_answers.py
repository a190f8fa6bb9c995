"""Store and list the answers of balancers."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

from db.rows import BalancerAnswerRow, SessionRow
from service.engine.validation import check_answer
from service.model.base import document
from service.model.run import BalancerAnswer, MassOnRotor
from service.runtime.context import AppContext, require
from service.usecases.readings.clocks import Arrival
from service.usecases.readings.routing import Targets, reused


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
    """Session it is meant for; null where none was open on the machine, or several."""
    masses: tuple[MassOnRotor, ...]
    """Continuous masses, the total to have on the as-found rotor: g and degrees in the machine's `angle_sense`."""


@document
class StoredAnswer:
    """A balancer's answer as it is stored."""

    id: str
    """Identifier, for a correction of source balancer."""
    session_id: str | None
    """Session it is meant for."""
    accepted: bool
    """False: it was stored before."""


def ingest(work: AppContext, answer: BalancerAnswer, arrival: Arrival | None = None) -> StoredAnswer:
    """Store a balancer's answer once. arrival: when it came; None: now. Raises as readings do."""
    with work.write() as store:
        targets = Targets(store)
        machine_id = targets.machine_of(answer.source, answer.session_id, "session_id")
        check_answer(targets.machine(machine_id), answer.masses)
        session_id = answer.session_id or _only(store.open_sessions(machine_id))
        key = (answer.source, answer.sequence)
        stored = store.known(BalancerAnswerRow, [key]).get(key)
        if isinstance(stored, BalancerAnswerRow):
            same_session = answer.session_id in (None, stored.session_id)
            if not same_session or (stored.taken_at, stored.masses) != (answer.taken_at, answer.masses):
                raise reused(key, "sequence")
            return StoredAnswer(id=stored.id, session_id=stored.session_id, accepted=False)
        row = BalancerAnswerRow(
            id=work.new_id(),
            source=answer.source,
            sequence=answer.sequence,
            machine_id=machine_id,
            session_id=session_id,
            taken_at=answer.taken_at,
            masses=answer.masses,
            received_at=work.now() if arrival is None else arrival.received_at,
        )
        store.add(row)
        return StoredAnswer(id=row.id, session_id=session_id, accepted=True)


def _only(sessions: Sequence[SessionRow]) -> str | None:
    """The one session that is open; None where there are several: either may be meant, and is asked about."""
    return sessions[0].id if len(sessions) == 1 else None


def of_session(work: AppContext, session_id: str, limit: int, offset: int) -> tuple[ListedAnswer, ...]:
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
