"""Computations that outlast the request that began them: a few threads of this process, each can be stopped."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from service.errors import Unavailable
from service.messages import Message

MAX_AT_ONCE = 2
"""Each takes a core for minutes: selections and readings need the others."""
RETRY_AFTER_S = 10
_log = logging.getLogger("drumtrue.background")

Stopped = Callable[[], bool]


class Background:
    """What runs beside the requests, by key."""

    def __init__(self, at_once: int = MAX_AT_ONCE) -> None:
        self._at_once = at_once
        self._lock = threading.Lock()
        self._running: dict[str, tuple[threading.Event, threading.Thread]] = {}

    def start(self, key: str, act: Callable[[Stopped], None]) -> None:
        """Begin `act` in a thread of its own; it asks now and then whether it is to stop.

        Raises Unavailable (`too_many_runs`) where as many run as may.
        """
        stop = threading.Event()
        thread = threading.Thread(target=self._run, args=(key, act, stop), name=f"run {key}", daemon=True)
        with self._lock:
            if len(self._running) >= self._at_once:
                raise Unavailable(Message("too_many_runs", most=self._at_once), retry_after_s=RETRY_AFTER_S)
            self._running[key] = (stop, thread)
        thread.start()

    def stop(self, key: str) -> None:
        """Ask one to stop; nothing where it does not run here."""
        with self._lock:
            found = self._running.get(key)
        if found is not None:
            found[0].set()

    def wait(self, key: str, timeout_s: float | None = None) -> None:
        """Wait until one has ended."""
        with self._lock:
            found = self._running.get(key)
        if found is not None:
            found[1].join(timeout_s)

    def close(self, timeout_s: float = 5.0) -> None:
        """Stop all and wait for them; others may be started afterwards."""
        with self._lock:
            found = list(self._running.values())
        for stop, _ in found:
            stop.set()
        for _, thread in found:
            thread.join(timeout_s)

    def _run(self, key: str, act: Callable[[Stopped], None], stop: threading.Event) -> None:
        try:
            act(stop.is_set)
        except Exception:
            _log.exception("run %s ended by an error", key)
        finally:
            with self._lock:
                self._running.pop(key, None)
