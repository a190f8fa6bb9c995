"""Language, light or dark, units: chosen here, kept in a cookie."""

from __future__ import annotations

import re

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from service.web.forms import TypedDep
from service.web.preferences import COOKIE
from service.web.rendering import PageDep

router = APIRouter()

YEAR_S = 365 * 86400
_LOCAL = re.compile(r"/(?![/\\])[^\s\\]*")


@router.get("/preferences")
def show_preferences(page: PageDep, back: str = "/") -> HTMLResponse:
    """All choices."""
    return page.render("preferences.html", back=local(back))


@router.post("/preferences")
def change_preferences(page: PageDep, typed: TypedDep) -> Response:
    """Keep the choices that were sent, and go back to where the reader was."""
    answer = page.goto(local(typed.get("back", "/")))
    answer.set_cookie(COOKIE, page.preferences.changed(typed).cookie(), max_age=YEAR_S, samesite="lax", httponly=True)
    return answer


def local(path: str) -> str:
    """The path if it is one of this service, else the first page: no one is sent elsewhere."""
    return path if _LOCAL.fullmatch(path) else "/"
