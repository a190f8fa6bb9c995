"""Refuse request bodies above the service's limit, whatever their headers say."""

from __future__ import annotations

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.api.problems import problem

PATIENCE = 16
"""A body up to so many times too long is read to its end and dropped: the client then sees the answer, not a reset."""

_ADVICE = {
    "readings": "send readings in smaller batches",
    "blocks": "send shorter blocks, or fewer channels in each",
}


class BodyLimit:
    """Middleware that answers 413 to a body longer than `most` bytes and never holds more than that."""

    def __init__(self, app: ASGIApp, most: int) -> None:
        self.app = app
        self.most = most

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Count the body while it comes in."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        chunks: list[bytes] = []
        size, more = 0, True
        while more and size <= PATIENCE * self.most:
            message = await receive()
            if message["type"] != "http.request":
                return
            chunk = message.get("body", b"")
            size += len(chunk)
            if size <= self.most:
                chunks.append(chunk)
            else:
                chunks.clear()
            more = message.get("more_body", False)
        if size > self.most:
            await self._refuse(scope, receive, send)
            return
        body = b"".join(chunks)
        given = False

        async def replay() -> Message:
            nonlocal given
            if given:
                return await receive()
            given = True
            return {"type": "http.request", "body": body, "more_body": False}

        await self.app(scope, replay, send)

    async def _refuse(self, scope: Scope, receive: Receive, send: Send) -> None:
        response = problem(
            413,
            "too_large",
            f"the body is longer than {self.most} bytes",
            value=self.most,
            advice=_ADVICE.get(scope["path"].rpartition("/")[2], "leave out what is not needed, or send it in parts"),
            headers={"connection": "close"},
        )
        await response(scope, receive, send)
