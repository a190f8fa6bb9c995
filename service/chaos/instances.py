"""The service as processes: killed, short of disk, or with a clock that is wrong."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import httpx2

from service.errors import Unavailable
from service.messages import Message

START_S = 600.0
STOP_S = 120.0
LAST_LINES = 5
FAKETIME = (
    "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1",
    "/usr/lib/aarch64-linux-gnu/faketime/libfaketime.so.1",
    "/usr/lib/faketime/libfaketime.so.1",
)


class Instance:
    """One `drumtrue serve` on a port of its own; its words go to a file."""

    def __init__(self, database_url: str, words: Path) -> None:
        with closing(socket.create_server(("127.0.0.1", 0))) as free:
            self.port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self._database_url = database_url
        self._words = words
        self._process: subprocess.Popen[bytes] | None = None

    def start(self, *, file_size_limit: int | None = None, clock: str | None = None) -> None:
        """Start, and return once it answers.

        file_size_limit: bytes above which no file may grow. clock: offset for libfaketime, such as -1d. Raises
        Unavailable where it ends or stays silent.
        """
        command = [sys.executable, "-m", "service", "serve", "--port", str(self.port)]
        command += ["--database-url", self._database_url]
        if file_size_limit is not None:
            command = ["prlimit", f"--fsize={file_size_limit}", "--", *command]
        extra = {} if clock is None else {"LD_PRELOAD": faketime() or "", "FAKETIME": clock, "DONT_FAKE_MONOTONIC": "1"}
        with self._words.open("ab") as words:
            self._process = subprocess.Popen(  # noqa: S603 - our own command
                command, stdout=words, stderr=subprocess.STDOUT, env={**os.environ, "DRUMTRUE_TOKEN": "", **extra}
            )
        end = time.monotonic() + START_S
        while not self._answers():
            if self._process.poll() is not None or time.monotonic() > end:
                raise Unavailable(Message("unavailable.port_not_started", port=self.port, said=self._last_words()))
            time.sleep(0.05)

    def alive_s(self, most_s: float) -> float:
        """How long it takes to say that it lives. Raises httpx2.HTTPError where that is much more than `most_s`."""
        begun = time.monotonic()
        httpx2.get(f"{self.url}/health/live", timeout=2.0 * most_s, trust_env=False).raise_for_status()
        return time.monotonic() - begun

    def kill(self) -> None:
        """End it as a crash does."""
        self._end(signal.SIGKILL)

    def stop(self) -> None:
        """SIGTERM, and kill -9 where that is not enough."""
        self._end(signal.SIGTERM)

    def _end(self, number: signal.Signals) -> None:
        if self._process is None:
            return
        self._process.send_signal(number)
        try:
            self._process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait(STOP_S)
        self._process = None

    def _last_words(self) -> str:
        # Here and now: the folder of a campaign goes with it.
        said = self._words.read_text(errors="replace").splitlines()
        return " | ".join(said[-LAST_LINES:]) or "nothing at all"

    def _answers(self) -> bool:
        try:
            return httpx2.get(f"{self.url}/health", timeout=30.0, trust_env=False).is_success
        except httpx2.HTTPError:
            return False


def faketime() -> str | None:
    """Where libfaketime is, if it is installed."""
    return next((path for path in FAKETIME if Path(path).exists()), None)
