"""The application before its routes: middleware, error documents, state."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field

from anyio import to_thread
from fastapi import FastAPI

from service.api import problems
from service.api.auth import Guard
from service.api.headers import SecurityHeaders
from service.api.limits import BodyLimit
from service.api.request_rules import RequestRules
from service.api.routers import health
from service.api.telemetry import Observed
from service.runtime.context import AppContext
from service.settings import Settings
from service.usecases.access.login_throttle import LoginThrottle
from service.version import __version__

PREFIX = "/api/v1"
THREADS = 120
"""Requests that may wait for storage at once; while it hangs, others must still find a thread."""


def allow_threads() -> None:
    """Let the running event loop have `THREADS` threads for requests."""
    to_thread.current_default_thread_limiter().total_tokens = THREADS


def not_ending() -> bool:
    """Whether the service ends; who serves the application says it better."""
    return False


@dataclass
class AppState:
    """What the requests of an application share."""

    ending: Callable[[], bool] = not_ending
    attempts: LoginThrottle = field(default_factory=lambda: LoginThrottle(time.monotonic))
    work: AppContext | None = None

    def put_on(self, app: FastAPI) -> None:
        """Make an application share it."""
        app.state.ending, app.state.attempts = self.ending, self.attempts
        if self.work is not None:
            app.state.work = self.work


def base_app(
    settings: Settings,
    state: AppState,
    lifespan: Callable[[FastAPI], AbstractAsyncContextManager[None]] | None = None,
    description: str = "",
) -> FastAPI:
    """An application without routes that checks, limits and observes every request."""
    app = FastAPI(
        title="Drumtrue",
        version=__version__,
        description=description,
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        generate_unique_id_function=lambda route: route.name,
    )
    state.put_on(app)
    app.add_middleware(BodyLimit, most=settings.max_body_bytes)
    app.add_middleware(Guard, loopback=settings.loopback)
    app.add_middleware(RequestRules)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(Observed)
    problems.install(app)
    return app


def include_health(app: FastAPI) -> None:
    """Put the service's own health at the root and under the prefix of the API."""
    app.include_router(health.router, prefix=PREFIX)
    app.include_router(health.router, include_in_schema=False)
    for prefix in ("", PREFIX):
        app.include_router(health.probes, prefix=prefix, include_in_schema=False)
