"""What every request must keep before anybody looks who sent it: RFC 9110 and 9112 where a server has to choose."""

from __future__ import annotations

from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as AsgiMessage

from service.api.problems import problem
from service.messages import Message

MAX_TARGET_BYTES = 8192


class RequestRules:
    """Middleware that refuses what cannot be understood, and answers HEAD wherever GET is answered."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it with a problem."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        refused = _refusal(scope)
        if refused is not None:
            status, message, field = refused
            await problem(status, message, field=field)(scope, receive, send)
        elif scope["method"] == "HEAD":
            head = _Head(send, receive)
            # The server itself leaves the body out: it still has the method that was asked with.
            await self.app({**scope, "method": "GET"}, head.receive, head.send)
        else:
            await self.app(scope, receive, send)


class _Head:
    """An answer of which only the beginning is sent; what would go on without end is told that its client is gone."""

    def __init__(self, send: Send, receive: Receive) -> None:
        self._send, self._receive, self._over = send, receive, False

    async def send(self, message: AsgiMessage) -> None:
        if message["type"] == "http.response.start":
            await self._send(message)
        elif not self._over:
            self._over = True
            await self._send({"type": "http.response.body", "body": b"", "more_body": False})

    async def receive(self) -> AsgiMessage:
        return {"type": "http.disconnect"} if self._over else await self._receive()


_Refusal = tuple[int, Message, str]
"""Status, message, field."""


def _refusal(scope: Scope) -> _Refusal | None:
    target = scope.get("raw_path", b"")
    if len(target) + len(scope["query_string"]) > MAX_TARGET_BYTES:
        return 414, Message("target_too_long", most=MAX_TARGET_BYTES), "target"
    headers = Headers(scope=scope)
    hosts = headers.getlist("host")
    if len(hosts) > 1 or (not hosts and scope.get("http_version") == "1.1") or not _is_address(*hosts[:1]):
        return 400, Message("bad_host"), "host"
    if not all(origin == "null" or _is_origin(origin) for origin in headers.getlist("origin")):
        return 400, Message("bad_origin"), "origin"
    coding = ", ".join(headers.getlist("content-encoding")).strip().lower()
    if coding not in ("", "identity"):
        return 415, Message("content_coding", coding=coding), "content-encoding"
    return None


def _is_address(host: str = "") -> bool:
    try:
        parts = urlsplit(f"//{host}")
        return parts.netloc == host and parts.username is None and (parts.port is None or parts.port >= 0)
    except ValueError:
        return False


def _is_origin(origin: str) -> bool:
    try:
        return bool(urlsplit(origin).scheme)
    except ValueError:
        return False
