"""`python -m tests.support.storage.record_version`: what this version stores, kept for the versions after it.

Run at each release. Writes `tests/golden/versions/VERSION/`: the database as SQL text, the log of each session, one a
line, and a recording of readings. Every kind of row is in it, told through the API alone, so that the script runs with
any version.
"""

from __future__ import annotations

import cmath
import json
import math
import sqlite3
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from fastapi.testclient import TestClient

from drivers.files.readings import Recorder
from drivers.reading import Reading
from service.app import create_app
from service.settings import Settings
from service.version import __version__

VERSIONS = Path(__file__).parents[2] / "golden" / "versions"
INITIAL = {"P": cmath.rect(3.109, 0.7), "Q": cmath.rect(4.785, 2.1)}
INFLUENCE = {
    ("P", "1"): cmath.rect(0.014, 0.3),
    ("P", "2"): cmath.rect(0.004, 1.2),
    ("Q", "1"): cmath.rect(0.003, -0.6),
    ("Q", "2"): cmath.rect(0.017, 0.5),
}


class Service:
    """The API over a database."""

    def __init__(self, client: TestClient) -> None:
        self._client = client

    def ask(self, method: str, path: str, body: object = None) -> Any:
        """The answer to a request; None where it is refused."""
        answer = self._client.request(method, f"/api/v1{path}", json=body)
        return answer.json() if answer.is_success else None

    def done(self, method: str, path: str, body: object = None) -> Any:
        """The answer to a request that is in order."""
        answer = self.ask(method, path, body)
        assert answer is not None, f"{method} {path} was refused"
        return answer


def main() -> None:
    """Record this version, in the folder named after it or in the one that is stated."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else VERSIONS / __version__
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as made:
        path = Path(made) / "drumtrue.db"
        settings = Settings(database_url=f"sqlite:///{path}", loopback=True)
        with TestClient(create_app(settings), base_url="http://localhost") as client:
            logs = _fill(Service(client))
        with closing(sqlite3.connect(path)) as connection:
            text = "\n".join(connection.iterdump()) + "\n"
    (folder / "drumtrue.sql").write_text(text, encoding="utf-8")
    (folder / "logs.jsonl").write_text("".join(f"{json.dumps(log)}\n" for log in logs), encoding="utf-8")
    with Recorder(folder / "recording.jsonl") as recording:
        recording.write(_recording())
    print(f"{folder}: {len(logs)} logs, {len(text)} characters of SQL")


def _recording() -> Iterator[Reading]:
    """A recording in which every field is stated, and left out."""
    for k in range(6):
        yield Reading(
            source="pickup 5 mm",
            sequence=k + 1,
            taken_at=datetime(2026, 3, 1, 12, tzinfo=UTC) + timedelta(seconds=0.5 * k, microseconds=k),
            sensor="PQ"[k % 2],
            amplitude=3.109 + 0.01 * k,
            phase_deg=40.25 + k if k % 3 else None,
            speed_rpm=459.5 + k / 8 if k > 2 else None,
            scatter=0.012 if k > 3 else None,
            overall_rms=4.5 if k > 3 else None,
        )


def _fill(service: Service) -> list[Any]:
    """Store some of everything; the logs of the sessions that can be read."""
    machine = service.done("POST", "/machines", _machine())["id"]
    stock = [{"mass_g": grams, "count": 10} for grams in (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)]
    box = service.done("POST", "/catalogues", {"name": "box", "items": stock})["id"]
    for source in ("bridge", "balancer"):
        service.done("PUT", f"/sources/{source}", {"machine_id": machine})
    keys = []
    for closed in (True, False):
        session = service.done("POST", "/sessions", {"machine_id": machine, "catalogue_id": box, "note": "for later"})[
            "id"
        ]
        keys.append(session)
        plan = _balanced(service, session)
        if closed:
            check = [
                {"plane": p["plane"], "mass_g": p["mass_g"], "angle_deg": p["position_deg"]} for p in plan["placements"]
            ]
            service.done("POST", f"/sessions/{session}/runs", {"kind": "check", "readings": _readings(check)})
            service.done("POST", f"/machines/{machine}/influence", {"session_id": session})
            service.done("PATCH", f"/sessions/{session}", {"state": "closed"})
    keys.append(_of_steady_readings(service, machine, box))
    answer = {"source": "balancer", "sequence": 1, "taken_at": datetime.now(UTC).isoformat()}
    service.done("POST", "/balancer-answers", {**answer, "masses": [{"plane": "1", "mass_g": 50.0, "angle_deg": 10.0}]})
    return [log for key in keys if (log := service.ask("GET", f"/sessions/{key}/log")) is not None]


def _machine() -> dict[str, Any]:
    plane = {"radius_mm": 330.0, "positions_deg": [20.0 * hole for hole in range(1, 19)], "max_masses": 3}
    return {
        "name": "drum",
        "type": "T1",
        "rotor_mass_kg": 120.0,
        "service_speed_rpm": 460.0,
        "vibration_limit_mm_s": 0.7,
        "planes": [{"name": "1", "axial_mm": -330.0, **plane}, {"name": "2", "axial_mm": 330.0, **plane}],
        "sensors": [{"name": "P", "axial_mm": -480.0}, {"name": "Q", "axial_mm": 440.0}],
    }


def _readings(masses: list[dict[str, Any]]) -> list[dict[str, Any]]:
    vectors = dict(INITIAL)
    for mass in masses:
        for sensor in vectors:
            vectors[sensor] += INFLUENCE[sensor, mass["plane"]] * cmath.rect(
                mass["mass_g"], math.radians(mass["angle_deg"])
            )
    return [
        {"sensor": sensor, "amplitude": abs(vector), "phase_deg": math.degrees(cmath.phase(vector)), "scatter": 0.01}
        for sensor, vector in vectors.items()
    ]


def _balanced(service: Service, session: str) -> Any:
    service.done("POST", f"/sessions/{session}/runs", {"kind": "initial", "masses": [], "readings": _readings([])})
    for plane in ("1", "2"):
        masses = [{"plane": plane, "mass_g": 200.0, "angle_deg": 0.0}]
        service.done(
            "POST", f"/sessions/{session}/runs", {"kind": "trial", "masses": masses, "readings": _readings(masses)}
        )
    correction = service.done("POST", f"/sessions/{session}/corrections", {"source": "fit"})
    request = {"correction_id": correction["id"], "objective": "residual_vibration", "method": "exact"}
    plan = service.done("POST", f"/sessions/{session}/plans", {**request, "max_masses_per_plane": 2})
    return service.done("POST", f"/plans/{plan['id']}/fitted", {})


def _of_steady_readings(service: Service, machine: str, box: str) -> str:
    """A session whose run is taken from equal readings: version 0.1.0 stored what it could not read again."""
    session = str(service.done("POST", "/sessions", {"machine_id": machine, "catalogue_id": box})["id"])
    begun = datetime.now(UTC) - timedelta(minutes=1)
    for sensor, place in (("P", 0), ("Q", 20)):
        sent = [
            {
                "source": "bridge",
                "sequence": place + number,
                "taken_at": (begun + timedelta(seconds=number)).isoformat(),
                "sensor": sensor,
                "amplitude": 3.1,
                "phase_deg": 37.0,
            }
            for number in range(10)
        ]
        service.done("POST", "/readings", sent)
    take = {"source": "bridge", "from": begun.isoformat(), "to": (begun + timedelta(seconds=30)).isoformat()}
    service.done("POST", f"/sessions/{session}/runs", {"kind": "initial", "take": take})
    return session


if __name__ == "__main__":
    main()
