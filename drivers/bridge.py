"""The bridge: a source of readings on one side, a service on the other, a spool between them.

Three threads, so that none waits for another: one reads the source, one puts what it read into the spool, and the one
that runs the bridge sends what is in the spool and forgets it once it is acknowledged. Delivery is at least once; the
service stores each (source, sequence) once.
"""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from drivers.checks import require
from drivers.clock import Clock
from drivers.errors import BusUnavailable, DeliveryFailed, DeliveryGivenUp, DeliveryRefused, SpoolFull
from drivers.http_out import ANSWERS_PATH, HttpOut
from drivers.intake import Intake
from drivers.protocol import Driver
from drivers.reading import Answer, Entry, Mark
from drivers.spool import ANSWER, Spool, Spooled

FIRST_PAUSE_S = 0.5
LONGEST_PAUSE_S = 30.0
TICK_S = 0.02
"""How long a reading waits to be put into the spool, and a sent one to be followed by the next, at most."""
PUT_AT_ONCE = 2_000
FULL_PAUSE_S = 0.2
PAUSES_A_WORD = 50
"""How often a full spool is told again: every 10 s."""
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
            what = f"{len(readings)} readings, sequences {readings[0].sequence} to {readings[-1].sequence},"
            self._out.post_body(b"[" + ",".join(item.body for item in readings).encode() + b"]", what)
        for item in items:
            if item.kind == ANSWER:
                self._out.post_body(item.body.encode(), f"answer {item.sequence}", ANSWERS_PATH)

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
        pause, self._pause = self._pause, min(2.0 * self._pause, LONGEST_PAUSE_S)
        return pause * self._rng.uniform(0.5, 1.0)

    def reset(self) -> None:
        """Begin again with a short one."""
        self._pause = FIRST_PAUSE_S


