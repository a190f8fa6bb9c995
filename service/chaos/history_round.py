"""A round: two sessions, a box and a source that several clients work on at once, each request written down."""

from __future__ import annotations

import itertools
import random
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import httpx2

from service.chaos.history_checks import Event, Kind
from service.chaos.load import MACHINE, STOCK_G, Caller

CLIENTS = 8
PER_ROUND = 400
"""Requests of one round: its session stays small, and what is written down is checked and forgotten."""
TIMEOUT_S = 120.0
ITEM_G = 5_000.0
"""Pieces that no plan takes: only the bookings of the clients move them."""
MAX_MOVEMENTS = 150
MAX_RUNS = 30


class Round:
    """Two sessions, a box and a source that all clients work on at once; `events` are by what they are of."""

    def __init__(self, urls: Sequence[str], number: int, rng: random.Random, killed: bool) -> None:
        self._urls, self._name, self._rng, self._killed = list(urls), f"round-{number}", rng, killed
        self._events: dict[str, list[Event]] = {"fitted": [], "runs": [], "box": [], "source": []}
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._asked = itertools.count(1)
        self._booked = self._run = 0

    def events(self) -> dict[str, list[Event]]:
        """Let the clients work, read what is left, and return everything in the order of the answers."""
        self._prepare()
        for group in ("fitted", "runs"):
            self._read(_Client(self._urls, 0, self._rng), group)
        threads = [threading.Thread(target=self._work, args=(number,)) for number in range(1, CLIENTS + 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for url in self._urls:
            last = _Client([url], 0, self._rng, patient=True)
            for group in ("fitted", "runs"):
                self._read(last, group)
            self._read_stock(last)
            self._read_source(last)
            last.close()
        return self._events

    def _prepare(self) -> None:
        caller = Caller(self._urls, lambda: False, self._rng)
        items = [{"mass_g": mass, "count": 60} for mass in STOCK_G] + [{"mass_g": ITEM_G, "count": 1}]

        def made(path: str, body: object) -> Any:
            answer = caller.ask("POST", path, body, f"{self._name}-{path[-12:]}-{next(self._numbers)}")
            assert answer.status == 201, answer.body  # noqa: S101
            return answer.body

        self._box = made("/catalogues", {"name": self._name, "items": items})["id"]
        self._machines = [made("/machines", {"name": f"{self._name} {n}", **MACHINE})["id"] for n in (1, 2)]
        # An event as all others: a read beside the first binding of a client may still see this one.
        first = _Client(self._urls, 0, self._rng, patient=True)
        self._bind_to(first, self._machines[0])
        first.close()
        body = {"machine_id": self._machines[0], "catalogue_id": self._box}
        self._sessions = {group: made("/sessions", body)["id"] for group in ("fitted", "runs")}
        session = self._sessions["fitted"]
        masses = [
            {"plane": "1", "mass_g": 120.0, "angle_deg": 33.0},
            {"plane": "2", "mass_g": 90.0, "angle_deg": 190.0},
        ]
        correction = made(f"/sessions/{session}/corrections", {"source": "balancer", "masses": masses})
        plan = {"correction_id": correction["id"], "objective": "components", "time_limit_s": 5.0}
        self._plans = [made(f"/sessions/{session}/plans", {**plan, "seed": seed})["id"] for seed in (1, 2)]
        caller.close()

    def _work(self, number: int) -> None:
        client = _Client(self._urls, number, random.Random(f"{self._rng.random()}"))
        ways: dict[Callable[[_Client], None], int] = {
            lambda one: self._note(one, "fitted"): 12,
            lambda one: self._note(one, "runs"): 8,
            lambda one: self._read(one, "fitted"): 20,
            lambda one: self._read(one, "runs"): 10,
            self._fit: 12,
            self._unfit: 8,
            self._add_run: 6,
            self._book: 6,
            self._read_stock: 6,
            self._bind: 4,
            self._read_source: 4,
            self._send: 4,
        }
        while next(self._asked) <= PER_ROUND:
            (way,) = client.rng.choices(list(ways), list(ways.values()))
            way(client)
        client.close()

    # ------------------------------------------------------------ what a client does
    def _note(self, client: _Client, group: str) -> None:
        """Change the note on the version that was seen last by this client."""
        seen = client.seen.get(group)
        if seen is None:
            self._read(client, group)
            return
        note = f"{self._name}-{next(self._numbers)}"
        made = client.ask("PATCH", f"/sessions/{self._sessions[group]}", {"note": note}, if_match=seen)
        got = {"version": made.body["version"], "note": made.body["note"]} if made.done else {}
        self._add(group, made.event("note", note, {"note": note, "if_match": seen}, got))
        client.seen[group] = got.get("version")

    def _read(self, client: _Client, group: str) -> None:
        made = client.ask("GET", f"/sessions/{self._sessions[group]}")
        body, got = made.body, {}
        if made.done:
            got = {
                "version": body["version"],
                "note": body["note"],
                "runs": [run["id"] for run in body["runs"]],
                "fitted": body["fitted_plan_id"],
                "fitted_plans": [plan["id"] for plan in body["plans"] if plan["state"] == "fitted"],
            }
            client.seen[group] = body["version"]
        self._add(group, made.event("read", None, {}, got))

    def _fit(self, client: _Client) -> None:
        self._keyed(client, "fitted", "fit", f"/plans/{client.rng.choice(self._plans)}/fitted", {})

    def _unfit(self, client: _Client) -> None:
        self._keyed(client, "fitted", "unfit", f"/plans/{client.rng.choice(self._plans)}/unfit", {})

    def _add_run(self, client: _Client) -> None:
        with self._lock:
            self._run += 1
        if self._run <= MAX_RUNS:
            readings = [{"sensor": name, "amplitude": 3.0, "phase_deg": 30.0} for name in "PQ"]
            body = {"kind": "initial", "masses": [], "readings": readings}
            self._keyed(client, "runs", "run", f"/sessions/{self._sessions['runs']}/runs", body)

    def _book(self, client: _Client) -> None:
        with self._lock:
            self._booked += 1
        if self._booked <= MAX_MOVEMENTS:
            pieces = client.rng.randint(1, 5)
            body = {"kind": "received", "pieces": [{"mass_g": ITEM_G, "pieces": pieces}]}
            self._keyed(client, "box", "stock", f"/catalogues/{self._box}/stock", body, {"pieces": pieces})

    def _read_stock(self, client: _Client) -> None:
        made, got = client.ask("GET", f"/catalogues/{self._box}/stock?limit=200"), {}
        if made.done:
            (item,) = [one for one in made.body["items"] if one["mass_g"] == ITEM_G]
            of_item = [one for one in made.body["movements"] if one["mass_g"] == ITEM_G]
            if len(made.body["movements"]) < 200:
                # The box was made with one piece.
                got = {"on_hand": item["on_hand"] - 1, "moved": sum(one["pieces"] for one in of_item) - 1}
            else:
                got = {"on_hand": item["on_hand"] - 1, "moved": item["on_hand"] - 1}
        self._add("box", made.event("read_stock", None, {}, got))

    def _bind(self, client: _Client) -> None:
        self._bind_to(client, client.rng.choice(self._machines))

    def _bind_to(self, client: _Client, machine: str) -> None:
        made = client.ask("PUT", f"/sources/{self._name}", {"machine_id": machine})
        self._add("source", made.event("bind", None, {"machine": machine}, {}))

    def _read_source(self, client: _Client) -> None:
        made, got = client.ask("GET", "/sources"), {}
        if made.done:
            (machine,) = [one["machine_id"] for one in made.body if one["name"] == self._name]
            got = {"machine": machine}
        self._add("source", made.event("read_source", None, {}, got))

    def _send(self, client: _Client) -> None:
        """Readings that two clients send at once, or one again."""
        first = client.rng.randint(1, 40) * 3
        sequences = list(range(first, first + 3))
        body = [
            {
                "source": self._name,
                "sequence": number,
                "taken_at": datetime(2026, 1, 1, 0, number // 60, number % 60, tzinfo=UTC).isoformat(),
                "sensor": "P",
                "amplitude": float(number),
            }
            for number in sequences
        ]
        made = client.ask("POST", "/readings", body)
        got = {name: made.body[name] for name in ("accepted", "duplicates")} if made.done else {}
        self._add("source", made.event("readings", None, {"sequences": sequences}, got))

    def _keyed(
        self, client: _Client, group: str, kind: Kind, path: str, body: object, sent: dict[str, Any] | None = None
    ) -> None:
        """Ask, sometimes twice, with one key; without an answer, until there is one."""
        key = f"{self._name}-{next(self._numbers)}"
        left = 2 if client.rng.random() < 0.2 else 1
        while left:
            made = client.ask("POST", path, body, key=key)
            got = {"id": made.body["id"]} if kind == "run" and made.done else {}
            self._add(group, made.event(kind, key, sent or {}, got))
            unanswered = made.status is None or made.status == 503
            left -= not unanswered or not self._killed

    def _add(self, group: str, event: Event) -> None:
        with self._lock:
            self._events[group].append(event)


@dataclass
class _Made:
    client: int
    begun: float
    ended: float
    status: int | None
    body: Any

    @property
    def done(self) -> bool:
        return self.status is not None and 200 <= self.status < 300

    def event(self, kind: Kind, key: str | None, sent: dict[str, Any], got: dict[str, Any]) -> Event:
        ended = float("inf") if self.status is None else self.ended
        return Event(self.client, kind, self.begun, ended, self.status, key, sent, got)


class _Client:
    """One client: asks one of the services. seen: the version of each session that it knows."""

    def __init__(self, urls: Sequence[str], number: int, rng: random.Random, *, patient: bool = False) -> None:
        self._urls, self.number, self.rng, self._patient = urls, number, rng, patient
        self._http = httpx2.Client(timeout=TIMEOUT_S, trust_env=False)
        self.seen: dict[str, int | None] = {}

    def ask(
        self, method: str, path: str, body: object = None, *, key: str | None = None, if_match: int | None = None
    ) -> _Made:
        headers = {} if key is None else {"idempotency-key": key}
        if if_match is not None:
            headers["if-match"] = f'"{if_match}"'
        while True:
            begun = time.monotonic()
            status, answer = None, None
            try:
                found = self._http.request(
                    method, f"{self.rng.choice(self._urls)}/api/v1{path}", json=body, headers=headers
                )
                status, answer = found.status_code, found.json()
            except (httpx2.HTTPError, ValueError):
                time.sleep(0.05)
            if (status is not None and status != 503) or not self._patient:
                return _Made(self.number, begun, time.monotonic(), status, answer)

    def close(self) -> None:
        self._http.close()
