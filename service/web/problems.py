"""Every error as a page in words, for a reader; programs get the problem document of the API as before."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from fastapi import FastAPI, Request, Response
from starlette.exceptions import HTTPException

from service.errors import DrumtrueError
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
    status = 500
    if isinstance(error, DrumtrueError | HTTPException):
        status = error.status if isinstance(error, DrumtrueError) else error.status_code
    elif type(error).__name__ in ("RequestValidationError", "ValidationError"):
        status = 422
    deliberate = isinstance(error, DrumtrueError)
    page = Page(request)
    return page.render(
        "problem.html",
        status=status,
        title=TITLES.get(status, UNKNOWN),
        detail=page.words(error.message) if isinstance(error, DrumtrueError) else None,
        advice=(page.words(error.advice) if isinstance(error, DrumtrueError) and error.advice else None)
        or (None if deliberate else ADVICE.get(status, UNKNOWN_ADVICE)),
    )
