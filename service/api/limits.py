"""Refuse request bodies above the service's limit, and those that do not end in time."""

from __future__ import annotations

import asyncio

from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as AsgiMessage

from service.api.problems import problem
from service.messages import Message, Quantity

PATIENCE = 16
"""A body up to this many times too long is read and dropped: the client then sees the answer, not a reset."""

BODY_S = 60.0
"""How long a body may take."""
OF_ANYBODY = {"/login": 16_384, "/logout": 16_384, "/preferences": 16_384}
"""Bytes of a body that is read of somebody who is not known: two fields of a form."""
OF_ANYBODY_S = 10.0


class BodyLimit:
    """Middleware that answers 413 to a body longer than `most` bytes, 408 to one that does not come to its end.

    It never holds more than that; of those who need no token it holds less, for a shorter time.
    """

    def __init__(self, app: ASGIApp, most: int) -> None:
        self.app = app
        self.most = most

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Count the body while it comes in."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        most = min(self.most, OF_ANYBODY.get(scope["path"], self.most))
        patience_s = OF_ANYBODY_S if scope["path"] in OF_ANYBODY else BODY_S
        try:
            async with asyncio.timeout(patience_s):
                body, size = await _read(receive, most)
        except TimeoutError:
            await _late(patience_s)(scope, receive, send)
            return
        if body is None:
            return
        if size > most:
            await self._refuse(scope, receive, send, most)
            return
        given = False

        async def replay() -> AsgiMessage:
            nonlocal given
            if given:
                return await receive()
            given = True
            return {"type": "http.request", "body": body, "more_body": False}

        await self.app(scope, replay, send)

    async def _refuse(self, scope: Scope, receive: Receive, send: Send, most: int) -> None:
        response = problem(
            413,
            _too_large(scope["path"].rpartition("/")[2], most),
            value=most,
            headers={"connection": "close"},
        )
        await response(scope, receive, send)


def _too_large(subject: str, most: int) -> Message:
    if subject == "readings":
        return Message("too_large.body_of_readings", most=most)
    return Message("too_large.body_of_blocks" if subject == "blocks" else "too_large.body", most=most)


async def _read(receive: Receive, most: int) -> tuple[bytes | None, int]:
    """The body and its length, dropped where it is longer than `most`; None where the client is gone."""
    chunks: list[bytes] = []
    size, more = 0, True
    while more and size <= PATIENCE * most:
        message = await receive()
        if message["type"] != "http.request":
            return None, size
        chunk = message.get("body", b"")
        size += len(chunk)
        if size <= most:
            chunks.append(chunk)
        else:
            chunks.clear()
        more = message.get("more_body", False)
    return b"".join(chunks), size


def _late(patience_s: float) -> JSONResponse:
    return problem(
        408,
        Message("request_timeout", patience=Quantity(patience_s, "s")),
        value=patience_s,
        headers={"connection": "close"},
    )
