"""A whole session over HTTP with a simulated drum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from drivers.clock import ManualClock
from drivers.reading_json import reading_to_dict
from drivers.simulator.drum_driver import SimulatedDrum
from drivers.simulator.spec import FittedMass
from service.cli.support.client import Client

READINGS_PER_RUN = 12
"""Readings of each sensor that a run is averaged from, one a second."""
TRIAL_MASS_G = 200.0
MAX_MASSES = 3
GOAL = 0.9
"""Share by which the vibration of every bearing has to come down."""

Say = Callable[[str], None]


@dataclass
class Loop:
    """One drum being balanced; `say` is told of every step."""

    client: Client
    drum: SimulatedDrum
    clock: ManualClock
    session_id: str
    seed: int
    say: Say
    plans: list[dict[str, Any]] = field(default_factory=list)

    def run(self, kind: str, pieces: list[dict[str, Any]] | None) -> dict[str, Any]:
        """Bolt on the pieces, let the drum run, send its readings in bulk, and take the run from them."""
        on_rotor = pieces if pieces is not None else self._fitted()
        self.drum.fit_masses(FittedMass(p["plane"], p["mass_g"], p["angle_deg"]) for p in on_rotor)
        readings = []
        for _ in range(READINGS_PER_RUN):
            self.clock.advance(1.0)
            readings += self.drum.measure(1)
        self.client.post("/readings", [reading_to_dict(reading) for reading in readings])
        self.clock.advance(60.0)
        taken = sorted(reading.taken_at for reading in readings)
        take = {"source": self.drum.source, "from": taken[0].isoformat(), "to": taken[-1].isoformat()}
        body: dict[str, Any] = {"kind": kind, "take": take}
        if pieces is not None:
            body["masses"] = pieces
        stored: dict[str, Any] = self.client.post(f"/sessions/{self.session_id}/runs", body)
        vectors = ", ".join(
            f"{r['sensor']} {r['amplitude']:.3f} @ {r['phase_deg']:.0f} deg" for r in stored["readings"]
        )
        with_what = ", ".join(f"{p['mass_g']:g} g @ {p['angle_deg']:g} deg in {p['plane']}" for p in on_rotor)
        self.say(f"{kind} run {stored['number']}, {with_what or 'as found'}: {vectors}")
        return stored

    def learn(self) -> None:
        """An initial run, then a trial run in each plane."""
        self.run("initial", [])
        for plane in self.drum.spec.planes:
            self.run("trial", [{"plane": plane.name, "mass_g": TRIAL_MASS_G, "angle_deg": 0.0}])

    def correct(self) -> dict[str, Any]:
        """Corrections, a plan, the masses bolted on, and a check run; returns the plan."""
        correction = self.client.post(f"/sessions/{self.session_id}/corrections", {"source": "fit"})
        for finding in correction["diagnostics"]:
            self.say(f"{finding['severity']}: {finding['message']}. {finding['advice']}")
        for wanted in correction["corrections"]:
            self.say(f"correction in {wanted['plane']}: {wanted['mass_g']:.1f} g @ {wanted['angle_deg']:.1f} deg")
        request = {
            "correction_id": correction["id"],
            "objective": "residual_vibration",
            "max_masses_per_plane": MAX_MASSES,
            "seed": self.seed,
        }
        plan: dict[str, Any] = self.client.post(f"/sessions/{self.session_id}/plans", request)
        self.say(f"plan {plan['number']}: {plan['status']}, {plan['message']}")
        fitted = self.client.post(f"/plans/{plan['id']}/fitted", {})
        self.plans.append(fitted)
        self.run("check", None)
        return plan

    def good_enough(self) -> bool:
        """Whether every bearing is within its limit and down by the goal, on the stored readings."""
        lines = self.report()["before_after"]
        return all(line["within_limit"] is not False and line["reduction"] >= GOAL for line in lines)

    def report(self) -> dict[str, Any]:
        """The session's report."""
        report: dict[str, Any] = self.client.get(f"/sessions/{self.session_id}/report.json")
        return report

    def _fitted(self) -> list[dict[str, Any]]:
        return [
            {"plane": p["plane"], "mass_g": p["mass_g"] + p["fastener_g"], "angle_deg": p["position_deg"]}
            for p in self.plans[-1]["fitted"]
        ]
