"""HTTP protocol errors as problem JSON, before the application sees the request.

Anybody on the network can open a connection: the head of a request must come within a time and a length, and only so
many connections wait for theirs.
"""

from __future__ import annotations

import asyncio
import time
from http import HTTPStatus
from typing import Any

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from service.api.problems import problem
from service.cli.support.pending_connections import PendingConnections
from service.messages import Message, Quantity

HEAD_S = 10.0
"""How long the head of a request may take, from the connection or its first byte on."""
MAX_HEAD_BYTES = 65_536
MAX_HEADERS = 200


class ProblemProtocol(HttpToolsProtocol):
    """The server's HTTP/1.1, that answers bytes which are no request of it with a problem."""

    pending = PendingConnections(time.monotonic)
    """Of this process."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._head_bytes = 0
        self._in_head, self._refused = True, False
        self._timer: asyncio.TimerHandle | None = None

    @property
    def _address(self) -> str:
        return self.client[0] if self.client else "unknown"

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Count the connection as one without a request."""
        super().connection_made(transport)
        self._await_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._head_is_over()
        super().connection_lost(exc)

    def give_up(self) -> None:
        """End the connection without a word: others need its place."""
        self._refused = True
        self.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Read on; the bytes of a head that is not whole yet are counted."""
        if self._refused:
            return
        if self._in_head and self._timer is None:
            self._await_head()
        self._head_bytes += len(data)
        super().data_received(data)
        if self._in_head and not self._refused and self._head_bytes > MAX_HEAD_BYTES:
            self._refuse_head()

    def on_message_begin(self) -> None:
        """A request begins."""
        super().on_message_begin()
        self._in_head = True

    def on_headers_complete(self) -> None:
        """Hand the request on, unless its head is too long."""
        self._in_head = False
        self._head_is_over()
        said = len(self.url) + sum(len(name) + len(value) for name, value in self.headers)
        if said > MAX_HEAD_BYTES or len(self.headers) > MAX_HEADERS:
            self._refuse_head()
        else:
            super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        """Pass a part of the body on."""
        if not self._refused:
            super().on_body(body)

    def on_message_complete(self) -> None:
        """The request is whole: what comes next is the head of another."""
        self._in_head, self._head_bytes = True, 0
        if not self._refused:
            super().on_message_complete()

    def send_400_response(self, msg: str) -> None:
        """Answer and hang up: where the next request would begin cannot be known. msg: the server's words."""
        if not self._refused:
            self._refuse(400, Message("bad_request", reason=msg.rstrip(".").lower()))

    def _await_head(self) -> None:
        self.pending.add(self, self._address)
        if not self._refused:
            self._timer = self.loop.call_later(HEAD_S, self._late)

    def _head_is_over(self) -> None:
        self.pending.discard(self)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _late(self) -> None:
        self.pending.count_late(self._address)
        if not self._head_bytes:
            self.give_up()
            return
        self._refuse(408, Message("request_timeout.head", patience=Quantity(HEAD_S, "s")))

    def _refuse_head(self) -> None:
        if not self.headers and b" " not in self.url and len(self.url) * 2 > self._head_bytes:
            self._refuse(414, Message("target_too_long.head"))
            return
        self._refuse(431, Message("head_too_long", bytes=MAX_HEAD_BYTES, headers=MAX_HEADERS))

    def _refuse(self, status: int, message: Message) -> None:
        """Answer with a problem and hang up."""
        self._refused = True
        self._head_is_over()
        answer = problem(status, message)
        head = [(b"connection", b"close"), *self.server_state.default_headers, *answer.raw_headers]
        reason = f"HTTP/1.1 {status} {HTTPStatus(status).phrase}".encode()
        lines = [reason, *(name + b": " + value for name, value in head), b""]
        self.transport.write(b"\r\n".join([*lines, bytes(answer.body)]))
        self.transport.close()
