"""Sessions: searched, by state; all runs of one."""

from __future__ import annotations

from typing import get_args

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from service.model.session import SessionState
from service.usecases.sessions import sessions
from service.web.rendering import PageDep
from service.web.routers.session_steps import Key
from service.web.session import steps
from service.web.session.guide import look

router = APIRouter(prefix="/sessions")

A_PAGE = 30
STATES: tuple[str, ...] = get_args(SessionState)
MAX_SEARCH = 100


@router.get("")
def sessions_page(page: PageDep, words: str = "", state: str = "", start: int = 0) -> HTMLResponse:
    """Sessions, newest first; those whose machine, technician or note has the words in it."""
    words, start = words.strip()[:MAX_SEARCH], min(max(start, 0), 10**9)
    state = state if state in STATES else ""
    found = sessions.find(page.work, A_PAGE + 1, start, state=state or None, words=words or None)
    return page.render(
        "sessions.html",
        sessions=found[:A_PAGE],
        more=len(found) > A_PAGE,
        words=words,
        state=state,
        states=STATES,
        start=start,
        a_page=A_PAGE,
    )


@router.get("/{session_id}/runs")
def runs_page(page: PageDep, session_id: Key, before: int | None = None) -> HTMLResponse:
    """Runs of a session, newest first, page by page, and what is set down about it."""
    return steps.show_all(page, look(page.work, session_id), before)
