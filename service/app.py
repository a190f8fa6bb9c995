"""The application: lifespan, mounts, error documents."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI

from service import bootstrap
from service.api import openapi
from service.api.base_app import PREFIX, AppState, allow_threads, base_app, include_health
from service.api.routers import (
    arrangements,
    blocks,
    design_runs,
    design_studies,
    designs,
    history,
    live,
    machines,
    readings,
    sessions,
)
from service.runtime.context import AppContext
from service.settings import Settings
from service.web import pages
from service.web.routers import arrangements as arrangement_pages
from service.web.routers import designs as design_pages
from service.web.routers import reports

__all__ = ["PREFIX", "create_app"]


def create_app(settings: Settings, work: AppContext | None = None, state: AppState | None = None) -> FastAPI:
    """The application over a database; a `work` handed in is used as it is and closed by its owner.

    state: what it shares with another application that answers for the same service.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.work = work or bootstrap.build_work(settings)
        allow_threads()
        yield
        app.state.work.background.close()
        if work is None:
            app.state.work.database.close()

    app = base_app(settings, state or AppState(), lifespan, openapi.DESCRIPTION)
    # First what is asked most often.
    rooms = (readings, machines, sessions, arrangements, history, live, blocks)
    for room in (*rooms, designs, design_studies, design_runs):
        app.include_router(room.router, prefix=PREFIX)
    include_health(app)
    openapi.install(app)
    for files in (reports.files, arrangement_pages.files, design_pages.files):
        app.include_router(files, prefix=PREFIX, include_in_schema=False)
    pages.install(app)
    return app
