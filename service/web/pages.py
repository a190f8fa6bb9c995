"""The pages on the application: routers, files, errors."""

from __future__ import annotations

from fastapi import Depends, FastAPI

from service.web import assets, problems
from service.web.form_tokens import require_form_token
from service.web.routers import api_document, home, login, preferences, reports

ROUTERS = (api_document.router, home.router, login.router, preferences.router, reports.router)


def install(app: FastAPI) -> None:
    """Put the pages at the root of an application; call it once the API is there."""
    for router in (assets.router, *ROUTERS):
        app.include_router(router, include_in_schema=False, dependencies=[Depends(require_form_token)])
    problems.install(app)
