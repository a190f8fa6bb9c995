"""`serve` answers and stops, `migrate` brings a database up to date, and errors are told in words."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import httpx2
import pytest

from db import migrate
from drivers.simulator.example import threshing_drum_example
from service.cli.commands.serve import GRACE_S, _listening
from service.cli.support.demo_machine import machine_of
from service.errors import Conflict, InvalidInput
from service.settings import Settings

COMMAND = [sys.executable, "-m", "service"]
BOUND_S = GRACE_S + 15
"""A stop waits for GRACE_S at most; the rest is for a busy machine."""


def ran(*arguments: str) -> subprocess.CompletedProcess[str]:
    """A command that has ended."""
    return subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=60, check=False)


@contextmanager
def served(url: str, log: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A service on a free port, and its address; killed at the end if it is still there."""
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    command = [*COMMAND, "serve", "--port", "0", "--database-url", url]
    with log.open("w") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://[0-9.]+:\d+", line)
        assert found is not None, line + log.read_text()
        yield process, found.group()
    finally:
        process.kill()
        process.communicate()


def said_to(address: str, request: bytes) -> bytes:
    """All that is answered to bytes, until the service hangs up."""
    parts = urlsplit(address)
    with socket.create_connection((parts.hostname or "", parts.port or 0), timeout=30) as link:
        link.sendall(request)
        return b"".join(iter(lambda: link.recv(4096), b""))


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_serve_answers_and_stops_when_told(tmp_path: Path, number: signal.Signals) -> None:
    log = tmp_path / "errors"
    with served(f"sqlite:///{tmp_path / 'new' / 'drumtrue.db'}", log) as (process, address):
        # The socket listens before the address is printed: the request waits for the start-up to end.
        with httpx2.Client(timeout=30) as client:
            health = client.get(f"{address}/health")
            assert (health.status_code, health.json()["status"]) == (200, "ok")
            refused = said_to(address, b"GET /health HTTP/1.1\r\nhost: a\r\ncontent-length: abc\r\n\r\n")
            assert refused.startswith(b"HTTP/1.1 400 Bad Request\r\n")
            head, _, body = refused.partition(b"\r\n\r\n")
            assert b"content-type: application/problem+json" in head
            assert json.loads(body)["code"] == "bad_request"
            process.send_signal(number)  # while the client keeps its connection
            process.wait(timeout=BOUND_S)
        # uvicorn stops in order and then lets the signal do its work.
        assert process.returncode in (0, -number, 128 + number), log.read_text()
    assert "Application shutdown complete" in log.read_text()
    assert "Traceback" not in log.read_text()


def test_an_open_stream_does_not_keep_it_from_stopping_in_order(tmp_path: Path) -> None:
    log = tmp_path / "errors"
    with (
        served(f"sqlite:///{tmp_path / 'drumtrue.db'}", log) as (process, address),
        httpx2.Client(base_url=f"{address}/api/v1", timeout=60) as client,
    ):
        machine = client.post("/machines", json=machine_of(threshing_drum_example(1), "drum")).json()["id"]
        session = client.post("/sessions", json={"machine_id": machine}).json()["id"]
        with client.stream("GET", f"/sessions/{session}/live") as stream:
            events = stream.iter_lines()
            assert next(events) == "event: live"
            process.send_signal(signal.SIGTERM)
            assert all(line == "" or line.startswith((":", "data:", "event:")) for line in events)
        process.wait(timeout=BOUND_S)
    assert "Application shutdown complete" in log.read_text()
    assert "Traceback" not in log.read_text()
    assert "CancelledError" not in log.read_text()
    assert "exceeded" not in log.read_text()  # nothing had to be cut off


@pytest.mark.parametrize("host", ["no.such.host.invalid", "203.0.113.7", "a" * 70])
def test_a_host_that_is_not_this_machine_is_told_as_such(host: str) -> None:
    with pytest.raises(Conflict, match="cannot listen on") as refused, _listening(host, 0):
        pass
    assert (refused.value.code, refused.value.field) == ("address_unknown", "host")


def test_a_port_that_is_taken_is_told_as_such() -> None:
    with _listening("127.0.0.1", 0) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(Conflict, match="in use") as refused, _listening("127.0.0.1", port):
            pass
    assert (refused.value.code, refused.value.field) == ("address_taken", "port")


def test_an_empty_database_address_is_refused_and_an_empty_variable_is_none() -> None:
    with pytest.raises(InvalidInput, match="address of the database must not be empty"):
        Settings.from_environment({}, database_url="")
    assert Settings.from_environment({"DRUMTRUE_DATABASE_URL": ""}) == Settings()


def test_migrate_twice(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'drumtrue.db'}"
    newest = migrate.newest_revision()
    first, second = ran("migrate", "--database-url", url), ran("migrate", "--database-url", url)
    assert (first.returncode, first.stdout) == (0, f"schema empty -> {newest}\n")
    assert (second.returncode, second.stdout) == (0, f"schema {newest}: up to date\n")
