"""Optimistic locking: a write based on an outdated version is rejected (If-Match)."""

from __future__ import annotations

from db.rows import PlanRow, SessionRow
from db.store import Store
from service.errors import Stale
from service.messages import Message, Word
from service.runtime.context import AppContext, require
from service.usecases.session_view import session_view, updated_plan


def require_seen(work: AppContext, store: Store, row: SessionRow | PlanRow) -> None:
    """The row, locked by the caller, is at the version that the request was made on, if it says so. Raises Stale."""
    noun, version = ("plan", row.plan.version) if isinstance(row, PlanRow) else ("session", row.version)
    if work.seen in (None, version):
        return
    raise Stale(
        Message("version_stale", noun=Word(noun), version=version, seen=work.seen),
        field="If-Match",
        value=work.seen,
        current=updated_plan(store, row) if isinstance(row, PlanRow) else session_view(store, row),
    )


def hold(work: AppContext, session_id: str) -> None:
    """Keep a session as it is until the unit of work under way ends. Raises NotFound, Stale."""
    with work.write() as store:
        require_seen(work, store, require(store, SessionRow, session_id, lock=True))
