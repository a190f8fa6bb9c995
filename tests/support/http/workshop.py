"""A service in memory, a drum that is two linear equations, and what the tests of the API say to them."""

from __future__ import annotations

import atexit
import cmath
import hmac
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from functools import cache
from typing import Any

from anyio.from_thread import BlockingPortal, start_blocking_portal
from fastapi import FastAPI
from fastapi.testclient import TestClient
from sqlalchemy import func, select

from db.database import Database
from db.rows import Base
from drivers.clock import ManualClock
from service import bootstrap
from service.app import PREFIX, create_app
from service.runtime.context import AppContext
from service.settings import Settings
from service.usecases.access.login_throttle import LoginThrottle
from service.web import form_tokens

HERE = "http://localhost"
JSON = {"content-type": "application/json"}
PROBLEM_FIELDS = {
    "type",
    "title",
    "status",
    "code",
    "detail",
    "field",
    "value",
    "advice",
    "errors",
    "key",
    "parameters",
}
POSITIONS = [20.0 * hole for hole in range(1, 19)]
STOCK_G = (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)
Vectors = Mapping[str, complex]


class Tablet(TestClient):
    """A client that sends forms as the pages do: with the cookie and the token that belong together."""

    def request(self, method: str, url: Any, **sent: Any) -> Any:
        """Ask; a form gets its token unless it states one."""
        if isinstance(sent.get("data"), dict):
            if form_tokens.COOKIE not in self.cookies:
                self.cookies.set(form_tokens.COOKIE, "x" * 43)
            secret = self.cookies[form_tokens.COOKIE].encode()
            token = hmac.new(secret, b"drumtrue form", "sha256").hexdigest()
            sent["data"] = {form_tokens.FIELD: token, **sent["data"]}
        return super().request(method, url, **sent)


@dataclass
class StopWatch:
    """A stop-watch that stands until it is moved by hand, s."""

    seconds: float = 0.0

    def __call__(self) -> float:
        return self.seconds


@dataclass
class Ticking:
    """A clock that goes on by a second whenever it is asked, so that nothing happens at the same time."""

    clock: ManualClock = field(default_factory=ManualClock)

    def __call__(self) -> datetime:
        self.clock.advance(1.0)
        return self.clock.now()


def counting_ids() -> Iterator[str]:
    """id-0001, id-0002 ..."""
    return (f"id-{number:04}" for number in itertools.count(1))


def work_over(database: Database, now: Ticking | None = None) -> AppContext:
    """A work whose clock, identifiers and stop-watch are the same in every run of the tests."""
    ids, seconds = counting_ids(), itertools.count()
    return AppContext(
        database=database,
        now=now or Ticking(),
        new_id=lambda: next(ids),
        monotonic=lambda: 1e-6 * next(seconds),
    )


@dataclass(frozen=True)
class LinearDrum:
    """v = v0 + A u, and nothing else: angles against the rotation, phases as lag, both as they are typed in.

    initial: vector of each sensor as found. influence: (sensor, plane) -> vector per g. Its arithmetic is its own.
    """

    initial: Vectors
    influence: Mapping[tuple[str, str], complex]

    def vibration(self, masses: Sequence[Mapping[str, Any]]) -> dict[str, complex]:
        """1x vector of each sensor with these masses on the rotor."""
        out = dict(self.initial)
        for mass in masses:
            vector = cmath.rect(mass["mass_g"], math.radians(mass["angle_deg"]))
            for sensor in out:
                out[sensor] += self.influence[sensor, mass["plane"]] * vector
        return out

    def readings(self, masses: Sequence[Mapping[str, Any]] = ()) -> list[dict[str, Any]]:
        """What the sensors say then."""
        return [reading(sensor, vector) for sensor, vector in self.vibration(masses).items()]


DRUM = LinearDrum(
    initial={"P": cmath.rect(3.109, 0.7), "Q": cmath.rect(4.785, 2.1)},
    influence={
        ("P", "1"): cmath.rect(0.014, 0.3),
        ("P", "2"): cmath.rect(0.004, 1.2),
        ("Q", "1"): cmath.rect(0.003, -0.6),
        ("Q", "2"): cmath.rect(0.017, 0.5),
    },
)


