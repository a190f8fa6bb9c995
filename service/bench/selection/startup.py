"""The first plan that a freshly started service is asked for."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import httpx2

from service.errors import Unavailable
from service.messages import Message

POSITIONS = [20.0 * n for n in range(1, 19)]
MACHINE = {
    "name": "bench",
    "service_speed_rpm": 460.0,
    "rotor_mass_kg": 120.0,
    "vibration_limit_mm_s": 0.7,
    "bearings": [{"name": "left", "axial_mm": -480.0}, {"name": "right", "axial_mm": 440.0}],
    "planes": [
        {"name": "L", "radius_mm": 330.0, "axial_mm": -330.0, "max_masses": 3, "positions_deg": POSITIONS},
        {"name": "R", "radius_mm": 330.0, "axial_mm": 330.0, "max_masses": 3, "positions_deg": POSITIONS},
    ],
    "sensors": [{"name": "left"}, {"name": "right"}],
}
BOX = {"name": "bench", "items": [{"mass_g": m, "count": 8} for m in (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)]}
ANSWER = {
    "source": "balancer",
    "masses": [
        {"plane": "L", "mass_g": 170.2, "angle_deg": 70.0},
        {"plane": "R", "mass_g": 292.2, "angle_deg": 113.0},
    ],
}


def first_plan(patience_s: float = 30.0) -> tuple[float, float]:
    """Seconds of the first and the second plan of a service in a process of its own; measured at the client.

    The requests before it (machine, box, session, correction) are sent as soon as the service listens.
    """
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-u", "-m", "service", "serve", "--port", "0"]
        command += ["--database-url", f"sqlite:///{Path(folder) / 'bench.db'}"]
        with subprocess.Popen(  # noqa: S603 - this interpreter, this program
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        ) as served:
            try:
                return _two_plans(_address(served), patience_s)
            finally:
                served.terminate()


def _address(served: subprocess.Popen[str]) -> str:
    """Where it listens, from the first line that it prints."""
    line = served.stdout.readline() if served.stdout else ""
    found = [word for word in line.split() if word.startswith("http://")]
    if not found:
        raise Unavailable(Message("unavailable.not_started", line=line))
    return found[0]


def _two_plans(address: str, patience_s: float) -> tuple[float, float]:
    with httpx2.Client(base_url=f"{address}/api/v1", timeout=patience_s) as client:

        def post(path: str, body: dict[str, Any]) -> dict[str, Any]:
            answer = client.post(path, json=body)
            answer.raise_for_status()
            stored: dict[str, Any] = answer.json()
            return stored

        machine, box = post("/machines", MACHINE)["id"], post("/catalogues", BOX)["id"]
        session = post("/sessions", {"machine_id": machine, "catalogue_id": box, "technician": "bench"})["id"]
        correction = post(f"/sessions/{session}/corrections", ANSWER)["id"]
        taken = []
        for _ in range(2):
            begun = time.perf_counter()
            post(f"/sessions/{session}/plans", {"correction_id": correction, "objective": "components"})
            taken.append(time.perf_counter() - begun)
    return taken[0], taken[1]
