"""Everybody who works on the service, each in a thread of its own."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from service.chaos.field_bridge import FieldBridge
from service.chaos.load import MACHINE, PIECES, STOCK_G, Bridge, Caller, Technician

Worker = Bridge | Technician | FieldBridge


class Crew:
    """Bridges and technicians, each in a thread of its own, until they are told to end.

    urls: addresses of the services. field_urls: those under which the product's own bridge asks them; spools: its
    folder.
    """

    def __init__(
        self,
        urls: Sequence[str],
        bridges: int,
        technicians: int,
        seed: int,
        *,
        field_urls: Sequence[str],
        spools: Path,
    ) -> None:
        self._urls, self._field_urls = urls, field_urls
        self._seed = seed
        self._leaving = threading.Event()
        self._over = threading.Event()
        self.failures: list[str] = []
        self.interrupted = 0
        setup = Caller(urls, lambda: False, random.Random(seed))
        body = {"name": "box", "items": [{"mass_g": mass, "count": PIECES} for mass in STOCK_G]}
        self.box_id: str = setup.ask("POST", "/catalogues", body, "box").body["id"]
        self.bridges = [Bridge(f"bridge-{number}") for number in range(bridges)]
        self.field = FieldBridge("field", spools / "field.spool", random.Random(seed))
        machines = [
            setup.ask("POST", "/machines", {"name": f"drum {number}", **MACHINE}, f"drum-{number}").body["id"]
            for number in range(max(technicians, 1))
        ]
        for source in (*(bridge.source for bridge in self.bridges), self.field.source):
            setup.ask("PUT", f"/sources/{source}", {"machine_id": machines[0]})
        self.watched: str = setup.ask("POST", "/sessions", {"machine_id": machines[0]}, "watched").body["id"]
        """A session of the drum that the bridges measure: what it shows as present is looked at after faults."""
        self.technicians = [
            Technician(f"technician-{number}", machines[number], self.box_id, random.Random(seed + number))
            for number in range(technicians)
        ]
        setup.close()
        workers: list[Worker] = [*self.bridges, *self.technicians, self.field]
        self._threads = [threading.Thread(target=self._run, args=(n, one)) for n, one in enumerate(workers)]

    def start(self) -> None:
        """Begin to work."""
        for thread in self._threads:
            thread.start()

    def promised(self) -> int:
        """How much was acknowledged up to now; grows as long as the service answers."""
        return self.sent() + sum(len(one.sessions) for one in self.technicians)

    def sent(self) -> int:
        """How many readings were acknowledged."""
        return sum(bridge.acknowledged for bridge in self.bridges) + self.field.acknowledged

    def finish(self, patience_s: float) -> None:
        """Let everyone end what was begun; one that cannot within the time is a failure."""
        self._leaving.set()
        end = time.monotonic() + patience_s
        for thread in self._threads:
            thread.join(max(end - time.monotonic(), 0.1))
        self.release()

    def release(self) -> None:
        """Let everyone go at once; harmless when they have gone."""
        self._leaving.set()
        self._over.set()
        for thread in self._threads:
            if thread.is_alive():
                thread.join()

    def _run(self, number: int, worker: Worker) -> None:
        urls = self._field_urls if isinstance(worker, FieldBridge) else self._urls
        caller = Caller(urls, self._over.is_set, random.Random(1000 * self._seed + number))
        try:
            while not self._leaving.is_set():
                worker.work(caller)
        except Exception as wrong:  # whatever it is, the campaign has failed and says so
            self.failures.append(f"{type(wrong).__name__}: {wrong}")
        finally:
            self.interrupted += caller.interrupted
            caller.close()