def reading(sensor: str, vector: complex, **more: Any) -> dict[str, Any]:
    """A reading of this vector."""
    return {"sensor": sensor, "amplitude": abs(vector), "phase_deg": math.degrees(cmath.phase(vector)), **more}


def vector_of(entry: Mapping[str, Any], size: str = "amplitude", angle: str = "phase_deg") -> complex:
    """The vector of a reading, prediction or mass that the service states."""
    return cmath.rect(entry[size], math.radians(entry[angle]))


def vectors(entries: Sequence[Mapping[str, Any]]) -> dict[str, complex]:
    """Vector by sensor."""
    return {entry["sensor"]: vector_of(entry) for entry in entries}


def mass(plane: str, mass_g: float, angle_deg: float) -> dict[str, Any]:
    """A mass on the rotor."""
    return {"plane": plane, "mass_g": mass_g, "angle_deg": angle_deg}


def machine_body(name: str = "drum", **changes: Any) -> dict[str, Any]:
    """The published drum: 120 kg, 460 r/min, two planes of 18 positions, a sensor at each bearing."""
    plane = {"radius_mm": 330.0, "positions_deg": POSITIONS, "max_masses": 3}
    return {
        "name": name,
        "rotor_mass_kg": 120.0,
        "service_speed_rpm": 460.0,
        "vibration_limit_mm_s": 0.2,
        "bearings": [{"name": "P", "axial_mm": -480.0}, {"name": "Q", "axial_mm": 440.0}],
        "planes": [{"name": "1", "axial_mm": -330.0, **plane}, {"name": "2", "axial_mm": 330.0, **plane}],
        "sensors": [{"name": "P", "axial_mm": -480.0}, {"name": "Q", "axial_mm": 440.0}],
        **changes,
    }


def box_body(name: str = "box", count: int | None = 10, masses: Sequence[float] = STOCK_G) -> dict[str, Any]:
    """A box of stock masses."""
    return {"name": name, "items": [{"mass_g": grams, "count": count} for grams in masses]}


