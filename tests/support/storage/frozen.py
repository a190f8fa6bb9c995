"""A link to PostgreSQL that can be frozen: what is sent goes nowhere, and nothing is closed."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from sqlalchemy.engine import make_url


class Link:
    """Passes bytes on between clients and the server while it is not frozen; `url` leads through it."""

    def __init__(self, url: str) -> None:
        there = make_url(url)
        folder = str(there.query.get("host", ""))
        self._server = (
            (folder, there.port or int(str(there.query.get("port", "5432")))) if folder else (there.host, there.port)
        )
        self._listener = socket.create_server(("127.0.0.1", 0))
        host, port = self._listener.getsockname()[:2]
        rest = {name: value for name, value in there.query.items() if name not in ("host", "port")}
        self.url = there.set(host=host, port=port, query=rest).render_as_string(hide_password=False)
        self._flowing = threading.Event()
        self._flowing.set()
        self._open: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def freeze(self) -> None:
        """From now on nothing passes."""
        self._flowing.clear()

    def thaw(self) -> None:
        """Let everything pass again, what was held first."""
        self._flowing.set()

    def close(self) -> None:
        """End all connections."""
        self.thaw()
        for one in (self._listener, *self._open):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def _accept(self) -> None:
        with suppress(OSError):  # closed
            while True:
                client, _ = self._listener.accept()
                server = self._connected()
                self._open += [client, server]
                for pair in ((client, server), (server, client)):
                    threading.Thread(target=self._pass_on, args=pair, daemon=True).start()

    def _connected(self) -> socket.socket:
        host, port = self._server
        if not str(host).startswith("/"):
            return socket.create_connection((str(host), int(port or 5432)))
        made = socket.socket(socket.AF_UNIX)
        made.connect(f"{host}/.s.PGSQL.{port}")
        return made

    def _pass_on(self, source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError):
            while sent := source.recv(65_536):
                self._flowing.wait()
                sink.sendall(sent)
        with suppress(OSError):
            sink.shutdown(socket.SHUT_WR)


@contextmanager
def linked(url: str) -> Iterator[Link]:
    """A link to the server of a database, closed at the end."""
    link = Link(url)
    try:
        yield link
    finally:
        link.close()
