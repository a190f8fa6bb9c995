"""Session logs of a drum that obeys v = v0 + A u exactly: what the kernel is tested on, without storage."""

from __future__ import annotations

import cmath
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from service.engine.logs.replay import read_log
from service.model.session import SessionLog

INITIAL = {"P": cmath.rect(3.0, math.radians(40.0)), "Q": cmath.rect(5.0, math.radians(120.0))}
INFLUENCE = {
    ("P", "1"): cmath.rect(0.014, math.radians(17.0)),
    ("P", "2"): cmath.rect(0.004, math.radians(69.0)),
    ("Q", "1"): cmath.rect(0.003, math.radians(326.0)),
    ("Q", "2"): cmath.rect(0.017, math.radians(29.0)),
}
BOX = (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)


def machine(**changes: Any) -> dict[str, Any]:
    """Two planes of 18 holes numbered from 0 degrees, two velocity sensors, 120 kg at 460 r/min."""
    planes = [
        {
            "name": name,
            "radius_mm": 330.0,
            "axial_mm": at,
            "positions_deg": [20.0 * hole for hole in range(18)],
            "max_masses": 3,
        }
        for name, at in (("1", -330.0), ("2", 330.0))
    ]
    bare: dict[str, Any] = {
        "name": "drum",
        "service_speed_rpm": 460.0,
        "rotor_mass_kg": 120.0,
        "balance_grade_mm_s": 6.3,
        "vibration_limit_mm_s": 0.7,
        "planes": planes,
        "sensors": [{"name": "P", "axial_mm": -480.0}, {"name": "Q", "axial_mm": 440.0}],
    }
    return {key: value for key, value in (bare | changes).items() if value is not None}


def run(
    kind: str,
    *masses: tuple[str, float, float],
    scatter: float | None = 0.001,
    found: Mapping[str, complex] = INITIAL,
    **fields: Any,
) -> dict[str, Any]:
    """A run with masses (plane, g, degrees) on, as the drum answers it; found: its vibration without them."""
    seen = dict(found)
    for plane, grams, degrees in masses:
        for sensor in seen:
            seen[sensor] += INFLUENCE[sensor, plane] * cmath.rect(grams, math.radians(degrees))
    readings = [
        {
            "sensor": sensor,
            "amplitude": abs(v),
            "phase_deg": math.degrees(cmath.phase(v)) % 360.0,
            **({} if scatter is None else {"scatter": scatter}),
        }
        for sensor, v in seen.items()
    ]
    stated = [{"plane": plane, "mass_g": grams, "angle_deg": degrees} for plane, grams, degrees in masses]
    return {"kind": kind, "masses": stated, "readings": readings, **fields}


RUNS = (run("initial"), run("trial", ("1", 200.0, 0.0)), run("trial", ("2", 200.0, 80.0)))


def session(
    runs: Sequence[Mapping[str, Any]] = RUNS, box: Sequence[float] | None = BOX, **machine_changes: Any
) -> SessionLog:
    """A log as it is written by hand."""
    document: dict[str, Any] = {"machine": machine(**machine_changes), "runs": list(runs)}
    if box is not None:
        document["catalogue"] = {"name": "box", "items": [{"mass_g": mass, "count": 10} for mass in box]}
    return read_log(json.dumps(document))


def still(sensor: str, masses: Mapping[str, complex]) -> complex:
    """Vibration of a sensor with vector sums (g) per plane on, by the drum's own arithmetic."""
    return INITIAL[sensor] + sum(INFLUENCE[sensor, plane] * vector for plane, vector in masses.items())
