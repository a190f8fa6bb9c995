"""Ending a command by SIGINT or SIGTERM."""

from __future__ import annotations

import signal
from collections.abc import Callable


def on_stop(act: Callable[[], None]) -> None:
    """Call `act` when the process is told to stop, instead of ending it."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: act())
