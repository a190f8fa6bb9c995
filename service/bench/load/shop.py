"""The machine, box and session that the load is put on: the published drum, as two linear equations."""

from __future__ import annotations

import cmath
import math
from typing import Any

from service.bench.load.clients import Connection

INITIAL = {"P": cmath.rect(3.109, 0.7), "Q": cmath.rect(4.785, 2.1)}
INFLUENCE = {
    ("P", "1"): cmath.rect(0.014, 0.3),
    ("P", "2"): cmath.rect(0.004, 1.2),
    ("Q", "1"): cmath.rect(0.003, -0.6),
    ("Q", "2"): cmath.rect(0.017, 0.5),
}
PLAN = {"objective": "residual_vibration", "method": "certified", "time_limit_s": 1.0}


def open_shop(connection: Connection, sources: list[str]) -> dict[str, str]:
    """A machine with these sources, a box, a session with three runs that taught it, and a correction: their ids."""
    machine = connection.post("/machines", _machine())["id"]
    for source in sources:
        connection.ask("PUT", f"/sources/{source}", f'{{"machine_id": "{machine}"}}'.encode())
    items = [{"mass_g": grams, "count": 10} for grams in (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)]
    box = connection.post("/catalogues", {"name": "bench", "items": items})["id"]
    session = connection.post("/sessions", {"machine_id": machine, "catalogue_id": box})["id"]
    for body in runs():
        connection.post(f"/sessions/{session}/runs", body)
    correction = connection.post(f"/sessions/{session}/corrections", {"source": "fit"})["id"]
    connection.post(f"/machines/{machine}/influence", {"session_id": session})
    return {"machine": machine, "box": box, "session": session, "correction": correction}


def runs() -> list[dict[str, Any]]:
    """An initial run and a trial run in each plane."""
    out = [{"kind": "initial", "masses": [], "readings": _readings({})}]
    for plane in ("1", "2"):
        masses = [{"plane": plane, "mass_g": 200.0, "angle_deg": 0.0}]
        out.append({"kind": "trial", "masses": masses, "readings": _readings({plane: 200.0 + 0.0j})})
    return out


def _readings(masses: dict[str, complex]) -> list[dict[str, Any]]:
    out = []
    for sensor, vector in INITIAL.items():
        found = vector + sum(INFLUENCE[sensor, plane] * mass for plane, mass in masses.items())
        phase = math.degrees(cmath.phase(found))
        out.append({"sensor": sensor, "amplitude": abs(found), "phase_deg": phase, "scatter": 0.02})
    return out


def _machine() -> dict[str, Any]:
    positions = [20.0 * hole for hole in range(1, 19)]
    planes = [
        {"name": name, "axial_mm": axial, "radius_mm": 330.0, "positions_deg": positions, "max_masses": 3}
        for name, axial in (("1", -330.0), ("2", 330.0))
    ]
    ends = (("P", -480.0), ("Q", 440.0))
    return {
        "name": "bench",
        "type": "drum",
        "rotor_mass_kg": 120.0,
        "service_speed_rpm": 460.0,
        "vibration_limit_mm_s": 0.2,
        "bearings": [{"name": name, "axial_mm": axial} for name, axial in ends],
        "planes": planes,
        "sensors": [{"name": name, "axial_mm": axial} for name, axial in ends],
    }
