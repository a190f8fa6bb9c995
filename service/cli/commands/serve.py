"""The service on a socket: until it is stopped, or beside the command that needs it."""

from __future__ import annotations

import errno
import gc
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import uvicorn

from service import bootstrap
from service.api.auth import is_loopback
from service.cli.support.logs import log_as_json
from service.cli.support.problem_protocol import ProblemProtocol
from service.cli.support.retention import rolling_up
from service.early_app import EarlyApp
from service.errors import Conflict
from service.messages import Message
from service.runtime.context import AppContext
from service.settings import Settings
from service.usecases.access import tokens

if TYPE_CHECKING:
    from service.cli.commands.can_listener import CanListener

MAX_DESCRIPTORS = 65_536
PATIENCE_S = 4.0
"""How long PostgreSQL may take for one statement of a request before it counts as away."""
GRACE_S = 3
"""How long a stop waits for requests under way."""
YOUNG_OBJECTS = 10_000
"""This many more than before are looked through for garbage; with the usual 700 that is done every few requests."""


def serve_until_stopped(
    host: str,
    port: int,
    settings: Settings,
    ear: CanListener | None = None,
    log_format: str = "text",
) -> None:
    """Listen until SIGINT or SIGTERM, on a CAN bus too if one is named, and roll up old readings if they grow old.

    Raises Conflict for an address that is taken, a schema out of date, or an address beyond this machine without a
    token, `BusUnavailable` for a bus that cannot be had.
    """
    # uvicorn hands the signal on once it has stopped; by default that would end the process before its blocks end.
    signal.signal(signal.SIGTERM, _end)
    _raise_descriptors()
    with _listening(host, port) as listener, _working(settings) as work:
        address = listener.getsockname()
        settings = replace(settings, loopback=is_loopback(address[0]))
        _require_tokens(work, settings, address[0])
        print(f"Drumtrue on http://{address[0]}:{address[1]} (API document: /docs), sessions in {settings.shown}")
        server = _server(settings, "info", work, as_json=log_format == "json")
        with _heard(work, ear), rolling_up(work, settings.retain_days):
            server.run(sockets=[listener])


def _raise_descriptors() -> None:
    """As many open connections as the system allows: by default it is 1,024, and anybody may open as many."""
    if sys.platform != "win32":
        import resource

        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, MAX_DESCRIPTORS)), hard))


def _look_for_garbage_seldom() -> None:
    """What is loaded stays loaded: to look through it for garbage takes a tenth of a second, and all requests wait."""
    gc.freeze()
    gc.set_threshold(YOUNG_OBJECTS, 10, 10)


def _heard(work: AppContext, ear: CanListener | None) -> AbstractContextManager[None]:
    """A bus that is listened to, if one is named."""
    if ear is None:
        return nullcontext()
    from service.cli.commands.can_listener import listening

    return listening(work, ear)


def _require_tokens(work: AppContext, settings: Settings, address: str) -> None:
    """Raise Conflict where strangers could reach a service that asks no one for a token."""
    if not settings.loopback and not tokens.needed(work):
        raise Conflict(Message("token_missing.listening", address=address), field="host", value=address)


def _end(_number: int, _frame: object) -> None:
    raise SystemExit(0)


@contextmanager
def serving(settings: Settings) -> Iterator[str]:
    """The service on a free port of this machine for the length of a block; yields its address."""
    with _listening("127.0.0.1", 0) as listener, _working(settings) as work:
        settings = replace(settings, loopback=True)
        server = _server(settings, "warning", work)
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, name="service", daemon=True)
        thread.start()
        try:
            # The socket listens already: a request sent before start-up is over waits for it.
            yield f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            server.should_exit = True
            thread.join(GRACE_S + 5)


@contextmanager
def _working(settings: Settings) -> Iterator[AppContext]:
    """Everything the use cases need, made before the server: a database that cannot be used is told as text."""
    work = bootstrap.build_work(settings, patience_s=PATIENCE_S)
    try:
        yield work
    finally:
        work.database.close()


def _server(settings: Settings, log_level: str, work: AppContext, *, as_json: bool = False) -> uvicorn.Server:
    if as_json:
        log_as_json()
    app = EarlyApp(settings, work, lambda: server.should_exit, _look_for_garbage_seldom)
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            http=ProblemProtocol,
            log_level=log_level,
            access_log=False,
            log_config=None if as_json else uvicorn.config.LOGGING_CONFIG,
            timeout_graceful_shutdown=GRACE_S,
            proxy_headers=bool(settings.trusted_proxies),
            forwarded_allow_ips=settings.trusted_proxies,
        )
    )
    return server


def _cannot_listen(host: str, port: int, error: OSError | UnicodeError) -> Conflict:
    """The port is taken or not allowed, else the host is none of this machine."""
    reason = error.strerror or error if isinstance(error, OSError) else error
    number = error.errno if isinstance(error, OSError) and not isinstance(error, socket.gaierror) else None
    if number in (errno.EADDRINUSE, errno.EACCES):
        return Conflict(Message("address_taken", host=host, port=str(port), reason=reason), field="port", value=port)
    return Conflict(Message("address_unknown", host=host, reason=reason), field="host", value=host)


@contextmanager
def _listening(host: str, port: int) -> Iterator[socket.socket]:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, port))
        except (OSError, UnicodeError) as error:
            raise _cannot_listen(host, port, error) from error
        listener.listen(1024)
        yield listener
