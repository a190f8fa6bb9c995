"""Every error as a page as text, for a reader; programs get the problem document of the API as before."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.exceptions import HTTPException

from db.unreadable import UnreadableRow
from service.errors import DrumtrueError, NotFound
from service.runtime.context import unreadable
from service.web.language import N_
from service.web.rendering import Page

API_PATHS = ("/api/", "/health", "/metrics", "/openapi.json", "/static/")
TITLES = {
    401: N_("You are not logged in"),
    403: N_("That is not open to you"),
    404: N_("This page does not exist"),
    405: N_("This address does not take that"),
    409: N_("Somebody was faster, or the step is out of order"),
    413: N_("That is too much at once"),
    429: N_("Too many attempts"),
    422: N_("Something typed is not right"),
    503: N_("The service cannot answer just now"),
}
UNKNOWN = N_("Something went wrong at the server")


@dataclass(frozen=True)
class Onward:
    """Something that is not stored: how its page is headed, and where to look for what is."""

    title: str
    path: str
    name: str


_SESSIONS = Onward(N_("There is no such session"), "/sessions", N_("All sessions"))
_BOXES = Onward(N_("There is no such box"), "/boxes", N_("All boxes"))
MISSING = {
    "session_id": _SESSIONS,
    "machine_id": Onward(N_("There is no such machine"), "/machines", N_("All machines")),
    "box_id": _BOXES,
    "catalogue_id": _BOXES,
    "plan_id": Onward(N_("There is no such plan"), "/sessions/{session_id}/step/plan", N_("To the session’s plan")),
    "run_id": Onward(N_("There is no such run"), "/sessions/{session_id}/runs", N_("All runs")),
    "number": Onward(N_("There is no such stop"), "/sessions/{session_id}", N_("To the session")),
}
ADVICE = {
    404: N_("The address is wrong, or what it showed was never stored. Go back, or start at the first page."),
    405: N_("Go back and use the buttons of the page."),
}
UNKNOWN_ADVICE = N_("What you asked for was not done. Go back and try again; what was stored before is safe.")


def install(app: FastAPI) -> None:
    """Answer errors with a page where a reader asks; call it after the API has put up its own answers."""
    for kind, api in list(app.exception_handlers.items()):
        app.add_exception_handler(kind, _either(api))


def wants_page(request: Request) -> bool:
    """Whether a browser asks for a page."""
    return not request.url.path.startswith(API_PATHS) and "text/html" in request.headers.get("accept", "")


def _either(api: Callable[..., Any]) -> Callable[[Request, Exception], Awaitable[Response]]:
    async def answer(request: Request, error: Exception) -> Response:
        if wants_page(request):
            return error_page(request, error)
        made = api(request, error)
        return await made if isinstance(made, Awaitable) else made  # type: ignore[no-any-return]

    return answer


def error_page(request: Request, error: Exception) -> Response:
    """The page for an error: what is wrong, what to do, and a way on."""
    if isinstance(error, UnreadableRow):
        error = unreadable(error)
    status, onward = _status(error), None
    if (name := _missing(error)) in MISSING:
        status, onward = 404, MISSING[name]
    told = error if isinstance(error, DrumtrueError) and onward is None else None
    page = Page(request)
    answer = page.render(
        "problem.html",
        status=status,
        title=TITLES.get(status, UNKNOWN) if onward is None else onward.title,
        detail=page.message(told) if told is not None else None,
        advice=(page.advice(told) if told is not None else None)
        or (None if told is not None else ADVICE.get(status, UNKNOWN_ADVICE)),
        onward=None if onward is None else (onward.path.format_map(_Known(request.path_params)), onward.name),
    )
    if told is not None and told.retry_after_s is not None:
        answer.headers["retry-after"] = str(told.retry_after_s)
        if status == 503 and request.method == "GET":
            answer.headers["refresh"] = str(told.retry_after_s)  # the page asks again by itself
    return answer


class _Known(dict[str, str]):
    """Parameters of a path; what is not among them leads to the lists."""

    def __missing__(self, name: str) -> str:
        return ""


def _status(error: Exception) -> int:
    if isinstance(error, DrumtrueError):
        return error.status
    if isinstance(error, HTTPException):
        return error.status_code
    return 422 if isinstance(error, RequestValidationError | ValidationError) else 500


def _missing(error: Exception) -> str | None:
    """The parameter of the address that names nothing, stored or storable."""
    if isinstance(error, NotFound):
        return error.field
    if isinstance(error, RequestValidationError):
        places = [tuple(fault["loc"]) for fault in error.errors()]
        return next((str(place[1]) for place in places if len(place) > 1 and place[0] == "path"), None)
    return None
