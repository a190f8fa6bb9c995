"""`drumtrue serve --retain-days`: roll up old readings once a day."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from service.runtime.context import AppContext

DAY_S = 86_400.0
AGAIN_S = 3_600.0
"""After a database that did not answer."""
ACTOR = "retention"
_log = logging.getLogger("drumtrue.retention")


@contextmanager
def rolling_up(work: AppContext, days: int | None) -> Iterator[None]:
    """Roll up readings older than `days` at once and then daily, for the length of a block; None: never."""
    if days is None:
        yield
        return
    stop = threading.Event()
    thread = threading.Thread(
        target=daily, args=(work.acting(ACTOR), days, stop.wait, stop.is_set), name="retention", daemon=True
    )
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def daily(work: AppContext, days: int, wait: Callable[[float], bool], stopped: Callable[[], bool]) -> None:
    """Roll up until told to stop. wait: lets this many seconds pass and says whether to stop."""
    from service.usecases.readings import retention  # averages with numpy, which nothing else of a start needs

    while True:
        pause_s = DAY_S
        try:
            done = retention.retain(work, days, stopped)
        except Exception:
            _log.exception("old readings could not be rolled up; tried again in %.0f s", AGAIN_S)
            pause_s = AGAIN_S
        else:
            _log.info("%d readings rolled up into %d rows", done.readings, done.minutes)
        if wait(pause_s):
            return