class Bridge:
    """One source, one spool (open), one service. `run` ends when the stop is set, or with a source that ends.

    live: the source does not wait (a bus): what finds no place is counted and lost, where others are read later.
    patience: give up then, which is for a source that can be read again; None: a service may come back, and a source be
    bound, at any time. describe: what to add to the status line of the source's own.
    """

    def __init__(
        self,
        driver: Driver,
        spool: Spool,
        sender: Sender,
        *,
        stop: threading.Event,
        clock: Clock,
        rng: random.Random,
        report: Callable[[str], None],
        live: bool = True,
        batch_size: int = 2_000,
        status_s: float = 10.0,
        patience: Patience | None = None,
        describe: Callable[[], str] = str,
    ) -> None:
        require(batch_size >= 1, f"batch_size {batch_size}", "be 1 or more")
        self._driver, self._spool, self._sender = driver, spool, sender
        self._stop, self._clock, self._report, self._describe = stop, clock, report, describe
        self._batch_size, self._status_s = batch_size, status_s
        self._intake = Intake(live=live, stop=stop)
        self._pauses, self._bus_pauses = Backoff(rng), Backoff(rng)
        self._kept = threading.Event()
        self._ended = threading.Event()
        self._failure: BaseException | None = None
        self._away = ""
        self._answered = False
        self._refused = False
        self._waited_s = 0.0
        self._patience = patience
        self.totals = Totals()

    def offer(self, answer: Answer) -> None:
        """Take a balancer's own corrections: for the driver's `on_answer`."""
        self._intake.put(answer)

    def mark(self, mark: Mark) -> None:
        """Take how far the counters of the source's frames are: for the driver's `on_mark`."""
        self._intake.mark(mark)

    def run(self) -> Totals:
        """Bridge until stopped; the source is opened unless it is. Raises what opening it raises, and what ends it."""
        if self._driver.health().state == "closed":
            self._driver.open()
        threads = [
            threading.Thread(target=self._guarded, args=(work,), name=name, daemon=True)
            for work, name in ((self._take, "bridge source"), (self._keep, "bridge spool"))
        ]
        for thread in threads:
            thread.start()
        try:
            self._deliver()
            self._end(threads)
            self._send_once()
        finally:
            self._end(threads)
            self._sender.close()
        self._report(self.status())
        if self._failure is not None:
            raise self._failure
        if self._out_of_patience() and self._spool.waiting():
            raise DeliveryGivenUp(
                f"{self._away}\n  given up: {self._spool.waiting()} wait in the spool {self._spool.path}; "
                "put right what is told, and run the same command again"
            )
        return self.totals

    def _end(self, threads: Sequence[threading.Thread]) -> None:
        self._stop.set()
        self._driver.close()
        for thread in threads:
            thread.join()

    def status(self) -> str:
        """One line: what was taken, what waits, what the service and the source say."""
        totals = self.totals
        totals.taken, totals.overflowed = self._intake.taken, self._intake.overflowed
        health = self._driver.health()
        words = [f"taken {totals.taken}", f"waiting {self._spool.waiting()}", f"delivered {totals.delivered}"]
        for name, count in (
            ("missed", health.missed),
            ("refused", health.refused),
            ("overflowed", totals.overflowed),
            ("set aside", totals.set_aside),
            ("retries", totals.retries),
        ):
            words += [f"{name} {count}"] if count else []
        service = self._away or ("service answers" if self._answered else "service not asked yet")
        return ", ".join(one for one in (*words, service, self._describe()) if one)

    # ------------------------------------------------------------ source to spool
    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:
            self._failure = self._failure or error
            self._stop.set()

    def _take(self) -> None:
        try:
            while not self._stop.is_set():
                try:
                    for reading in self._driver:
                        self._intake.put(reading)
                        self._bus_pauses.reset()
                    return
                except BusUnavailable as error:
                    self._reopen(error)
        finally:
            self._intake.end()

    def _reopen(self, error: BusUnavailable) -> None:
        """Open a lost bus again, as often as it takes."""
        self._driver.close()
        while not self._stop.is_set():
            pause = self._bus_pauses.next_s()
            self._report(f"{error} Next attempt in {pause:.1f} s.")
            if self._clock.wait(self._stop, pause):
                return
            try:
                self._driver.open()
                return
            except BusUnavailable as again:
                error = again

    def _keep(self) -> None:
        try:
            while True:
                ended = self._intake.ended  # before the look: what was put last is then in
                batch = self._intake.take(PUT_AT_ONCE, TICK_S)
                if batch:
                    self._put(batch)
                elif ended:
                    return
        finally:
            self._ended.set()
            self._kept.set()

    def _put(self, batch: Sequence[Entry | Mark]) -> None:
        """Put a batch in pieces that fit, again and again while none does; given up only when the bridge is stopped."""
        size, pauses = len(batch), 0
        while batch:
            try:
                self.totals.kept += self._spool.put(batch[:size])
                batch = batch[size:]
                self._kept.set()
            except SpoolFull as error:
                if size > 1:
                    size //= 2
                    continue
                if pauses % PAUSES_A_WORD == 0:
                    self._report(f"FULL: {error}")
                pauses += 1
                if self._stop.is_set() and pauses > 1:
                    self._intake.lose(sum(not isinstance(one, Mark) for one in batch))
                    return
                size = len(batch)
                self._clock.wait(self._stop, FULL_PAUSE_S)

    # ------------------------------------------------------------ spool to service
    def _deliver(self) -> None:
        told = self._clock.now()
        while not self._stop.is_set():
            ended = self._ended.is_set()
            sent = self._send_once()
            if not sent and ended and not self._spool.waiting():
                return
            if (self._clock.now() - told).total_seconds() >= self._status_s:
                told = self._clock.now()
                self._report(self.status())
            if not sent and not self._stop.is_set():
                if self._out_of_patience():
                    return
                self._wait()

    def _out_of_patience(self) -> bool:
        if self._patience is None or not self._away:
            return False
        return self._waited_s >= (self._patience.refused_s if self._refused else self._patience.away_s)

    def _wait(self) -> None:
        """For the service to come back where it is away, else for something to send."""
        if self._away:
            pause = self._pauses.next_s()
            self.totals.retries += 1
            self._report(f"{self._away}; next attempt in {pause:.1f} s, {self._spool.waiting()} waiting")
            self._clock.wait(self._stop, pause)
            self._waited_s += pause
        else:
            self._kept.wait(10 * TICK_S)
            self._kept.clear()

    def _send_once(self) -> bool:
        """Send one batch; False where there is nothing to send, or it could not be."""
        try:
            items = self._spool.first(self._batch_size)
            if not items:
                return False
            self._send(items)
        except (DeliveryFailed, DeliveryRefused, SpoolFull) as error:
            self._refused = isinstance(error, DeliveryRefused)
            self._away = f"{'service refuses' if self._refused else 'service away'}: {error}"
            return False
        self._away, self._answered, self._waited_s = "", True, 0.0
        self._pauses.reset()
        return True

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
            self.totals.set_aside += 1
        else:
            self._spool.done(items)
            self.totals.delivered += len(items)
