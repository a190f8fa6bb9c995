"""A connection to PostgreSQL that waits for an answer only for a stated time.

A server that is stopped, or behind a link that swallows everything, answers nothing and closes nothing: time-outs of
the engine are kept by that very server, and those of TCP do not end while the kernel of the other machine lives.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from typing import Any

import psycopg

CONNECT_S = 2
"""How long a connection may take to be made, s; libpq counts whole seconds and takes 2 at least."""
PING_S = 2.0
"""How long an idle connection may take to show that it is alive, s."""


class BoundedConnection(psycopg.Connection[Any]):
    """Closed, with an OperationalError, where one exchange with the server takes longer than `patience_s` (s)."""

    patience_s: float | None = None
    monotonic: Callable[[], float] = staticmethod(time.monotonic)

    def wait(self, gen: Generator[Any, Any, Any], *args: Any, **kwargs: Any) -> Any:
        """Run the exchange with the server that `gen` is. Raises psycopg.OperationalError where it takes too long."""
        return super().wait(gen if self.patience_s is None else self._bounded(gen, self.patience_s), *args, **kwargs)

    def _bounded(self, gen: Generator[Any, Any, Any], patience_s: float) -> Generator[Any, Any, Any]:
        begun = self.monotonic()
        try:
            wanted = next(gen)
            while True:
                ready = yield wanted  # the driver tells by nothing being ready that it waited for a while
                if not ready and self.monotonic() - begun > patience_s:
                    self.close()
                    raise psycopg.OperationalError(f"the server gave no answer within {patience_s:g} s")
                wanted = gen.send(ready)
        except StopIteration as done:
            return done.value