class Workshop:
    """The service seen through its API, and the drum on which it is tried."""

    def __init__(self, client: TestClient, work: AppContext, now: Ticking, watch: StopWatch) -> None:
        self.client = client
        self.work = work
        self.now = now
        self.watch = watch
        self._names = itertools.count(1)

    # ------------------------------------------------------------ any request
    def ask(self, method: str, path: str, body: object = None) -> Any:
        """The answer to a request that is in order."""
        answer = self.client.request(method, PREFIX + path, json=body)
        assert answer.is_success, f"{method} {path}: {answer.status_code} {answer.text}"
        return answer.json()

    def post(self, path: str, body: object) -> Any:
        return self.ask("POST", path, body)

    def get(self, path: str) -> Any:
        return self.ask("GET", path)

    def refused(self, method: str, path: str, body: object, status: int, code: str) -> dict[str, Any]:
        """The problem that a request is answered with; nothing is stored by it.

        `body` is sent as JSON, bytes as they are, None as no body at all.
        """
        before = self.rows()
        if isinstance(body, bytes):
            answer = self.client.request(method, PREFIX + path, content=body, headers=JSON)
        else:
            answer = self.client.request(method, PREFIX + path, json=body)
        problem = problem_of(answer, status, code)
        assert self.rows() == before
        return problem

    def rows(self) -> dict[str, list[Any]]:
        """All rows of all tables."""
        out = {}
        with self.work.database.engine.connect() as connection:
            for table in Base.metadata.sorted_tables:
                out[table.name] = sorted(map(repr, connection.execute(select(table))))
        return out

    def count(self, table: str) -> int:
        """How many rows a table has."""
        with self.work.database.engine.connect() as connection:
            counted = connection.execute(select(func.count()).select_from(Base.metadata.tables[table]))
            return int(counted.scalar_one())

    # ------------------------------------------------------------ the usual steps
    def machine(self, **changes: Any) -> str:
        """A stored machine."""
        return str(self.post("/machines", machine_body(f"drum {next(self._names)}", **changes))["id"])

    def box(self, count: int | None = 10, masses: Sequence[float] = STOCK_G) -> str:
        """A stored box."""
        return str(self.post("/catalogues", box_body(f"box {next(self._names)}", count, masses))["id"])

    def session(self, machine: str | None = None, box: str | None = None, **more: Any) -> str:
        """An open session; on a machine and with a box of its own, unless they are given."""
        body = {"machine_id": machine or self.machine(), "catalogue_id": box or self.box(), **more}
        return str(self.post("/sessions", body)["id"])

    def run(
        self, session: str, kind: str, masses: Sequence[dict[str, Any]] = (), drum: LinearDrum = DRUM, **more: Any
    ) -> Any:
        """A stored run of the drum with these masses."""
        body = {"kind": kind, "masses": list(masses), "readings": drum.readings(masses), **more}
        return self.post(f"/sessions/{session}/runs", body)

    def learn(self, session: str, drum: LinearDrum = DRUM, grams: float = 200.0) -> None:
        """An initial run and a trial run in each plane."""
        self.run(session, "initial", drum=drum)
        for plane in dict.fromkeys(plane for _, plane in drum.influence):
            self.run(session, "trial", [mass(plane, grams, 0.0)], drum)

    def correct(self, session: str, **request: Any) -> Any:
        """A correction, by fit unless the request says otherwise."""
        return self.post(f"/sessions/{session}/corrections", {"source": "fit", **request})

    def plan(self, session: str, correction: Any, **request: Any) -> Any:
        """A plan, exact with one mass a plane for the residual vibration unless the request says otherwise."""
        usual = {"objective": "residual_vibration", "method": "exact", "max_masses_per_plane": 1}
        return self.post(f"/sessions/{session}/plans", {"correction_id": correction["id"], **usual, **request})

    def planned(self, session: str) -> Any:
        """A plan after all the steps before it."""
        self.learn(session)
        return self.plan(session, self.correct(session))

    def fit(self, plan: Any, **request: Any) -> Any:
        """The plan, reported fitted."""
        return self.post(f"/plans/{plan['id']}/fitted", request)

    def state(self, session: str) -> str:
        """The session's state."""
        return str(self.get(f"/sessions/{session}")["state"])

    def on_hand(self, box: str) -> dict[float, int]:
        """Pieces left in a box, by mass."""
        return {item["mass_g"]: item["on_hand"] for item in self.get(f"/catalogues/{box}")["items"]}


def problem_of(answer: Any, status: int, code: str) -> dict[str, Any]:
    """The problem document of a response, once it is one and says what it must."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem: dict[str, Any] = answer.json()
    assert set(problem) == PROBLEM_FIELDS | ({"current"} if status == 412 else set())
    assert (problem["type"], problem["status"]) == ("about:blank", status)
    assert problem["code"] == code, problem
    assert problem["title"]
    assert problem["detail"]
    assert problem["advice"], problem
    return problem


def on_rotor(placements: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Placements as masses on the rotor: as weighed, fasteners included."""
    return [mass(p["plane"], (p["weighed_g"] or p["mass_g"]) + p["fastener_g"], p["position_deg"]) for p in placements]


@contextmanager
def workshop(url: str) -> Iterator[Workshop]:
    """A workshop over the database at this address, migrated first."""
    settings = Settings(database_url=url)
    now = Ticking()
    work = work_over(bootstrap.open_database(settings), now)
    app = application()
    before = getattr(app.state, "work", None)
    watch = StopWatch()
    app.state.work, app.state.attempts = work, LoginThrottle(watch)
    try:
        yield Workshop(tablet(app), work, now, watch)
    finally:
        app.state.work = before
        work.database.close()


def tablet(app: FastAPI) -> Tablet:
    """A client whose requests all run on one event loop: of themselves they would start one each."""
    made = Tablet(app, base_url=HERE)
    made.portal = _portal()
    return made


@cache
def _portal() -> BlockingPortal:
    held = ExitStack()
    atexit.register(held.close)
    return held.enter_context(start_blocking_portal())


@cache
def application() -> FastAPI:
    """The application, made once: its first request builds all routes, which takes a second."""
    return create_app(Settings(database_url="sqlite://", loopback=True))
