"""`drumtrue demo --parts`: a simulated drum whose bars are weighed, arranged, mounted, then trimmed with masses.

The drum turns with its bars as they were found; what another order changes is bolted onto the simulated drum by the
arithmetic of this module, which shares nothing with the service's.
"""

from __future__ import annotations

import cmath
import json
import math
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from drivers.clock import ManualClock
from drivers.simulator.drum_driver import SimulatedDrum
from drivers.simulator.example import threshing_drum_example
from drivers.simulator.spec import DrumSpec, FittedMass
from service.cli.commands.serve import serving
from service.cli.support import show
from service.cli.support.client import Client
from service.cli.support.demo_machine import LIMIT_MM_S, catalogue_of, machine_of
from service.cli.support.demo_session import GOAL, Loop
from service.settings import Settings

BARS, BAR_RADIUS_MM, BAR_ENDS_MM = 10, 310.0, (-400.0, 400.0)
END_MASS_G, END_SPREAD_G, SCALE_G = 3000.0, 40.0, 1.0
SET = "rasp bars"


@dataclass
class _Bars:
    """True masses (BARS, 2) in g, drawn with a seed; what the scale reads of them; the present order."""

    seed: int
    order: list[int] = field(default_factory=lambda: list(range(BARS)))

    def __post_init__(self) -> None:
        rng = np.random.default_rng([self.seed, 19])
        self.true = rng.normal(END_MASS_G, END_SPREAD_G, (BARS, 2))
        self.read = np.round(self.true / SCALE_G) * SCALE_G

    def instead(self, order: list[int], spec: DrumSpec) -> list[FittedMass]:
        """Masses in the correction planes that do what this order does instead of the one as found."""
        first, second = spec.planes[0], spec.planes[1]
        change = {first.name: 0j, second.name: 0j}
        for place in range(BARS):
            turn = cmath.exp(2j * math.pi * place / BARS) * BAR_RADIUS_MM
            for end, axial in enumerate(BAR_ENDS_MM):
                unbalance = (self.true[order[place], end] - self.true[place, end]) * turn
                to_second = (axial - first.axial_mm) / (second.axial_mm - first.axial_mm)
                change[first.name] += (1.0 - to_second) * unbalance / first.radius_mm
                change[second.name] += to_second * unbalance / second.radius_mm
        return [
            FittedMass(plane, abs(vector), math.degrees(cmath.phase(vector)))
            for plane, vector in change.items()
            if abs(vector) > 0.0
        ]


class _Turned:
    """A simulated drum that carries the changed bars besides whatever masses are bolted on."""

    def __init__(self, drum: SimulatedDrum) -> None:
        self._drum, self.bars = drum, list[FittedMass]()

    def fit_masses(self, pieces: Iterable[FittedMass]) -> None:
        """Bolt on these pieces and no others; the bars stay."""
        self._drum.fit_masses([*pieces, *self.bars])

    def __getattr__(self, name: str) -> Any:
        return getattr(self._drum, name)


def run_parts_demo(*, seed: int, speed_rpm: float, as_json: bool, database_url: str | None) -> int:
    """Run the demo; returns the status for the shell: 0 when every bearing is down by the goal."""
    begun = time.monotonic()
    console = Console(quiet=as_json, highlight=False)
    url = database_url or f"sqlite:///{Path(tempfile.mkdtemp(prefix='drumtrue-demo-')) / 'drumtrue.db'}"
    settings = Settings.from_environment(database_url=url)
    with serving(settings) as address:
        client = Client(address)
        try:
            result = _arrange_and_trim(client, seed, speed_rpm, console)
        finally:
            client.close()
    result |= {"seed": seed, "speed_rpm": speed_rpm, "seconds": round(time.monotonic() - begun, 3)}
    if as_json:
        print(json.dumps(result, indent=2), flush=True)
    console.print(f"{'done' if result['ok'] else 'not within the goal'} in {result['seconds']:.1f} s")
    return 0 if result["ok"] else 1


