"""The running session as a stream of events."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import Key, WorkDep, errors
from service.api.strict_json import StrictRoute
from service.errors import Unavailable
from service.messages import Message
from service.model.base import write_json
from service.runtime.change_feed import news
from service.runtime.context import AppContext
from service.runtime.shared_feed import feeds_of
from service.usecases.sessions import live
from service.usecases.sessions.live import Live

router = APIRouter(route_class=StrictRoute)

BEAT_S = 10.0
"""A comment so often keeps a quiet stream from being cut on its way."""
WAKE_S = 1.0
"""So often a stream looks whether its client is still there."""
MAX_STREAMS = 64
MAX_S = 3600.0
"""A stream ends after so long: the browser asks again by itself, from where it was."""

EVENT = {
    "type": "object",
    "description": "One event: its name, and a `Live` document as JSON text.",
    "required": ["event", "data"],
    "properties": {
        "event": {"const": "live"},
        "data": {
            "type": "string",
            "contentMediaType": "application/json",
            "contentSchema": {"$ref": "#/components/schemas/Live"},
        },
    },
}
STREAM: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Events `live`, each a `Live` document; the first at once, then one for every change.",
        "content": {"text/event-stream": {"schema": EVENT}},
    },
    503: {"description": "Too many streams are open."},
}


@router.get("/sessions/{session_id}/now", tags=["sessions"], responses=errors(404))
def get_now(work: WorkDep, session_id: Key) -> Live:
    """The newest readings of the session's machine and whether a run may be taken.

    Amplitudes in each sensor's unit and detection, phases in degrees in the machine's `phase_sense`, speed in r/min.
    """
    return live.look(work, session_id)


@router.get(
    "/sessions/{session_id}/live", tags=["sessions"], responses=errors(404) | STREAM, response_class=StreamingResponse
)
async def follow(
    request: Request,
    work: WorkDep,
    session_id: Key,
    events: Annotated[int, Query(ge=0, le=1_000_000, description="End after so many events; 0: go on.")] = 0,
) -> StreamingResponse:
    """The same as server-sent events, as it changes. Units as in `get_now`: the sensor's unit, degrees, r/min."""
    topics = await run_in_threadpool(live.topics, work, session_id)
    state = request.app.state
    if getattr(state, "streams", 0) >= MAX_STREAMS:
        raise Unavailable(Message("too_many_streams.live", most=MAX_STREAMS))
    stream = _stream(request, work, topics, events)
    return StreamingResponse(
        stream, media_type="text/event-stream", headers={"cache-control": "no-store", "x-accel-buffering": "no"}
    )


async def _looks(work: AppContext, topics: tuple[str, str]) -> AsyncGenerator[tuple[Live, str]]:
    """The session as it is seen, and as JSON: at first, and whenever something was stored of it, without end."""
    async with aclosing(news(work, topics)) as waiting:
        while True:
            found = await run_in_threadpool(live.look, work, topics[0])
            yield found, write_json(found)
            await anext(waiting)


async def _stream(request: Request, work: AppContext, topics: tuple[str, str], events: int) -> AsyncIterator[str]:
    """Each look that differs from the one before; end with the client, the server, the session, or the time."""
    state = request.app.state
    state.streams = getattr(state, "streams", 0) + 1
    begun = spoke = work.monotonic()
    sent, version, shown = 0, 0, None
    try:
        async with feeds_of(state).following(("live", topics), lambda: _looks(work, topics)) as feed:
            while work.monotonic() - begun < MAX_S:
                if (now := await feed.next(version, WAKE_S)) != version:
                    version = now
                    found, text = feed.value
                    if found != shown:
                        yield f"event: live\ndata: {text}\n\n"
                        shown, spoke, sent = found, work.monotonic(), sent + 1
                        if events and sent >= events:
                            return
                if work.monotonic() - spoke >= BEAT_S:
                    yield ": still there\n\n"
                    spoke = work.monotonic()
                if state.ending() or await request.is_disconnected():
                    return
    finally:
        state.streams -= 1
