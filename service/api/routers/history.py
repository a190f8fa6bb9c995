"""Who changed what, when."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from service.api.dependencies import Key, Limit, Offset, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.history import HistoryEntry
from service.usecases import audit

router = APIRouter(route_class=StrictRoute)
Word = Annotated[str | None, Query(max_length=100, description="Only of this one.")]


@router.get("/history", tags=["history"], responses=errors())
def list_history(
    work: WorkDep, limit: Limit = 50, offset: Offset = 0, kind: Word = None, key: Word = None, actor: Word = None
) -> tuple[HistoryEntry, ...]:
    """Changes, newest first: of one kind, of one thing, by one actor. Units are those of what was changed."""
    return audit.find(work, limit, offset, kind=kind, key=key, actor=actor)


@router.get("/sessions/{session_id}/history", tags=["history"], responses=errors(404))
def get_session_history(
    work: WorkDep, session_id: Key, limit: Limit = 50, offset: Offset = 0
) -> tuple[HistoryEntry, ...]:
    """Changes of a session, newest first. Units are those of what was changed."""
    return audit.of_session(work, session_id, limit, offset)
