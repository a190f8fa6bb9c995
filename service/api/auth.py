"""Authorization middleware: checks the token's scope before the body is read.

Who asks is told by a token (`authorization: Bearer`), else by the cookie of a login. On an address of this machine
alone, as long as no token was created, anyone at the machine may do everything; the first token that is created
counts within a second.
"""

from __future__ import annotations

import ipaddress
import re
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import cast
from urllib.parse import quote, urlsplit

from fastapi import FastAPI
from fastapi.routing import iter_route_contexts
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection, Request
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as AsgiMessage

from service.api.permissions import KEEPERS, OPERATIONS
from service.errors import DrumtrueError, Forbidden, Unauthorized
from service.messages import Message
from service.runtime.context import AppContext
from service.usecases.access import logins, tokens
from service.usecases.access.login_throttle import LoginThrottle
from service.usecases.access.tokens import LOCAL, Principal

COOKIE = "drumtrue_login"
API_PATHS = ("/api/", "/health", "/metrics", "/openapi.json")
SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
FORWARDED = ("forwarded", "x-forwarded-for", "x-forwarded-host")
LOOK_AGAIN_S = 1.0
"""A token that is revoked ends its streams within this time; to ask before each event costs more than the events."""
OPEN_S = 1.0
"""The first token that is created counts after this time at the latest."""
TO_CREATE = (
    "create a token (`drumtrue token create NAME --scope technician`) and send it as `authorization: Bearer dt_...`"
)


@dataclass(frozen=True)
class _Operation:
    """A route as it is matched: a mount takes every method."""

    name: str
    path: re.Pattern[str]
    methods: frozenset[str] | None


class Guard:
    """Middleware that refuses who may not; `request.state.principal` tells the others' names.

    loopback: the service listens on an address of this machine alone.
    """

    def __init__(self, app: ASGIApp, loopback: bool) -> None:
        self.app = app
        self.loopback = loopback
        self._operations: tuple[_Operation, ...] | None = None
        self._seen_in: AppContext | None = None
        self._open: tuple[AppContext, float] | None = None

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through, or answer it with a problem."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        try:
            principal = await self._admit(scope)
        except (DrumtrueError, HTTPException) as refused:
            response = await _refusal(Request(scope), refused)
            await response(scope, receive, send)
            return
        scope["state"]["principal"] = principal
        if principal is None:
            await self.app(scope, receive, send)
            return
        stream = _Watched(lambda: self._identify(HTTPConnection(scope)), receive, send)
        await self.app(scope, stream.receive, stream.send)

    async def _admit(self, scope: Scope) -> Principal | None:
        """Who asks; None where no one needs to be. Raises Unauthorized, Forbidden or TooManyAttempts."""
        operation = self._operation(scope)
        scope.setdefault("state", {})["operation"] = operation
        request = HTTPConnection(scope)
        if scope["method"] not in SAFE and "authorization" not in request.headers:
            require_same_site(request)
        if operation is not None and operation not in OPERATIONS:
            raise Forbidden(Message("forbidden.operation", operation=operation))
        allowed = KEEPERS if operation is None else OPERATIONS[operation]
        if allowed is None:
            return None
        seen = self._seen_open(request)
        principal = seen if seen is not None else await run_in_threadpool(self._identify, request)
        if operation is None:
            raise self._no_operation(scope)
        if not allowed & principal.scopes:
            raise Forbidden(
                Message(
                    "scope_missing",
                    operation=operation,
                    allowed=sorted(allowed),
                    token=principal.name,
                    scopes=sorted(principal.scopes),
                )
            )
        return principal

    def _seen_open(self, request: HTTPConnection) -> Principal | None:
        """The caller, where a moment ago no token was created: to ask each time costs as much as the request."""
        work, attempts = _state(request)
        if self._open is None or self._open[0] is not work or attempts.monotonic() >= self._open[1]:
            return None
        _require_here(request)
        return LOCAL

    def _identify(self, request: HTTPConnection) -> Principal:
        work, attempts = _state(request)
        if self.loopback and self._seen_in is not work:
            if not tokens.needed(work):
                self._open = (work, attempts.monotonic() + OPEN_S)
                _require_here(request)
                return LOCAL
            self._seen_in = work  # tokens are never deleted: once there is one it need not be asked again
        kind, _, text = request.headers.get("authorization", "").partition(" ")
        if text:
            if kind.lower() != "bearer":
                raise tokens.unknown()
            return attempts.guarded(client_of(request), text, lambda: tokens.bearer(work, text))
        if cookie := request.cookies.get(COOKIE):
            return logins.logged_in(work, cookie)
        raise Unauthorized(Message("token_missing.none"))

    def _operation(self, scope: Scope) -> str | None:
        """The name of the route that will be taken, the first that matches path and method; None without one."""
        if self._operations is None:
            self._operations = tuple(
                _Operation(one.name or "", one.path_regex, frozenset(one.methods) if one.methods else None)
                for one in iter_route_contexts(cast(FastAPI, scope["app"]).routes)
            )
        path, method = scope["path"], scope["method"]
        for one in self._operations:
            if (one.methods is None or method in one.methods) and one.path.match(path):
                return one.name
        return None

    def _no_operation(self, scope: Scope) -> HTTPException:
        """No such address, or not with this method. Answered here: what was not matched never reaches the routes."""
        methods = {m for one in self._operations or () if one.path.match(scope["path"]) for m in one.methods or ()}
        if methods:
            return HTTPException(405, headers={"allow": ", ".join(sorted(methods))})
        return HTTPException(404)


