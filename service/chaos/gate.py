"""What stands between clients and a service: a relay that can turn into a sign-in page, or break answers off."""

from __future__ import annotations

import random
import socket
import threading
from contextlib import suppress
from typing import Literal

Mode = Literal["open", "portal", "half_answers"]
PAGE = b"<html><title>Guest Wi-Fi</title><form>Accept the terms to go on</form></html>"
PORTALS: tuple[tuple[str, str, bytes], ...] = (
    ("200 OK", "text/html", PAGE),
    ("200 OK", "text/html", b""),
    ("204 No Content", "", b""),
    ("201 Created", "application/json", b"{}"),
    ("201 Created", "application/json", b'{"accepted": 1, "duplicates": 0}'),
    ("302 Found\r\nlocation: http://portal.example/", "text/html", PAGE),
    ("400 Bad Request", "text/html", PAGE),
    ("409 Conflict", "text/html", PAGE),
    ("413 Content Too Large", "text/html", PAGE),
    ("422 Unprocessable Content", "application/json", b'{"detail": "Accept the terms"}'),
)
"""Status and reason, media type, body: what stands between answers."""
MAX_HALF_BYTES = 400
_READ = 65_536


class Gate:
    """Listens on a port of its own and passes everything on to a service; `url` leads through it."""

    def __init__(self, port: int, rng: random.Random) -> None:
        self._port, self._rng = port, rng
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        self._mode: Mode = "open"
        self._open: set[socket.socket] = set()
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, name="gate", daemon=True).start()

    def become(self, mode: Mode) -> None:
        """Treat what comes from now on so; what is under way is cut off."""
        self._mode = mode
        self._cut()

    def close(self) -> None:
        """Let no one through any more."""
        _end(self._listener)
        self._cut()

    def _cut(self) -> None:
        with self._lock:
            ended, self._open = self._open, set()
        for one in ended:
            _end(one)

    def _accept(self) -> None:
        with suppress(OSError):  # closed
            while True:
                client, _ = self._listener.accept()
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        with self._lock:
            self._open.add(client)
        with suppress(OSError, ValueError):
            if self._mode == "portal":
                self._answer_as_portal(client)
            else:
                self._relay(client, self._mode)
        with self._lock:
            self._open.discard(client)
        _end(client)

    def _relay(self, client: socket.socket, mode: Mode) -> None:
        left = self._rng.randrange(MAX_HALF_BYTES) if mode == "half_answers" else None
        with socket.create_connection(("127.0.0.1", self._port)) as server:
            threading.Thread(target=_pass_on, args=(client, server), daemon=True).start()
            while answer := server.recv(_READ):
                client.sendall(answer[:left])
                left = None if left is None else left - len(answer)
                if left is not None and left <= 0:
                    break
            _end(server)

    def _answer_as_portal(self, client: socket.socket) -> None:
        """Answer requests, one after the other, all alike: the service never hears of them."""
        status, media_type, body = self._rng.choice(PORTALS)
        words = f"HTTP/1.1 {status}\r\ncontent-length: {len(body)}\r\n"
        words += f"content-type: {media_type}\r\n\r\n" if media_type else "\r\n"
        while _read_request(client):
            client.sendall(words.encode() + body)


def _read_request(client: socket.socket) -> bool:
    """Read one request whole; False where the client has gone."""
    read = b""
    while b"\r\n\r\n" not in read:
        more = client.recv(_READ)
        if not more:
            return False
        read += more
    head, _, body = read.partition(b"\r\n\r\n")
    lengths = [line.partition(b":")[2] for line in head.lower().split(b"\r\n") if line.startswith(b"content-length:")]
    left = int(lengths[0]) - len(body) if lengths else 0
    while left > 0 and (more := client.recv(_READ)):
        left -= len(more)
    return left <= 0


def _pass_on(source: socket.socket, sink: socket.socket) -> None:
    with suppress(OSError):
        while sent := source.recv(_READ):
            sink.sendall(sent)
    with suppress(OSError):
        sink.shutdown(socket.SHUT_WR)


def _end(one: socket.socket) -> None:
    with suppress(OSError):
        one.shutdown(socket.SHUT_RDWR)
    one.close()
