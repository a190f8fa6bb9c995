"""The first page: start balancing, or go on where somebody stopped."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from service.usecases.sessions import sessions
from service.web.rendering import PageDep

router = APIRouter()

SHOWN = 12


@router.get("/")
def home(page: PageDep) -> HTMLResponse:
    """What is under way, newest first."""
    recent = sessions.find(page.work, SHOWN, 0)
    return page.render(
        "home.html",
        open_sessions=[s for s in recent if s.state != "closed"],
        closed_sessions=[s for s in recent if s.state == "closed"],
    )
