"""What a page of a session follows: live values as text in the reader's units, and whether the session went on."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncGenerator, AsyncIterator
from math import inf
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from service.engine.validation import highest_speed
from service.errors import Unavailable
from service.messages import Message
from service.runtime.context import AppContext
from service.runtime.shared_feed import feeds_of
from service.usecases.sessions import live
from service.usecases.sessions.live import Live
from service.web.preferences import Preferences
from service.web.rendering import LongPageDep, Page
from service.web.routers.session_steps import Key
from service.web.session import pictures
from service.web.session.guide import Guide, look
from service.web.session.steps import scales

router = APIRouter(prefix="/sessions/{session_id}")

INTERVAL_S = 0.5
MAX_S = 3600.0
WAKE_S = 1.0
"""So often a stream looks whether its client is still there."""
MAX_STREAMS = 64
FRESH_S = 4.0
"""A reading measured longer ago, by the service's clock, is stale: a source delivers each second or faster."""
UNKNOWN = "clock_unknown"
"""Nothing to say of a source that has sent nothing yet."""


@router.get("/stream")
async def follow_page(request: Request, page: LongPageDep, session_id: Key) -> StreamingResponse:
    """Server-sent events `now`: every half second, changed or not, so that silence means a lost link."""
    await run_in_threadpool(look, page.work, session_id)
    state = request.app.state
    if getattr(state, "page_streams", 0) >= MAX_STREAMS:
        raise Unavailable(Message("too_many_streams.pages", most=MAX_STREAMS))
    return StreamingResponse(
        _events(request, page, session_id),
        media_type="text/event-stream",
        headers={"cache-control": "no-store", "x-accel-buffering": "no"},
    )


async def _events(request: Request, page: Page, session_id: str) -> AsyncIterator[str]:
    state = request.app.state
    state.page_streams = getattr(state, "page_streams", 0) + 1
    begun, version = page.work.monotonic(), 0
    try:
        async with feeds_of(state).following(("page", session_id), lambda: _looks(page.work, session_id)) as feed:
            while page.work.monotonic() - begun < MAX_S:
                if (now := await feed.next(version, WAKE_S)) != version:
                    version = now
                    yield await run_in_threadpool(feed.value.event, page)
                if state.ending() or await request.is_disconnected():
                    return
    finally:
        state.page_streams -= 1


async def _looks(work: AppContext, session_id: str) -> AsyncGenerator[_Look]:
    """The session and its live values, each half second, without end."""
    while True:
        yield await run_in_threadpool(_look, work, session_id)
        await asyncio.sleep(INTERVAL_S)


def _look(work: AppContext, session_id: str) -> _Look:
    guide = look(work, session_id)
    now = live.look(work, session_id, guide.turning_since)
    age = inf if now.measured_at is None else (work.now() - now.measured_at).total_seconds()
    return _Look(guide, now, age)


class _Look:
    """What all pages of a session show at one moment; said once for all readers of one language and units."""

    def __init__(self, guide: Guide, now: Live, age_s: float) -> None:
        self._guide, self._now, self._age_s = guide, now, age_s
        self._events: dict[Preferences, str] = {}

    def event(self, page: Page) -> str:
        """The event as it is sent."""
        if page.preferences not in self._events:
            self._events[page.preferences] = f"event: now\ndata: {json.dumps(self._said(page))}\n\n"
        return self._events[page.preferences]

    def _said(self, page: Page) -> dict[str, Any]:
        guide, now = self._guide, self._now
        fastest = max((s.speed_rpm for s in now.sensors if s.speed_rpm is not None), default=None)
        return {
            "stamp": guide.stamp,
            "stale": self._age_s > FRESH_S,
            "steady": now.ready,
            "clocks": [
                page.words(clock.message_data) for clock in now.clocks if clock.message_data and clock.code != UNKNOWN
            ],
            "speed": page.display.measured_speed(fastest),
            "too_fast": fastest is not None and fastest > highest_speed(guide.session.machine),
            "sensors": [_sensor(page, guide, one) for one in now.sensors],
        }


def _sensor(page: Page, guide: Guide, now: live.SensorNow) -> dict[str, Any]:
    sensor = guide.sensor(now.sensor)
    beyond = now.amplitude > scales(guide)[now.sensor]
    unit = page.display.amplitude_unit(sensor)
    return {
        "name": now.sensor,
        "amplitude": page.display.number(unit.show(now.amplitude)),
        "stored": now.amplitude,
        "larger": pictures.larger_dial(guide.session, sensor.name, now.amplitude, page.preferences) if beyond else None,
        "phase": page.display.angle(now.phase_deg),
        "turn": None if now.phase_deg is None else round(pictures.phase_sign(guide.session) * now.phase_deg, 1),
        "steady": now.steady,
        "why_not": page.words(now.why_not_data),
    }
