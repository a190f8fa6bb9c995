"""Control port of a simulated drum: bolts masses on and off, sets speed and faults. The service never reads it.

    PUT /masses   [{"plane": "1", "mass_g": 100, "angle_deg": 40}, ...]   all pieces that are on now
    PUT /speed    {"speed_rpm": 460}
    PUT /faults   {"stuck": ["P"]}                                        all faults; {} heals everything
    PUT /new-run
    GET /state

Each answers the state as JSON; what is refused changes nothing and answers {status, title, detail}.
"""

from __future__ import annotations

import json
import sys
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import TCPServer
from typing import Any

from drivers.closeable import Openable
from drivers.errors import DriverError, InvalidSetting, PortUnavailable
from drivers.simulator.control_schema import COMMANDS, ControllableDrum, state_of

MAX_BYTES = 256 * 1024
MAX_DISCARDED = 16 * 1024 * 1024
MAX_DIGITS = 12
IDLE_SECONDS = 10.0
"""A client that says nothing for so long is cut off."""


class ControlPort(Openable):
    """The port, open within a with block or between `open` and `close`. port 0 takes a free one; see `url`."""

    def __init__(self, drum: ControllableDrum, host: str = "127.0.0.1", port: int = 0) -> None:
        self._drum = drum
        self._address = (host, port)
        self._server: _Server | None = None
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        """Address of the open port, e.g. `http://127.0.0.1:40123`; raises `PortUnavailable` when not open."""
        if self._server is None:
            raise PortUnavailable("the control port is not open: open it first")
        host, port = self._server.server_address[:2]
        return f"http://{host!s}:{port}"

    def open(self) -> None:
        """Listen; raises `PortUnavailable` if the address cannot be had, or is open already."""
        if self._server is not None:
            raise PortUnavailable(f"the control port is open already at {self.url}: close it first")
        host, port = self._address
        try:
            self._server = _Server(self._address, self._drum)
        except (OSError, OverflowError) as error:
            raise PortUnavailable(f"control port {host}:{port} cannot be opened ({error}): choose another") from error
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, name="control port", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Stop listening; harmless when closed."""
        server, thread = self._server, self._thread
        self._server = self._thread = None
        if server is not None and thread is not None:
            server.shutdown()
            thread.join()
            server.server_close()


class _Refused(Exception):
    """A request that is answered with an HTTP error."""

    def __init__(self, status: HTTPStatus, detail: str) -> None:
        super().__init__(detail)
        self.status = status


class _Server(ThreadingHTTPServer):
    """One thread a request, none of which outlives the process."""

    daemon_threads = True

    def __init__(self, address: tuple[str, int], drum: ControllableDrum) -> None:
        self.drum = drum
        super().__init__(address, _Handler)

    def server_bind(self) -> None:
        """Bind without the look-up of the host's name, which may wait for a name server."""
        TCPServer.server_bind(self)
        host, self.server_port = self.server_address[:2]
        self.server_name = str(host)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Let a client that went away go; print anything else."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = IDLE_SECONDS

    def _answer(self) -> None:
        status, kind = HTTPStatus.OK, "application/json"
        try:
            self._do(self.path.removeprefix("/"))
            body = state_of(self.server.drum)
        except (_Refused, DriverError) as error:
            status = error.status if isinstance(error, _Refused) else HTTPStatus.UNPROCESSABLE_ENTITY
            kind = "application/problem+json"
            body = {"status": int(status), "title": status.phrase, "detail": str(error)}
        content = json.dumps(body).encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    do_GET = do_PUT = do_POST = do_PATCH = do_DELETE = _answer  # noqa: N815

    def _do(self, name: str) -> None:
        body = self._body()
        if name != "state" and name not in COMMANDS:
            known = ", ".join(f"PUT /{one}" for one in COMMANDS)
            raise _Refused(HTTPStatus.NOT_FOUND, f"/{name} is not served: use GET /state, {known}")
        served = "GET" if name == "state" else "PUT"
        if self.command != served:
            raise _Refused(HTTPStatus.METHOD_NOT_ALLOWED, f"{self.command} /{name} is not served: use {served}")
        if name in COMMANDS:
            COMMANDS[name](self.server.drum, _parsed(body))

    def _body(self) -> bytes:
        stated = self.headers.get("Content-Length", "0")
        if not stated.isdecimal() or len(stated) > MAX_DIGITS or "Transfer-Encoding" in self.headers:
            raise _Refused(HTTPStatus.LENGTH_REQUIRED, f"Content-Length {stated!r} is no length: state it in bytes")
        length = int(stated)
        if length <= MAX_BYTES:
            return self.rfile.read(length)
        left = min(length, MAX_DISCARDED)
        while left > 0:  # a client that is still sending does not listen
            left -= len(self.rfile.read(min(left, MAX_BYTES))) or left
        raise _Refused(
            HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a body of {length} bytes is too large: at most {MAX_BYTES}"
        )

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Say nothing: the status line of the simulation is the place for that."""


def _parsed(body: bytes) -> object:
    if not body.strip():
        return None
    try:
        parsed: object = json.loads(body, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        if isinstance(error, InvalidSetting):
            raise
        raise _Refused(HTTPStatus.BAD_REQUEST, f"the body is not JSON ({error}): send JSON in UTF-8") from error
    return parsed


def _no_constant(name: str) -> object:
    raise InvalidSetting(f"the body holds {name}: give a finite number")
