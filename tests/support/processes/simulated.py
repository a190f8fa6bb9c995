"""A simulated drum balanced through the API, in whatever conventions it is told."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from drivers.clock import ManualClock
from drivers.reading_json import reading_to_dict
from drivers.simulator.drum_driver import SimulatedDrum
from drivers.simulator.sensors import Sensor
from drivers.simulator.spec import AngleSense, DrumSpec, FittedMass, PhaseSense, geometric_degrees, stated_degrees
from service.cli.support.demo_machine import machine_of
from tests.support.http.workshop import Workshop, on_rotor, vector_of

STOCK_G = (5.0, 20.0, 80.0, 300.0, 1000.0)
HOLES_DEG = (0.0, 33.0, 71.0, 120.0, 155.0, 190.0, 240.0, 275.0, 311.0, 340.0)
"""Geometric angles of the holes of either plane."""
SCALES = (
    ("velocity", "mm/s", "rms"),
    ("velocity", "in/s", "peak"),
    ("acceleration", "m/s2", "peak"),
    ("acceleration", "g", "rms"),
    ("displacement", "um", "peak_to_peak"),
    ("displacement", "mil", "peak"),
)
_numbers = itertools.count(1)


@dataclass(frozen=True)
class Told:
    """How a drum is told: senses, where the pick-up stands, and the scale of each sensor."""

    angle_sense: AngleSense
    phase_sense: PhaseSense
    pickup_deg: float
    scales: tuple[tuple[str, str, str], ...]

    def of(self, spec: DrumSpec) -> DrumSpec:
        """The same physical drum with the same holes, told like this."""
        sensors = tuple(
            Sensor(s.name, s.axial_mm, s.direction_deg, *scale)  # type: ignore[arg-type]
            for s, scale in zip(spec.sensors, self.scales, strict=True)
        )
        holes = tuple(stated_degrees(angle, self.angle_sense, spec.spin) for angle in HOLES_DEG)
        return replace(
            spec,
            angle_sense=self.angle_sense,
            phase_sense=self.phase_sense,
            pickup_deg=self.pickup_deg,
            sensors=sensors,
            planes=tuple(replace(plane, positions_deg=holes) for plane in spec.planes),
        )


@dataclass
class Balanced:
    """What came of it: vectors by sensor in each sensor's own unit."""

    holes: set[tuple[str, float, float]] = field(default_factory=set)
    stated: set[tuple[str, float, float]] = field(default_factory=set)
    initial: dict[str, complex] = field(default_factory=dict)
    check: dict[str, complex] = field(default_factory=dict)
    predicted: dict[str, complex] = field(default_factory=dict)
    sigma: dict[str, float] = field(default_factory=dict)
    objective: float = 0.0


def _let_pass(shop: Workshop, clock: ManualClock) -> None:
    """Move the service's clock on to the drum's: readings dated ahead of their receipt are set apart."""
    ahead = (clock.now() - shop.now.clock.now()).total_seconds()
    if ahead > 0.0:
        shop.now.clock.advance(ahead)


def balance(shop: Workshop, spec: DrumSpec, *, trial_g: float, seed: int = 1, readings: int = 1) -> Balanced:
    """Initial run, trial runs, corrections, plan with one mass a plane, fitted, check run.

    sigma: standard deviation of check minus prediction, as a vector: the two scatters per component, times sqrt 2.
    """
    number = next(_numbers)
    source = f"drum {number}"
    machine = shop.post("/machines", machine_of(spec, source, limit_mm_s=1.0))["id"]
    shop.ask("PUT", f"/sources/{source}", {"machine_id": machine})
    session = shop.session(machine, shop.box(count=10, masses=STOCK_G))
    clock = ManualClock()
    with SimulatedDrum(spec, seed=seed, clock=clock, source=source) as drum:

        def run(kind: str, pieces: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
            drum.fit_masses(FittedMass(p["plane"], p["mass_g"], p["angle_deg"]) for p in pieces)
            clock.advance(3600.0)
            first = clock.now()
            sent = [one for _ in range(readings) for one in drum.measure(1)]
            _let_pass(shop, clock)
            shop.post("/readings", [reading_to_dict(one) for one in sent])
            take = {"source": source, "from": first.isoformat(), "to": clock.now().isoformat()}
            stored = shop.post(f"/sessions/{session}/runs", {"kind": kind, "masses": list(pieces), "take": take})
            return {r["sensor"]: r for r in stored["readings"]}

        initial = run("initial", [])
        for plane in spec.planes:
            run("trial", [{"plane": plane.name, "mass_g": trial_g, "angle_deg": plane.positions_deg[3]}])
        plan = shop.plan(session, shop.correct(session))
        fitted = shop.fit(plan)["fitted"]
        check = run("check", on_rotor(fitted))
    out = Balanced(objective=plan["objective_value"])
    for piece in fitted:
        stated = piece["position_deg"]
        geometric = round(geometric_degrees(stated, spec.angle_sense, spec.spin) % 360.0, 6) % 360.0
        out.holes.add((piece["plane"], geometric, piece["mass_g"]))
        out.stated.add((piece["plane"], round(stated, 6), piece["mass_g"]))
    for expected in plan["predicted"]:
        name = expected["sensor"]
        out.initial[name], out.check[name] = vector_of(initial[name]), vector_of(check[name])
        out.predicted[name] = vector_of(expected)
        both = (expected["scatter"] or 0.0) ** 2 + (check[name]["scatter"] or 0.0) ** 2
        out.sigma[name] = (2.0 * both) ** 0.5
    return out
