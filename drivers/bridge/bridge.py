"""The bridge: a source of readings on one side, a service on the other, a spool between them.

Three threads, so that none waits for another: one reads the source, one puts what it read into the spool, and the one
that runs the bridge sends what is in the spool and forgets it once it is acknowledged. A service that listens itself
takes batches past the spool (`drivers.bridge.direct_delivery`). Delivery is at least once; the service stores each
(source, sequence) once.
"""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Sequence

from drivers.bridge.delivery import Backoff, Delivery, Patience, Sender, Totals
from drivers.bridge.direct_delivery import DirectDelivery, Express
from drivers.bridge.read_buffer import Intake
from drivers.bridge.spool import Spool
from drivers.clock import Clock
from drivers.errors import BrokenSource, BusUnavailable, DeliveryGivenUp, SpoolFull
from drivers.protocol import Driver
from drivers.reading import Answer, Entry, Mark

TICK_S = 0.1
"""How long a reading waits for others to be kept with it, at most: a disk should not be asked for each."""
IDLE_S = 0.2
"""How long an empty spool goes on unasked."""
PUT_AT_ONCE = 5_000
FULL_PAUSE_S = 0.2
SPOOL_GONE = "SPOOL GONE: {path} was deleted or replaced, what waits is lost when this ends; start the bridge again"
PAUSES_A_WORD = 50
"""How often a full spool is told again: every 10 s."""


class Bridge:
    """One source, one spool (open), one service. `run` ends when the stop is set, or with a source that ends.

    live: the source does not wait (a bus): what finds no place is counted and lost, where others are read later.
    patience: give up then, which is for a source that can be read again; None: a service may come back, and a source be
    bound, at any time. describe: what to add to the status line of the source's own. direct: a way that needs no spool
    before it, taken while nothing waits there.
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
        direct: DirectDelivery | None = None,
    ) -> None:
        self._driver, self._spool, self._sender = driver, spool, sender
        self._stop, self._clock, self._report, self._describe = stop, clock, report, describe
        self._status_s, self._live = status_s, live
        self._intake = Intake(live=live, stop=stop)
        self._bus_pauses = Backoff(rng)
        self._kept = threading.Event()
        self._ended = threading.Event()
        self._failure: BaseException | None = None
        self.totals = Totals()
        self.trouble: str | None = None
        """Why the source is not read now; None: it is."""
        self.reopened = 0
        """How often a lost source was opened again."""
        self._delivery = Delivery(
            spool, sender, self.totals, rng=rng, report=report, batch_size=batch_size, patience=patience
        )
        self._express = None if direct is None else Express(direct, self._kept.set)

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
            self._delivery.once()
        finally:
            self._end(threads)
            self._sender.close()
        self._report(self.status())
        if self._failure is not None:
            raise self._failure
        if self._delivery.out_of_patience() and self._spool.waiting():
            raise DeliveryGivenUp(
                f"{self._delivery.away}\n  given up: {self._spool.waiting()} wait in the spool {self._spool.path}; "
                "put right what is told, and run the same command again"
            )
        return self.totals

    def stop(self) -> None:
        """End `run`, from any thread."""
        self._stop.set()
        self._kept.set()

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
            ("reopened", self.reopened),
        ):
            words += [f"{name} {count}"] if count else []
        trouble = f"NOT READ: {self.trouble}" if self.trouble else ""
        spool = "" if self._spool.is_in_place() else SPOOL_GONE.format(path=self._spool.path)
        return ", ".join(one for one in (*words, spool, trouble, self._delivery.state(), self._describe()) if one)

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
                except Exception as error:
                    if isinstance(error, BrokenSource) or not (self._live or isinstance(error, BusUnavailable)):
                        raise  # a file that is wrong stays so; a bus goes on
                    self._reopen(error)
        finally:
            self._intake.end()

    def _reopen(self, error: Exception) -> None:
        """Open a lost bus again, as often as it takes, whatever it or its reader raised."""
        while not self._stop.is_set():
            self.trouble = str(error) or type(error).__name__
            pause = self._bus_pauses.next_s()
            self._report(f"{self.trouble} Next attempt in {pause:.1f} s.")
            if self._clock.wait(self._stop, pause):
                return
            try:
                self._driver.close()
                self._driver.open()
                self.reopened += 1
                self.trouble = None
                return
            except Exception as again:  # an adapter that is pulled raises anything
                error = again

    def _keep(self) -> None:
        try:
            while True:
                ended = self._intake.ended  # before the look: what was put last is then in
                batch = self._intake.take(PUT_AT_ONCE, TICK_S)
                if batch:
                    if not self._carried(batch):
                        self._put(batch)
                elif ended:
                    return
        finally:
            self._ended.set()
            self._kept.set()

    def _carried(self, batch: Sequence[Entry | Mark]) -> bool:
        """Whether a batch was stored past the spool."""
        if self._express is None or self._stop.is_set() or self._spool.waiting():
            return False
        return self._express.carry(batch)

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

    # ------------------------------------------------------------ to the service
    def _deliver(self) -> None:
        told, well = self._clock.now(), False
        while not self._stop.is_set():
            ended = self._ended.is_set()
            sent = self._delivered_directly() or self._delivery.once()
            if sent and not well:
                self._report(self.status())  # it goes, or goes again; and how many frames a pause has cost
            well = (well or sent) and not self._delivery.away
            if not sent and ended and not self._spool.waiting():
                return
            if (self._clock.now() - told).total_seconds() >= self._status_s:
                told = self._clock.now()
                self._report(self.status())
            if not sent and not self._stop.is_set():
                if self._delivery.out_of_patience():
                    return
                self._wait()

    def _delivered_directly(self) -> bool:
        count = None if self._express is None else self._express.deliver()
        if count is None:
            return False
        self.totals.delivered += count
        self._delivery.taken()
        return True

    def _wait(self) -> None:
        """For the service to come back where it is away, else for something to send."""
        if self._delivery.away:
            self._clock.wait(self._stop, self._delivery.pause_s())
        else:
            self._kept.wait(IDLE_S)
            self._kept.clear()
