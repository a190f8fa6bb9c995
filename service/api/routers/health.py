"""Whether the service is well."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from typing import Any

from fastapi import APIRouter, Response

from service.api.dependencies import WorkDep, errors
from service.api.strict_json import StrictRoute
from service.model.base import document
from service.runtime import health
from service.runtime.context import AppContext
from service.runtime.health import Readiness
from service.runtime.listeners import ListenerState
from service.usecases.readings import source_health
from service.version import __version__

router = APIRouter(route_class=StrictRoute)
probes = APIRouter()

PATIENCE_S = 3.0
"""A database that says nothing for so long is broken, whatever it is busy with."""


@document
class Health:
    """State of the service."""

    status: str
    """ok; degraded: a bus that the service listens to is not read now; broken: the database does not answer."""
    version: str
    """Version of Drumtrue."""
    database: str
    """ok, or what the database said."""
    listeners: tuple[ListenerState, ...] = ()
    """Each bus that the service listens to itself."""


GONE: dict[int | str, dict[str, Any]] = {503: {"model": Health, "description": "The database is gone."}}


@router.get("/health", tags=["health"], responses=errors() | GONE)
def get_health(work: WorkDep, response: Response) -> Health:
    """Ask the service and its database for a sign of life. There is no quantity with a unit."""
    try:
        with work.read() as store:
            store.ping()
    except Exception as broken:
        response.status_code = 503
        return Health(status="broken", version=__version__, database=type(broken).__name__)
    heard = work.listeners.states()
    status = "ok" if all(one.state == "listening" for one in heard) else "degraded"
    return Health(status=status, version=__version__, database="ok", listeners=heard)


@probes.get("/health/live")
async def get_liveness() -> dict[str, str]:
    """Whether the process turns its loop: a supervisor that hears nothing starts it again."""
    return {"status": "ok"}


@probes.get("/health/ready")
async def get_readiness(work: WorkDep, response: Response) -> Readiness:
    """Whether work can be sent here: ready, slow (the database answers late) or broken (503)."""
    # A thread of its own: the pool of the endpoints may be full of plans, which is no fault of the database.
    asked = asyncio.get_running_loop().create_future()
    threading.Thread(target=_ask, args=(work, asked), name="readiness", daemon=True).start()
    try:
        found: Readiness = await asyncio.wait_for(asked, PATIENCE_S)
    except TimeoutError:
        found = Readiness(status="broken", database=f"no answer within {PATIENCE_S:g} s", seconds=PATIENCE_S)
    response.status_code = 503 if found.status == "broken" else 200
    return found


def _ask(work: AppContext, asked: asyncio.Future[Readiness]) -> None:
    found = health.readiness(work)

    def answer() -> None:
        if not asked.done():
            asked.set_result(found)

    with suppress(RuntimeError):  # the loop is over
        asked.get_loop().call_soon_threadsafe(answer)


@probes.get("/metrics")
def get_metrics(work: WorkDep) -> Response:
    """What this process counted, and how far the sources are behind, in Prometheus' text format."""
    return Response(source_health.metrics(work), media_type="text/plain; version=0.0.4; charset=utf-8")