class _Watched:
    """An answer that goes on as events: before one of them is sent, who asked is looked at again, once a second.

    Once refused, the stream ends and the application is told that its client is gone.
    """

    def __init__(self, identify: Callable[[], object], receive: Receive, send: Send) -> None:
        self._identify, self._receive, self._send = identify, receive, send
        self._events = self._over = False
        self._looked_at = -LOOK_AGAIN_S

    async def receive(self) -> AsgiMessage:
        """What the client sends."""
        return {"type": "http.disconnect"} if self._over else await self._receive()

    async def send(self, message: AsgiMessage) -> None:
        """Pass a part of the answer on."""
        if self._over:
            return
        if message["type"] == "http.response.start":
            self._events = Headers(raw=message["headers"]).get("content-type", "").startswith("text/event-stream")
        elif self._events and message.get("more_body") and time.monotonic() - self._looked_at >= LOOK_AGAIN_S:
            self._looked_at = time.monotonic()
            try:
                await run_in_threadpool(self._identify)
            except DrumtrueError:
                self._over = True
                message = {"type": "http.response.body", "body": b"", "more_body": False}
        await self._send(message)


def client_of(request: HTTPConnection) -> str:
    """The client's address; that which a proxy states is in it only where the proxy is trusted by a setting."""
    return request.client.host if request.client else "unknown"


def require_same_site(request: HTTPConnection) -> None:
    """Refuse what another site's page makes a browser send. Raises Forbidden.

    Browsers say where a request comes from (Fetch Metadata, else Origin) and pages cannot forge that; programs say
    nothing, and carry no login that could be abused.
    """
    site, origin = request.headers.get("sec-fetch-site"), request.headers.get("origin")
    if site is not None:
        own = site in ("same-origin", "none")
    else:
        own = origin is None or urlsplit(origin).netloc.lower() == request.headers.get("host", "").lower()
    if not own:
        raise Forbidden(Message("cross_site", site=origin or site), field="origin", value=origin)


def _require_here(request: HTTPConnection) -> None:
    """Without tokens: only who addresses this machine as itself. Raises Unauthorized.

    Neither a name that somebody made to point here gets in, nor a proxy that forwards strangers and says so.
    """
    host = urlsplit(f"//{request.headers.get('host', '')}").hostname or ""
    if is_loopback(host) and not any(name in request.headers for name in FORWARDED):
        return
    raise Unauthorized(Message("token_missing.remote", host=host), field="host", value=host)


@lru_cache(maxsize=256)
def is_loopback(host: str) -> bool:
    """Whether a name or address is this machine to itself."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost" or host.endswith(".localhost")


def _state(request: HTTPConnection) -> tuple[AppContext, LoginThrottle]:
    state = request.app.state
    return state.work, state.attempts


async def _refusal(request: Request, error: DrumtrueError | HTTPException) -> Response:
    """The refusal as the application answers errors; who asks for a page is sent to the login."""
    page = not request.url.path.startswith(API_PATHS) and "text/html" in request.headers.get("accept", "")
    if page and isinstance(error, Unauthorized) and request.method == "GET":
        query = f"?{request.url.query}" if request.url.query else ""
        return RedirectResponse(f"/login?back={quote(request.url.path + query, safe='')}", status_code=303)
    kind = DrumtrueError if isinstance(error, DrumtrueError) else HTTPException
    made = request.app.exception_handlers[kind](request, error)
    response = cast(Response, await made if isinstance(made, Awaitable) else made)
    if isinstance(error, Unauthorized):
        response.headers["www-authenticate"] = "Bearer"
    return response
