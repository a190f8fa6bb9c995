"""`serve` answers and stops, `migrate` brings a database up to date, and errors are told in words."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest

from db import migrate
from service.cli.serving import GRACE_S

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


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_serve_answers_and_stops_when_told(tmp_path: Path, number: signal.Signals) -> None:
    log = tmp_path / "errors"
    with served(f"sqlite:///{tmp_path / 'new' / 'drumtrue.db'}", log) as (process, address):
        # The socket listens before the address is printed: the request waits for the start-up to end.
        with httpx2.Client(timeout=30) as client:
            health = client.get(f"{address}/health")
            assert (health.status_code, health.json()["status"]) == (200, "ok")
            process.send_signal(number)  # while the client keeps its connection
            process.wait(timeout=BOUND_S)
        # uvicorn stops in order and then lets the signal do its work.
        assert process.returncode in (0, -number, 128 + number), log.read_text()
    assert "Application shutdown complete" in log.read_text()
    assert "Traceback" not in log.read_text()


def test_migrate_twice(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'drumtrue.db'}"
    newest = migrate.newest_revision()
    first, second = ran("migrate", "--database-url", url), ran("migrate", "--database-url", url)
    assert (first.returncode, first.stdout) == (0, f"schema empty -> {newest}\n")
    assert (second.returncode, second.stdout) == (0, f"schema {newest}: up to date\n")
