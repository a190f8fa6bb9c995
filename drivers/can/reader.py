"""Process that drains a bus: `python -m drivers.can.reader ADDRESS`, frames to its output until its input closes.

It decodes nothing and waits for no one: what its reader has not taken yet is kept here, up to minutes of a full bus.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time

from drivers.can.bus import BusAddress, bus_errors, open_bus
from drivers.can.frames import READY, packed
from drivers.errors import BusUnavailable

FLUSH_S = 0.005
"""How long a frame waits for others to go with it, at most."""
IDLE_S = 0.1
MAX_BYTES = 64 * 1024 * 1024
"""Six minutes of a full bus. What comes beyond is left out; the balancer's counters tell it."""
PIPE_BYTES = 1024 * 1024


def main() -> int:
    """Drain the bus named by the first argument. Status 1, and why, where it cannot be had or was lost."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to all; whoever started this ends it
    address = BusAddress(**json.loads(sys.argv[1]))
    _go_first()
    stop = threading.Event()
    threading.Thread(target=_stop_at_end_of_input, args=(stop,), daemon=True).start()
    try:
        drain(address, sys.stdout.fileno(), stop)
    except BusUnavailable as error:
        print(str(error).replace("\n", " "), file=sys.stderr)  # noqa: T201
        return 1
    return 0


def drain(address: BusAddress, out: int, stop: threading.Event) -> None:
    """Write the frames of a bus to a pipe, until stopped. Raises `BusUnavailable`, also where no one reads the pipe."""
    bus = open_bus(address)
    try:
        os.write(out, READY)
        _widen(out)
        os.set_blocking(out, False)
        waiting, written_at = bytearray(), time.monotonic()
        with bus_errors(address):
            while not stop.is_set():
                message = bus.recv(FLUSH_S if waiting else IDLE_S)
                now = time.monotonic()
                if message is not None and len(waiting) < MAX_BYTES:
                    waiting += packed(now, message)
                if waiting and (message is None or now - written_at >= FLUSH_S):
                    written_at = now
                    _write(out, waiting)
    finally:
        bus.shutdown()


def _go_first() -> None:
    """Ask for turns before all others, where this user may: it needs few, and one that comes late loses frames."""
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except (OSError, AttributeError):
        return


def _write(out: int, waiting: bytearray) -> None:
    """Hand over what the pipe takes now."""
    try:
        del waiting[: os.write(out, waiting[:PIPE_BYTES])]
    except BlockingIOError:
        return


def _widen(out: int) -> None:
    try:
        import fcntl  # POSIX alone has it

        fcntl.fcntl(out, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    except (ImportError, OSError, AttributeError):
        return  # as long as it is


def _stop_at_end_of_input(stop: threading.Event) -> None:
    while os.read(0, 1):
        continue
    stop.set()


if __name__ == "__main__":
    raise SystemExit(main())