def _arrange_and_trim(client: Client, seed: int, speed_rpm: float, console: Console) -> dict[str, Any]:
    spec = replace(threshing_drum_example(seed), speed_rpm=speed_rpm)
    bars, clock = _Bars(seed), ManualClock(datetime.now(UTC) - timedelta(hours=1))
    stamp = f"{clock.now():%Y-%m-%d %H:%M:%S.%f}"
    limit = LIMIT_MM_S * (speed_rpm / 460.0) ** 3
    machine = client.post("/machines", machine_of(spec, f"Demo drum {stamp}", limit_mm_s=limit))["id"]
    box = client.post("/catalogues", catalogue_of(f"Demo box {stamp}"))["id"]
    client.put(f"/sources/demo drum {stamp}", {"machine_id": machine})
    client.put(f"/machines/{machine}/place-sets/{SET}", {"places": _places()})

    def say(line: str) -> None:
        console.print(f"  {line}", soft_wrap=True)

    def session() -> str:
        opened = client.post("/sessions", {"machine_id": machine, "catalogue_id": box, "technician": "demo"})
        return str(opened["id"])

    show.heading(console, f"Simulated drum with {BARS} rasp bars: {spec.rotor.mass_kg:g} kg at {speed_rpm:g} r/min")
    with SimulatedDrum(spec, seed=seed, clock=clock, source=f"demo drum {stamp}") as inner:
        drum = _Turned(inner)
        loop = Loop(client, drum, clock, session(), seed, say=say)  # type: ignore[arg-type]
        loop.learn()
        before = _vibration(client, loop.session_id)
        correction = client.post(f"/sessions/{loop.session_id}/corrections", {"source": "fit"})
        made = _arranged(client, loop.session_id, correction["id"], bars)
        _tell(console, made)
        client.post(f"/arrangements/{made['id']}/mounted", {})
        client.post(f"/machines/{machine}/influence", {"session_id": loop.session_id})
        drum.bars = bars.instead([int(one["part"]) - 1 for one in made["arrangement"]], spec)
        loop.session_id = session()
        loop.run("initial", [])
        arranged = _vibration(client, loop.session_id)
        _trim(client, loop, seed, say)
        after = _vibration(client, loop.session_id)
    reductions = {name: 1.0 - after[name] / before[name] for name in before}
    by_bars = {name: 1.0 - arranged[name] / before[name] for name in before}
    for name in before:
        say(f"{name}: {before[name]:.3f} as found, {arranged[name]:.3f} rearranged, {after[name]:.3f} trimmed")
    return {
        "ok": all(share >= GOAL for share in reductions.values()),
        "machine_id": machine,
        "arrangement": {
            key: made[key] for key in ("id", "status", "objective_value", "lower_bound", "moves_count", "residual")
        },
        "makers_rule": made["makers_rule"],
        "as_found": before,
        "rearranged": arranged,
        "trimmed": after,
        "reductions_by_parts": by_bars,
        "reductions": reductions,
    }


def _places() -> list[dict[str, Any]]:
    return [
        {
            "label": str(n + 1),
            "angle_deg": 360.0 * n / BARS,
            "radius_mm": BAR_RADIUS_MM,
            "axial_mm": list(BAR_ENDS_MM),
        }
        for n in range(BARS)
    ]


def _arranged(client: Client, session_id: str, correction_id: str, bars: _Bars) -> dict[str, Any]:
    parts = [{"id": str(n + 1), "mass_g": [float(m) for m in bars.read[n]], "present": str(n + 1)} for n in range(BARS)]
    request = {
        "session_id": session_id,
        "correction_id": correction_id,
        "set": SET,
        "parts": parts,
        "offset": "measured",
        "norm": "max",
        "scale_resolution_g": SCALE_G,
    }
    made: dict[str, Any] = client.post("/arrangements", request)
    return made


def _trim(client: Client, loop: Loop, seed: int, say: Any) -> None:
    """What the bars leave is trimmed with stock masses, by the influence that the machine has taught."""
    correction = client.post(f"/sessions/{loop.session_id}/corrections", {"source": "saved_influence"})
    request = {"correction_id": correction["id"], "objective": "residual_vibration", "seed": seed}
    plan = client.post(f"/sessions/{loop.session_id}/plans", request)
    say(f"trim: {plan['status']}, {len(plan['placements'])} stock masses")
    loop.plans.append(client.post(f"/plans/{plan['id']}/fitted", {}))
    loop.run("check", None)


def _vibration(client: Client, session_id: str) -> dict[str, float]:
    """Amplitude of each sensor in the first initial run, or in the latest check run."""
    runs = client.get(f"/sessions/{session_id}/log")["runs"]
    found = next((run for run in reversed(runs) if run["kind"] == "check"), runs[0])
    return {reading["sensor"]: reading["amplitude"] for reading in found["readings"]}


def _tell(console: Console, made: dict[str, Any]) -> None:
    rule = made["makers_rule"]
    console.print(
        f"  arrangement: {made['status']}, {made['moves_count']} bars move, {made['objective_value']:.0f} g.mm left in "
        f"the worse plane; now {made['objective_now']:.0f}, by the maker's rule {rule['objective_value']:.0f}",
        soft_wrap=True,
    )
    for number, move in enumerate(made["moves"], start=1):
        console.print(f"    {number}. bar {move['part']}: place {move['from']} -> place {move['to']}")
