"""The firmware of a serial CAN adapter, on a pseudo-terminal: what python-can's `slcan` talks to."""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Sequence
from types import TracebackType
from typing import Self

import can


class Adapter:
    """Answers the commands of a host and, while the channel is open, passes frames both ways.

    Hosts send `O` twice and empty lines: it bears both. `said` is every command but frames, `sent` the frames.
    """

    def __init__(self) -> None:
        self._ours, theirs = os.openpty()
        tty.setraw(theirs)
        self.port = os.ttyname(theirs)
        self._theirs = theirs
        self._stop = threading.Event()
        self.opened = threading.Event()
        self.said: list[str] = []
        self.sent: list[str] = []
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        for end in (self._ours, self._theirs):
            os.close(end)

    def receive(self, frames: Sequence[can.Message]) -> None:
        """Frames from the bus, to the host."""
        self.write(b"".join(line_of(frame) for frame in frames))

    def write(self, data: bytes) -> None:
        """Anything, to the host."""
        while data:
            data = data[os.write(self._ours, data[:1024]) :]

    def _serve(self) -> None:
        rest = b""
        while not self._stop.is_set():
            if not select.select([self._ours], [], [], 0.02)[0]:
                continue
            *lines, rest = (rest + os.read(self._ours, 4096)).split(b"\r")
            for line in lines:
                self._take(line.decode())

    def _take(self, line: str) -> None:
        if line[:1] in ("t", "T", "r", "R"):
            self.sent.append(line)
            return
        self.said.append(line)
        if line == "O":
            self.opened.set()
        elif line == "C":
            self.opened.clear()


def line_of(frame: can.Message) -> bytes:
    """A frame as the firmware writes it."""
    kind = ("R" if frame.is_extended_id else "r") if frame.is_remote_frame else "T" if frame.is_extended_id else "t"
    identifier = f"{frame.arbitration_id:08X}" if frame.is_extended_id else f"{frame.arbitration_id:03X}"
    return f"{kind}{identifier}{frame.dlc}{bytes(frame.data).hex().upper()}\r".encode()
