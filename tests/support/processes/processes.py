"""Commands of the product as processes, started and waited for by what they print."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path


class Process:
    """One `drumtrue ...`; its output is read all the time and can be waited for."""

    def __init__(self, *arguments: str, file_size_limit: int | None = None) -> None:
        self.lines: list[str] = []
        self._news = threading.Condition()
        command = [sys.executable, "-m", "service", *arguments]
        if file_size_limit is not None:
            command = ["prlimit", f"--fsize={file_size_limit}", "--", *command]
        self.popen = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.popen.stdout is not None
        for line in self.popen.stdout:
            with self._news:
                self.lines.append(line.rstrip())
                self._news.notify_all()

    def wait_for(self, words: str, seconds: float = 90.0) -> str:
        """The first line with these words in it."""
        with self._news:
            found = self._news.wait_for(lambda: self._find(words) or self.popen.poll() is not None, seconds)
            line = self._find(words)
            assert line is not None, f"{words!r} {'did not come' if not found else 'never came'}: {self.lines[-20:]}"
            return line

    def _find(self, words: str) -> str | None:
        return next((line for line in self.lines if words in line), None)

    def kill(self) -> None:
        """kill -9."""
        self.popen.send_signal(signal.SIGKILL)
        self._end()

    def stop(self, seconds: float = 20.0) -> int:
        """SIGTERM, and the status it ends with."""
        self.popen.terminate()
        return self._end(seconds)

    def ended(self, seconds: float = 120.0) -> int:
        """The status it ends with by itself."""
        return self._end(seconds)

    def _end(self, seconds: float = 20.0) -> int:
        status = self.popen.wait(seconds)
        self._reader.join(seconds)
        if self.popen.stdout is not None:
            self.popen.stdout.close()
        return status


def serve(database: Path, port: int, *options: str) -> Process:
    """A service on a fixed port; waits until it answers."""
    service = Process("serve", "--port", str(port), "--database-url", f"sqlite:///{database}", *options)
    service.wait_for("Application startup complete")
    return service
