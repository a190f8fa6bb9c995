"""A drum with bars, measured with scatter: what is left after mounting lies within the interval that was stated."""

from __future__ import annotations

import cmath
import json
import math
import time
from datetime import UTC, datetime

import numpy as np

from service.balancing.rotor.phasors import ComplexArray
from service.engine import arrangement as engine
from service.engine.correction_solver import solve_correction
from service.engine.selection_problem import PlanContext as MeasuredGround
from service.model.arrangement import ArrangementRequest
from service.model.base import read_json
from service.model.correction import CorrectionRequest
from service.model.machine import Machine
from service.model.plan import PlanInputs
from service.model.run import Run
from tests.support.http.workshop import machine_body

MACHINE = read_json(Machine, json.dumps(machine_body()))
PLANES_MM, PLANE_RADIUS = (-330.0, 330.0), 330.0
BARS, RADIUS, ENDS = 8, 300.0, (-400.0, 400.0)
INFLUENCE = np.array(
    [[cmath.rect(0.014, 0.3), cmath.rect(0.004, 1.2)], [cmath.rect(0.003, -0.6), cmath.rect(0.017, 0.5)]]
)
SCATTER = 0.03
DRUMS = 120
EXPECTED = (0.90, 0.99)
"""240 intervals of 95 %: three standard deviations of their share around it. A longer run is a command of the bench."""


def test_the_interval_holds_what_is_left() -> None:
    held = [inside for seed in range(DRUMS) for inside in _held(seed)]
    assert EXPECTED[0] <= float(np.mean(held)) <= EXPECTED[1]


def _held(seed: int) -> list[bool]:
    """Whether the interval of each plane holds the truth, for one drum."""
    rng = np.random.default_rng(seed)
    now = np.asarray((rng.normal(size=2) + 1j * rng.normal(size=2)) * 3e4, dtype=np.complex128)
    true = rng.normal(3000.0, 20.0, (BARS, 2))
    runs = tuple(
        _run(number, trial, now, rng) for number, trial in enumerate((np.zeros(2), [200.0, 0.0], [0.0, 200.0]), 1)
    )
    asked = read_json(CorrectionRequest, '{"source": "fit"}')
    correction = solve_correction(MACHINE, runs, (), asked, number=1, key="c")
    stays = {6, 7}
    request = read_json(
        ArrangementRequest,
        json.dumps(
            {
                "correction_id": "c",
                "places": [
                    {
                        "label": str(n),
                        "angle_deg": 360.0 * n / BARS,
                        "radius_mm": RADIUS,
                        "axial_mm": ENDS,
                    }
                    for n in range(BARS)
                ],
                "parts": [
                    {"id": str(n), "present": str(n)}
                    | ({"may": "stay"} if n in stays else {"mass_g": np.round(true[n]).tolist()})
                    for n in range(BARS)
                ],
                "offset": "measured",
                "scale_resolution_g": 1.0,
            }
        ),
    )
    inputs = PlanInputs(counts=(), present=(), version="test")
    ground = engine.ArrangementContext(
        request.places or (), MACHINE, MeasuredGround(MACHINE, (), runs, (), (), correction, inputs)
    )
    made = engine.answer(
        ground,
        request,
        key="a",
        machine_id=None,
        session_id=None,
        at=datetime(2026, 3, 1, tzinfo=UTC),
        monotonic=time.monotonic,
    )
    left = now.copy()
    for place, one in enumerate(made.arrangement):
        turn = RADIUS * cmath.exp(2j * math.pi * place / BARS)
        for end, axial in enumerate(ENDS):
            to_second = (axial - PLANES_MM[0]) / (PLANES_MM[1] - PLANES_MM[0])
            change = (true[int(str(one.part)), end] - true[place, end]) * turn
            left += change * np.array([1.0 - to_second, to_second])
    return [
        told.interval is not None and told.interval.low <= abs(u) <= told.interval.high
        for told, u in zip(made.residual, left, strict=True)
    ]


def _run(number: int, trial: object, now: ComplexArray, rng: np.random.Generator) -> Run:
    grams = np.asarray(trial, dtype=np.float64)
    vectors = INFLUENCE @ (now / PLANE_RADIUS + grams)
    spread = SCATTER * np.abs(vectors)
    vectors = vectors + spread * (rng.normal(size=2) + 1j * rng.normal(size=2))
    readings = [
        {
            "sensor": sensor,
            "amplitude": abs(vector),
            "phase_deg": math.degrees(cmath.phase(vector)),
            "scatter": float(deviation),
        }
        for sensor, vector, deviation in zip("PQ", vectors, spread, strict=True)
    ]
    masses = [
        {"plane": plane, "mass_g": float(mass), "angle_deg": 0.0}
        for plane, mass in zip("12", grams, strict=True)
        if mass > 0.0
    ]
    body = {
        "id": f"r{number}",
        "number": number,
        "kind": "trial" if masses else "initial",
        "masses": masses,
        "readings": readings,
        "nominal_speed_rpm": 460.0,
        "taken_at": "2026-03-01T12:00:00Z",
    }
    return read_json(Run, json.dumps(body))
