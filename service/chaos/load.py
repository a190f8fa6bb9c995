"""Bridges and technicians at work on a service that goes away again and again; each writes down what it was promised.

Every request is sent again, the same with the same key, until it is answered: what is stored afterwards must be what
was acknowledged, once.
"""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any

import httpx2

from service.errors import DrumtrueError
from service.messages import Message

TIMEOUT_S = 60.0
PAUSE_S = 0.2
BATCH = 200
BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
PIECES = 60
STOCK_G = (10.0, 20.0, 50.0, 100.0, 200.0)
MACHINE: dict[str, Any] = {
    "service_speed_rpm": 460.0,
    "rotor_mass_kg": 120.0,
    "bearings": [{"name": "P", "axial_mm": -480.0}, {"name": "Q", "axial_mm": 440.0}],
    "planes": [
        {
            "name": name,
            "radius_mm": 330.0,
            "axial_mm": axial_mm,
            "positions_deg": [20.0 * hole for hole in range(1, 19)],
            "max_masses": 2,
        }
        for name, axial_mm in (("1", -330.0), ("2", 330.0))
    ],
    "sensors": [{"name": "P"}, {"name": "Q"}],
}


class GivenUp(DrumtrueError):
    """The campaign is over, or the service answered what no fault explains."""

    code = "given_up"


@dataclass
class Answer:
    """What the service said in the end, and how often it was asked."""

    status: int
    body: Any
    asked: int


class Caller:
    """Asks one of the replicas until one answers; a 5xx is no answer, a 4xx is."""

    def __init__(self, urls: Sequence[str], ended: Callable[[], bool], rng: random.Random) -> None:
        self._urls = list(urls)
        self.ended = ended
        self._rng = rng
        self._http = httpx2.Client(timeout=TIMEOUT_S, trust_env=False)
        self.interrupted = 0
        self.last = ""

    def ask(self, method: str, path: str, body: object = None, key: str | None = None) -> Answer:
        """The answer. Raises GivenUp where the campaign ends first."""
        headers = {} if key is None else {"idempotency-key": key}
        for asked in itertools.count(1):
            url = self.some_url()
            try:
                answer = self._http.request(method, f"{url}/api/v1{path}", json=body, headers=headers)
                # Another request with the same key is still under way: its answer is the one to wait for.
                busy = answer.status_code == 409 and answer.json().get("code") == "key_in_use"
                if answer.status_code < 500 and not busy:
                    return Answer(answer.status_code, answer.json(), asked)
                self.last = f"{answer.status_code} {answer.text[:300]}"
            except (httpx2.HTTPError, ValueError) as wrong:
                self.last = f"{type(wrong).__name__}: {wrong}"
            self.interrupted += 1
            if self.ended():
                raise GivenUp(Message("given_up.not_answered", method=method, path=path, last=self.last))
            time.sleep(PAUSE_S)
        raise AssertionError

    def some_url(self) -> str:
        """Address of one of the replicas."""
        return self._rng.choice(self._urls)

    def close(self) -> None:
        """Let go of the connections."""
        self._http.close()


@dataclass
class Bridge:
    """Sends batches of readings; amplitude and time follow from the sequence number. acknowledged: how many."""

    source: str
    acknowledged: int = 0

    def work(self, caller: Caller) -> None:
        """One batch, until it is acknowledged."""
        numbers = range(self.acknowledged + 1, self.acknowledged + BATCH + 1)
        answer = caller.ask("POST", "/readings", [reading(self.source, number) for number in numbers])
        if answer.status != 201 or answer.body["accepted"] + answer.body["duplicates"] != BATCH:
            raise GivenUp(Message("given_up.readings", source=self.source, status=answer.status, body=str(answer.body)))
        self.acknowledged += BATCH


@dataclass
class Technician:
    """Balances drum after drum from the shared box. sessions: the runs acknowledged of each, in order."""

    name: str
    machine_id: str
    box_id: str
    rng: random.Random
    sessions: dict[str, list[str]] = field(default_factory=dict)
    closed: list[str] = field(default_factory=list)
    fitted: dict[str, str] = field(default_factory=dict)
    refused: int = 0
    _keys: int = 0

    def work(self, caller: Caller) -> None:
        """One drum: runs, correction, plan, fitted; every other one is undone, every third session closed."""
        session = self._post(caller, "/sessions", {"machine_id": self.machine_id, "catalogue_id": self.box_id})["id"]
        self.sessions[session] = []
        for kind, on_rotor in (("initial", []), ("trial", [{"plane": "1", "mass_g": 100.0, "angle_deg": 20.0}])):
            readings = [{"sensor": name, "amplitude": self.rng.uniform(1.0, 9.0), "phase_deg": 30.0} for name in "PQ"]
            run = self._post(
                caller, f"/sessions/{session}/runs", {"kind": kind, "masses": on_rotor, "readings": readings}
            )
            self.sessions[session].append(run["id"])
        masses = [
            {"plane": name, "mass_g": self.rng.uniform(60.0, 260.0), "angle_deg": self.rng.uniform(0.0, 359.0)}
            for name in "12"
        ]
        asked = {"source": "balancer", "masses": masses}
        correction = self._post(caller, f"/sessions/{session}/corrections", asked)
        wanted = {"correction_id": correction["id"], "objective": "components", "time_limit_s": 5.0}
        plan = self._post(caller, f"/sessions/{session}/plans", wanted)
        if plan["status"] == "infeasible" or not self._fit(caller, session, plan["id"]):
            self.refused += 1
        elif self.rng.random() < 0.7:
            self._post(caller, f"/plans/{plan['id']}/unfit", {})
            del self.fitted[session]
        if self.rng.random() < 0.4:
            answer = caller.ask("PATCH", f"/sessions/{session}", {"state": "closed"})
            if answer.status != 200 and answer.asked == 1:
                raise GivenUp(
                    Message(
                        "given_up.closing", name=self.name, session=session, status=answer.status, body=str(answer.body)
                    )
                )
            self.closed.append(session)

    def _fit(self, caller: Caller, session: str, plan_id: str) -> bool:
        answer = caller.ask("POST", f"/plans/{plan_id}/fitted", {}, self._key())
        if answer.status == 409 and answer.body["code"] in ("out_of_stock", "stock_reserved"):
            return False
        if answer.status != 200:
            raise GivenUp(
                Message("given_up.mounting", name=self.name, plan=plan_id, status=answer.status, body=str(answer.body))
            )
        self.fitted[session] = plan_id
        return True

    def _post(self, caller: Caller, path: str, body: object) -> Any:
        answer = caller.ask("POST", path, body, self._key())
        if answer.status not in (200, 201):
            raise GivenUp(
                Message("given_up.posting", name=self.name, path=path, status=answer.status, body=str(answer.body))
            )
        return answer.body

    def _key(self) -> str:
        self._keys += 1
        return f"{self.name}-{self._keys}"


def reading(source: str, number: int) -> dict[str, Any]:
    """Reading number so and so of a source."""
    return {
        "source": source,
        "sequence": number,
        "taken_at": (BEGIN + timedelta(milliseconds=number)).isoformat(),
        "sensor": "P" if number % 2 else "Q",
        "amplitude": float(number),
        "phase_deg": number % 360,
    }
