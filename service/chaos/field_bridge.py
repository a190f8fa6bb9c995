"""The product's own bridge as one of the crew: a spool, a sender, and a clock that may be wrong."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

from drivers.bridge.delivery import Delivery, HttpSender, Totals
from drivers.bridge.http import HttpOut
from drivers.bridge.spool import Spool
from drivers.reading import Reading
from service.chaos.load import Caller, GivenUp
from service.messages import Message

PUT = 100
"""Readings that are kept at a time."""
PAUSE_S = 0.2
OFFSETS_S = (-10 * 365 * 86_400.0, -86_400.0, -300.0, 300.0, 86_400.0, 10 * 365 * 86_400.0)
"""How far a clock is made to be off: five minutes, a day, ten years."""
FAR_AHEAD_S = 3_600.0
"""One reading whose date is wrong by itself."""


@dataclass
class FieldBridge:
    """Keeps readings in a spool and sends them from there; what the spool let go of counts as acknowledged.

    offset_s: how far its clock is off; becomes next_offset_s before a batch is measured, so that a batch is dated and
    sent by one clock. odd: numbers of readings that were dated ahead of the clock of the source.
    """

    source: str
    spool: Path
    rng: random.Random
    acknowledged: int = 0
    offset_s: float = 0.0
    next_offset_s: float = 0.0
    odd: list[int] = field(default_factory=list)
    set_aside: int = 0

    def work(self, caller: Caller) -> None:
        """Readings from now into the spool, and from there to the service until it has them all."""
        self.offset_s = self.next_offset_s
        with Spool(self.spool) as spool:
            first = max(spool.highest(self.source), 0) + 1
            dated_ahead = self.rng.random() < 0.1
            spool.put([self._reading(number, dated_ahead) for number in range(first, first + PUT)])
            self.odd += [first] if dated_ahead else []
            totals = Totals()
            while spool.waiting():
                self._send(spool, totals, caller)
            self.set_aside += totals.set_aside
            self.acknowledged = first + PUT - 1

    def _send(self, spool: Spool, totals: Totals, caller: Caller) -> None:
        sender = HttpSender(HttpOut(caller.some_url(), now=self._now))
        try:
            delivery = Delivery(
                spool, sender, totals, rng=self.rng, report=lambda _line: None, batch_size=PUT, patience=None
            )
            if delivery.once():
                return
        finally:
            sender.close()
        caller.interrupted += 1
        caller.last = delivery.away
        if caller.ended():
            raise GivenUp(Message("given_up.spooled", source=self.source, waiting=spool.waiting(), last=delivery.away))
        time.sleep(PAUSE_S)

    def _now(self) -> datetime:
        return datetime.now(UTC) + timedelta(seconds=self.offset_s)

    def _reading(self, number: int, dated_ahead: bool) -> Reading:
        odd = timedelta(seconds=FAR_AHEAD_S if dated_ahead and number % PUT == 1 else 0.0)
        return Reading(
            source=self.source,
            sequence=number,
            taken_at=self._now() + odd,
            sensor="P" if number % 2 else "Q",
            amplitude=float(number),
            phase_deg=float(number % 360),
        )
