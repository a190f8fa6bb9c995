"""Deliver the spool to the service batch by batch, in order, retrying while it is away."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from drivers.bridge.http import HttpOut
from drivers.bridge.spool import ANSWER, Spool, Spooled
from drivers.checks import require
from drivers.errors import DeliveryFailed, DeliveryRefused, SpoolFull

FIRST_PAUSE_S = 0.5
MAX_PAUSE_S = 30.0
PER_ENTRY = frozenset({400, 409, 413, 422})
"""Refusals for what is in a batch; others (no such source, no permission) hold until someone sees to it."""


class Sender(Protocol):
    """The way to the service."""

    def send(self, items: Sequence[Spooled]) -> None:
        """Hand items over, all or in part; when it returns all are acknowledged. Raises a `DeliveryError`."""
        ...

    def close(self) -> None:
        """Let go of the connection."""
        ...


class HttpSender:
    """Sends what a `Spool` holds over HTTP."""

    def __init__(self, out: HttpOut) -> None:
        self._out = out

    def send(self, items: Sequence[Spooled]) -> None:
        """Post readings in one request and each answer in one. Raises a `DeliveryError`."""
        readings = [item for item in items if item.kind != ANSWER]
        if readings:
            body = b"[" + ",".join(item.body for item in readings).encode() + b"]"
            self._out.post_readings(body, readings[0].sequence, readings[-1].sequence, len(readings))
        for item in items:
            if item.kind == ANSWER:
                self._out.post_answer(item.body.encode(), item.sequence)

    def close(self) -> None:
        """Close the connection."""
        self._out.close()


@dataclass(slots=True)
class Totals:
    """What a bridge did since it started.

    taken: readings and answers read. kept: those put into the spool. overflowed: those that found no place and are
    lost. delivered: acknowledged by the service. set_aside: refused by it for what they are. retries: attempts that
    failed.
    """

    taken: int = 0
    kept: int = 0
    overflowed: int = 0
    delivered: int = 0
    set_aside: int = 0
    retries: int = 0


@dataclass(frozen=True, slots=True)
class Patience:
    """How many seconds a source that ends is gone on with.

    away_s: while the service is away. refused_s: while it refuses all, such as a source that is bound to no machine.
    """

    away_s: float = 60.0
    refused_s: float = 0.0


class Backoff:
    """Pauses that double, each drawn between half and all of it, so that many bridges do not come back at once."""

    def __init__(self, rng: random.Random) -> None:
        self._rng, self._pause = rng, FIRST_PAUSE_S

    def next_s(self) -> float:
        """The next pause."""
        pause, self._pause = self._pause, min(2.0 * self._pause, MAX_PAUSE_S)
        return pause * self._rng.uniform(0.5, 1.0)

    def reset(self) -> None:
        """Begin again with a short one."""
        self._pause = FIRST_PAUSE_S


class Delivery:
    """Sends what waits in a spool. away: why the service does not take it now, as text; empty where it does."""

    def __init__(
        self,
        spool: Spool,
        sender: Sender,
        totals: Totals,
        *,
        rng: random.Random,
        report: Callable[[str], None],
        batch_size: int,
        patience: Patience | None,
    ) -> None:
        require(batch_size >= 1, f"batch_size {batch_size}", "be 1 or more")
        self._spool, self._sender, self._totals = spool, sender, totals
        self._report, self._batch_size, self._patience = report, batch_size, patience
        self._pauses = Backoff(rng)
        self._answered = self._refused = False
        self._waited_s = 0.0
        self.away = ""

    def once(self) -> bool:
        """Send one batch; False where there is nothing to send, or it could not be."""
        try:
            items = self._spool.first(self._batch_size)
            if not items:
                return False
            self._send(items)
        except (DeliveryFailed, DeliveryRefused, SpoolFull) as error:
            self._refused = isinstance(error, DeliveryRefused)
            self.away = f"{'service refuses' if self._refused else 'service away'}: {error}"
            return False
        self.taken()
        return True

    def taken(self) -> None:
        """The service answers, and took what it was sent."""
        self.away, self._answered, self._waited_s = "", True, 0.0
        self._pauses.reset()

    def pause_s(self) -> float:
        """Seconds until the next attempt while the service is away; told, and counted."""
        pause = self._pauses.next_s()
        self._totals.retries += 1
        self._waited_s += pause
        self._report(f"{self.away}; next attempt in {pause:.1f} s, {self._spool.waiting()} waiting")
        return pause

    def out_of_patience(self) -> bool:
        """Whether a source that ends is to be given up for now."""
        if self._patience is None or not self.away:
            return False
        return self._waited_s >= (self._patience.refused_s if self._refused else self._patience.away_s)

    def state(self) -> str:
        """What the service says."""
        return self.away or ("service answers" if self._answered else "service not asked yet")

    def _send(self, items: Sequence[Spooled]) -> None:
        """Send items; where they are refused for what is in them, in halves, until the one is found and set aside."""
        try:
            self._sender.send(items)
        except DeliveryRefused as refused:
            if refused.status not in PER_ENTRY:
                raise
            if len(items) > 1:
                half = len(items) // 2
                self._send(items[:half])
                self._send(items[half:])
                return
            self._report(f"SET ASIDE: {refused}")
            self._spool.set_aside(items[0], str(refused))
            self._totals.set_aside += 1
        else:
            self._spool.done(items)
            self._totals.delivered += len(items)
