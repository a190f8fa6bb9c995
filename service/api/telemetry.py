"""Request telemetry: an identifier, the time taken, counters and one log line for each request."""

from __future__ import annotations

import logging
import re
import time
import uuid
from contextvars import ContextVar

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HEADER = "x-request-id"
REQUEST_ID: ContextVar[str | None] = ContextVar("request_id", default=None)
"""Of the request that is being answered; every line of the log carries it."""
_STATED = re.compile(r"[\w.:-]{1,64}", re.ASCII)
_SESSION = re.compile(r"/sessions/([\w-]{1,32})(?:/|$)", re.ASCII)
_log = logging.getLogger("drumtrue.requests")


class Observed:
    """Middleware around all others. A request's identifier is taken from its header if it is one, else made."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, and tell how it went."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        stated = Headers(scope=scope).get(HEADER, "")
        request_id = stated if _STATED.fullmatch(stated) else uuid.uuid4().hex
        reset, begun, status = REQUEST_ID.set(request_id), time.perf_counter(), 500

        async def sending(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)[HEADER] = request_id
            await send(message)

        try:
            await self.app(scope, receive, sending)
        finally:
            _tell(scope, status, time.perf_counter() - begun)
            REQUEST_ID.reset(reset)


def _tell(scope: Scope, status: int, seconds: float) -> None:
    state = scope.get("state", {})
    operation, principal = state.get("operation") or "none", state.get("principal")
    scope["app"].state.work.meters.answered(operation, status, seconds)
    if not _log.isEnabledFor(logging.INFO):
        return
    session = _SESSION.search(scope["path"])
    _log.info(
        "%s %s %s",
        scope["method"],
        operation,
        status,
        extra={
            "operation": operation,
            "method": scope["method"],
            "status": status,
            "ms": round(1000.0 * seconds, 2),
            "session_id": session and session.group(1),
            "who": principal and principal.name,
        },
    )
