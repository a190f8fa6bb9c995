"""Where the frames of a bus come from: the bus itself, or a process of its own that does nothing but drain it.

A queue in the kernel is short, and what it cannot hold is lost unseen. A thread beside others waits for its turn; a
process does not. So the bus is drained in one (`drivers.can.reader`), and its frames are decoded here.
"""

from __future__ import annotations

import json
import os
import select
import struct
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import asdict
from typing import Protocol

import can

from drivers.can.bus import BusAddress, open_bus
from drivers.errors import BusUnavailable

Frame = tuple[float | None, int, bool, bytes | bytearray, bool]
"""When it came (monotonic clock; None: just now), identifier, extended, data, whether it is a data frame."""

RECORD = struct.Struct("<dIBB8s")
"""A frame between processes: time, identifier, flags, length, data; of more than 8 bytes, what follows 8 at a time."""
EXTENDED, NO_DATA, CONTINUED = 1, 2, 4
PART = 8
READY = b"R"
"""The first byte a reader sends: the bus is open."""
AT_ONCE = 1000
"""Frames that a reader hands over at once, at most."""
CLOSE_S = 5.0


class Frames(Protocol):
    """Frames of an open bus."""

    def take(self, timeout_s: float) -> Sequence[Frame]:
        """What has come, in order; waits timeout_s where nothing has. Raises what the bus raises where it is lost."""
        ...

    def close(self) -> None:
        """Let go of the bus; a waiting `take` ends. Harmless when closed."""
        ...


def open_frames(address: BusAddress) -> Frames:
    """Frames of a bus, drained by a process of its own where the bus can be had from another. Raises `BusUnavailable`.

    A `virtual` bus exists within one process; a pipe that is not waited for is POSIX.
    """
    if address.interface == "virtual" or os.name != "posix":
        return FramesHere(open_bus(address))
    return FramesApart(address)


class FramesHere:
    """Frames of a bus that this process reads itself."""

    def __init__(self, bus: can.BusABC) -> None:
        self._bus = bus

    def take(self, timeout_s: float) -> Sequence[Frame]:
        """One frame, or none."""
        message = self._bus.recv(timeout_s)
        if message is None:
            return ()
        return ((None, message.arbitration_id, message.is_extended_id, message.data, holds_data(message)),)

    def close(self) -> None:
        """Shut the bus down."""
        self._bus.shutdown()


def holds_data(message: can.Message) -> bool:
    """Whether it is a data frame: neither remote nor error."""
    return not (message.is_error_frame or message.is_remote_frame)


def packed(at: float, message: can.Message) -> bytes:
    """A frame as records; one of CAN FD may take several."""
    flags = EXTENDED * message.is_extended_id | NO_DATA * (not holds_data(message))
    data = bytes(message.data)
    first = RECORD.pack(at, message.arbitration_id, flags, len(data), data[:PART])
    if len(data) <= PART:
        return first
    rest = (data[start : start + PART] for start in range(PART, len(data), PART))
    return first + b"".join(RECORD.pack(at, message.arbitration_id, CONTINUED, 0, part) for part in rest)


def unpacked(records: memoryview) -> tuple[list[Frame], int]:
    """Frames in whole records, and how many bytes of these they took: the last frame may go on in records to come."""
    frames: list[Frame] = []
    used = at_record = 0
    waiting = b""
    head: tuple[float, int, int, int] | None = None
    for at, identifier, flags, length, data in RECORD.iter_unpack(records):
        at_record += RECORD.size
        if flags & CONTINUED:
            waiting += data
            if head is None or len(waiting) < head[3]:
                continue
            at, identifier, flags, length = head
            data, head = waiting, None
        elif length > PART:
            head, waiting = (at, identifier, flags, length), data
            continue
        frames.append((at, identifier, bool(flags & EXTENDED), data[:length], not flags & NO_DATA))
        used = at_record
    return frames, used


class FramesApart:
    """Frames of a bus that a process of its own drains. It ends with this one, however this one ends."""

    def __init__(self, address: BusAddress) -> None:
        self._address = address
        self._lock = threading.Lock()
        self._rest = b""
        command = [sys.executable, "-m", "drivers.can.reader", json.dumps(asdict(address))]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, bufsize=0)  # noqa: S603
        assert self._process.stdout is not None  # noqa: S101
        self._out = self._process.stdout
        if self._out.read(1) != READY:
            words = self._last_words()
            self.close()
            raise BusUnavailable(words)

    def take(self, timeout_s: float) -> Sequence[Frame]:
        """Up to 1,000 frames, with the times at which they were taken from the bus. Raises `BusUnavailable`."""
        with self._lock:
            if self._out.closed or not select.select([self._out], [], [], timeout_s)[0]:
                return ()
            found = self._out.read(AT_ONCE * RECORD.size)
        if not found:
            raise BusUnavailable(self._last_words())
        found = self._rest + found
        whole = len(found) - len(found) % RECORD.size
        frames, used = unpacked(memoryview(found)[:whole])
        self._rest = found[used:]
        return frames

    def close(self) -> None:
        """End the process: it sees its way in closed."""
        process = self._process
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(CLOSE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        with self._lock:
            for pipe in (process.stdout, process.stderr):
                if pipe is not None:
                    pipe.close()

    def _last_words(self) -> str:
        """Why the reader ended, as it says itself."""
        stderr = self._process.stderr
        said = b"" if stderr is None or stderr.closed else stderr.read()
        lines = [line for line in said.decode(errors="replace").splitlines() if line.strip()]
        return lines[-1] if lines else f"{self._address} is no longer read: its reader has ended; open it again"
