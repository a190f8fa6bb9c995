"""The application: lifespan, mounts, error documents."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from anyio import to_thread
from fastapi import FastAPI

from service import bootstrap
from service.api import openapi, problems
from service.api.auth import Guard
from service.api.headers import SecurityHeaders
from service.api.limits import BodyLimit
from service.api.request_rules import RequestRules
from service.api.routers import (
    arrangements,
    blocks,
    design_runs,
    design_studies,
    designs,
    health,
    history,
    live,
    machines,
    readings,
    sessions,
)
from service.api.telemetry import Observed
from service.runtime.context import AppContext
from service.settings import Settings
from service.usecases.access.login_throttle import LoginThrottle
from service.version import __version__
from service.web import pages
from service.web.routers import arrangements as arrangement_pages
from service.web.routers import reports

PREFIX = "/api/v1"
THREADS = 120
"""Requests that may wait for storage at once; while it hangs, others must still find a thread."""


def create_app(settings: Settings, work: AppContext | None = None) -> FastAPI:
    """The application over a database; a `work` handed in is used as it is and closed by its owner."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.work = work or bootstrap.build_work(settings)
        to_thread.current_default_thread_limiter().total_tokens = THREADS
        yield
        app.state.work.background.close()
        if work is None:
            app.state.work.database.close()

    app = FastAPI(
        title="Drumtrue",
        version=__version__,
        description=openapi.DESCRIPTION,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        generate_unique_id_function=lambda route: route.name,
    )
    app.state.ending = lambda: False  # who serves the application says when it is to end
    app.state.attempts = LoginThrottle(time.monotonic)
    app.add_middleware(BodyLimit, most=settings.max_body_bytes)
    app.add_middleware(Guard, loopback=settings.loopback)
    app.add_middleware(RequestRules)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(Observed)
    problems.install(app)
    # First what is asked most often.
    rooms = (readings, machines, sessions, arrangements, history, live, blocks)
    for room in (*rooms, designs, design_studies, design_runs, health):
        app.include_router(room.router, prefix=PREFIX)
    app.include_router(health.router, include_in_schema=False)
    for prefix in ("", PREFIX):
        app.include_router(health.probes, prefix=prefix, include_in_schema=False)
    openapi.install(app)
    for files in (reports.files, arrangement_pages.files):
        app.include_router(files, prefix=PREFIX, include_in_schema=False)
    pages.install(app)
    return app
