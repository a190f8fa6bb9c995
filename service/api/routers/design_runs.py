"""Runs of design studies: begun, followed, stopped, read."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import Key, Limit, Offset, WorkDep, errors
from service.api.routers.live import BEAT_S, MAX_S, MAX_STREAMS, WAKE_S
from service.api.strict_json import StrictRoute
from service.errors import Unavailable
from service.messages import Message
from service.model.base import write_json
from service.model.design_run import DesignRun, DesignRunNow, DesignRunRequest
from service.runtime.change_feed import news
from service.runtime.context import AppContext
from service.runtime.shared_feed import feeds_of
from service.usecases.designs import runs

router = APIRouter(route_class=StrictRoute)
EVENT = {
    "type": "object",
    "description": "One event: its name, and a `DesignRunNow` document as JSON text.",
    "required": ["event", "data"],
    "properties": {
        "event": {"const": "progress"},
        "data": {
            "type": "string",
            "contentMediaType": "application/json",
            "contentSchema": {"$ref": "#/components/schemas/DesignRunNow"},
        },
    },
}
STREAM: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Events `progress`, each a `DesignRunNow` document; the last one when the run has ended.",
        "content": {"text/event-stream": {"schema": EVENT}},
    },
    503: {"description": "Too many streams are open."},
}


@router.post("/design-runs", status_code=201, tags=["designs"], responses=errors(404, 503))
def start_design_run(work: WorkDep, run: DesignRunRequest) -> DesignRun:
    """Begin to compute an optimum or a front; it goes on when the client hangs up.

    Units of the document, times in s.
    """
    return runs.start(work, run)


@router.get("/design-runs", tags=["designs"], responses=errors())
def list_design_runs(
    work: WorkDep,
    limit: Limit = 50,
    offset: Offset = 0,
    study_id: Annotated[str | None, Query(max_length=32, description="Only of this study.")] = None,
) -> tuple[DesignRun, ...]:
    """Runs, newest first. Units of each document, times in s."""
    return runs.find(work, limit, offset, study_id=study_id)


@router.get("/design-runs/{run_id}", tags=["designs"], responses=errors(404))
def get_design_run(work: WorkDep, run_id: Key) -> DesignRun:
    """A run, as far as it is, and what it found. Units of its document, times in s."""
    return runs.get(work, run_id)


@router.get("/design-runs/{run_id}/now", tags=["designs"], responses=errors(404))
def get_design_run_now(work: WorkDep, run_id: Key) -> DesignRunNow:
    """How far a run is. The value in the unit that is stated next to it, times in s."""
    return runs.now(work, run_id)


@router.delete("/design-runs/{run_id}", tags=["designs"], responses=errors(404))
def stop_design_run(work: WorkDep, run_id: Key) -> DesignRun:
    """Ask a run to stop with what it has; one that has ended stays as it is. Units of its document, times in s."""
    return runs.stop(work, run_id)


@router.get(
    "/design-runs/{run_id}/events", tags=["designs"], responses=errors(404) | STREAM, response_class=StreamingResponse
)
async def follow_design_run(request: Request, work: WorkDep, run_id: Key) -> StreamingResponse:
    """Progress as server-sent events until the run has ended. Units as in `get_design_run_now`."""
    await run_in_threadpool(runs.now, work, run_id)
    state = request.app.state
    if getattr(state, "streams", 0) >= MAX_STREAMS:
        raise Unavailable(Message("too_many_streams.design_runs", most=MAX_STREAMS))
    return StreamingResponse(
        _stream(request, work, run_id),
        media_type="text/event-stream",
        headers={"cache-control": "no-store", "x-accel-buffering": "no"},
    )


async def _looks(work: AppContext, run_id: str) -> AsyncGenerator[DesignRunNow]:
    async with aclosing(news(work, (run_id,))) as waiting:
        while True:
            yield await run_in_threadpool(runs.now, work, run_id)
            await anext(waiting)


async def _stream(request: Request, work: AppContext, run_id: str) -> AsyncIterator[str]:
    """Each look that differs from the one before; ends with the run, the client, the server, or the time."""
    state = request.app.state
    state.streams = getattr(state, "streams", 0) + 1
    begun = spoke = work.monotonic()
    version, shown = 0, None
    try:
        async with feeds_of(state).following(("design run", run_id), lambda: _looks(work, run_id)) as feed:
            while work.monotonic() - begun < MAX_S:
                if (now := await feed.next(version, WAKE_S)) != version:
                    version, found = now, feed.value
                    if found != shown:
                        yield f"event: progress\ndata: {write_json(found)}\n\n"
                        shown, spoke = found, work.monotonic()
                    if found.state != "running":
                        return
                if work.monotonic() - spoke >= BEAT_S:
                    yield ": still there\n\n"
                    spoke = work.monotonic()
                if state.ending() or await request.is_disconnected():
                    return
    finally:
        state.streams -= 1
