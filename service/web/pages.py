"""The pages on the application: routers, files, errors."""

from __future__ import annotations

from fastapi import Depends, FastAPI, Request, Response

from service.web import assets, problems
from service.web.form_guard import Done, Stale
from service.web.form_tokens import require_form_token
from service.web.routers import (
    api_document,
    arrangements,
    boxes,
    designs,
    home,
    installed,
    listing,
    login,
    machines,
    parts,
    plans,
    preferences,
    reports,
    runs,
    session_steps,
    sources,
    stops,
    stream,
)

ROUTERS = (
    api_document.router,
    home.router,
    installed.router,
    login.router,
    preferences.router,
    listing.router,
    session_steps.router,
    runs.router,
    stops.router,
    plans.router,
    stream.router,
    machines.router,
    parts.router,
    arrangements.router,
    arrangements.files,
    boxes.router,
    sources.router,
    designs.pages,
    reports.router,
)


def install(app: FastAPI) -> None:
    """Put the pages at the root of an application; call it once the API is there."""
    for router in (assets.router, *ROUTERS):
        app.include_router(router, include_in_schema=False, dependencies=[Depends(require_form_token)])
    problems.install(app)
    for kind in (Stale, Done):
        app.add_exception_handler(kind, _answered)


def _answered(_request: Request, error: Exception) -> Response:
    assert isinstance(error, Stale | Done)  # noqa: S101
    return error.answer()
