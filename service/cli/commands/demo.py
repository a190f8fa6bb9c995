"""`drumtrue demo`: a simulated drum balanced through the real service, then the published field experiment."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from rich.console import Console

from drivers.clock import ManualClock
from drivers.simulator.drum_driver import DrumSpec, SimulatedDrum
from drivers.simulator.example import threshing_drum_example
from service.cli.commands.serve import serving
from service.cli.support import show
from service.cli.support.client import Client
from service.cli.support.demo_machine import LIMIT_MM_S, catalogue_of, machine_of
from service.cli.support.demo_session import GOAL, Loop
from service.settings import Settings

MAX_TRIMS = 1
BALANCER_ANSWER = (("1", 170.2, 70.0), ("2", 292.2, 113.0))
"""Continuous answer of the balancer in the published experiment: plane, g, degrees."""
AS_FOUND_MM_S = (("P", 3.109), ("Q", 4.785))
"""Vibration as found in the published experiment, mm/s rms, without phase."""


def run_demo(*, seed: int, speed_rpm: float, as_json: bool, serve: bool, database_url: str | None) -> int:
    """Run the demo; returns the status for the shell: 0 when every bearing is down by the goal."""
    begun = time.monotonic()
    console = Console(quiet=as_json, highlight=False)
    url = database_url or f"sqlite:///{Path(tempfile.mkdtemp(prefix='drumtrue-demo-')) / 'drumtrue.db'}"
    settings = Settings.from_environment(database_url=url)
    with serving(settings) as address:
        client = Client(address)
        try:
            result = _balance(client, seed, speed_rpm, console)
            result["field_experiment"] = _field_experiment(client, seed, console)
        finally:
            client.close()
        result |= {"seed": seed, "speed_rpm": speed_rpm, "database": settings.shown, "url": address}
        result["seconds"] = round(time.monotonic() - begun, 3)
        if as_json:
            print(json.dumps(result, indent=2), flush=True)
        show.ending(console, result)
        if serve:
            _wait(console, address)
    return 0 if result["ok"] else 1


def _balance(client: Client, seed: int, speed_rpm: float, console: Console) -> dict[str, Any]:
    spec = replace(threshing_drum_example(seed), speed_rpm=speed_rpm)
    # Its clock runs ahead of ours: begun an hour ago, no reading is dated ahead of its receipt.
    clock = ManualClock(datetime.now(UTC) - timedelta(hours=1))
    # Names carry the moment, so that a demo may run again on the same database.
    stamp = f"{clock.now():%Y-%m-%d %H:%M:%S.%f}"
    session_id = _prepare(client, spec, stamp)
    show.heading(console, f"Simulated drum: {spec.rotor.mass_kg:g} kg at {speed_rpm:g} r/min, seed {seed}")
    with SimulatedDrum(spec, seed=seed, clock=clock, source=f"demo drum {stamp}") as drum:
        loop = Loop(client, drum, clock, session_id, seed, say=_teller(console))
        loop.learn()
        loop.correct()
        trims = 0
        while not loop.good_enough() and trims < MAX_TRIMS:
            trims += 1
            console.print("outside the limit: trim")
            loop.correct()
        report = loop.report()
    show.before_after(console, report["before_after"])
    show.placements(console, report["fitted"])
    log = client.get(f"/sessions/{session_id}/log")
    reductions = reductions_in(log)
    return {
        "ok": all(reduction >= GOAL for reduction in reductions.values()),
        "session_id": session_id,
        "trims": trims,
        "reductions": reductions,
        "before_after": report["before_after"],
        "placements": report["fitted"],
        "plan": {key: loop.plans[-1][key] for key in ("status", "message", "objective_value", "lower_bound", "gap")},
    }


def reductions_in(log: dict[str, Any]) -> dict[str, float]:
    """Share by which each sensor came down, from the first initial run to the latest check run of a log."""
    first = next(run for run in log["runs"] if run["kind"] == "initial")
    last = next(run for run in reversed(log["runs"]) if run["kind"] == "check")
    before = {reading["sensor"]: reading["amplitude"] for reading in first["readings"]}
    return {reading["sensor"]: 1.0 - reading["amplitude"] / before[reading["sensor"]] for reading in last["readings"]}


def _prepare(client: Client, spec: DrumSpec, stamp: str) -> str:
    """Store machine, box, source and session; returns the session."""
    limit = LIMIT_MM_S * (spec.speed_rpm / 460.0) ** 3
    machine = client.post("/machines", machine_of(spec, f"Demo drum {stamp}", limit_mm_s=limit))
    box = client.post("/catalogues", catalogue_of(f"Demo box {stamp}"))
    client.put(f"/sources/demo drum {stamp}", {"machine_id": machine["id"]})
    session = client.post("/sessions", {"machine_id": machine["id"], "catalogue_id": box["id"], "technician": "demo"})
    return str(session["id"])


def _field_experiment(client: Client, seed: int, console: Console) -> list[dict[str, Any]]:
    """The published drum with its balancer's answer: 1, 2 and 3 masses a plane, positions that take several."""
    stamp = f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S.%f}"
    body = machine_of(threshing_drum_example(), f"Published drum {stamp}", limit_mm_s=None)
    for plane in body["planes"]:
        plane["masses_per_position"] = 3
    machine = client.post("/machines", body)
    box = client.post("/catalogues", catalogue_of(f"Published box {stamp}", pieces=None))
    session = client.post("/sessions", {"machine_id": machine["id"], "catalogue_id": box["id"]})["id"]
    readings = [{"sensor": name, "amplitude": value, "phase_deg": None} for name, value in AS_FOUND_MM_S]
    client.post(f"/sessions/{session}/runs", {"kind": "initial", "readings": readings})
    masses = [{"plane": plane, "mass_g": mass, "angle_deg": angle} for plane, mass, angle in BALANCER_ANSWER]
    correction = client.post(f"/sessions/{session}/corrections", {"source": "balancer", "masses": masses})
    out = []
    for most in (1, 2, 3):
        request = {"correction_id": correction["id"], "objective": "components", "max_masses_per_plane": most}
        plan = client.post(f"/sessions/{session}/plans", request | {"seed": seed})
        out.append(
            {
                "max_masses_per_plane": most,
                "residual_g": plan["objective_value"] / machine["planes"][0]["radius_mm"],
                "status": plan["status"],
                "gap_gmm": plan["gap"],
                "placements": plan["placements"],
            }
        )
    show.field_experiment(console, out)
    return out


def _teller(console: Console) -> Callable[[str], None]:
    return lambda line: console.print(f"  {line}", soft_wrap=True)


def _wait(console: Console, address: str) -> None:
    console.print(f"The service goes on at {address} (API document: {address}/docs); Ctrl-C ends it.")
    try:
        while True:
            time.sleep(3600)
    except KeyboardInterrupt:
        console.print("stopped")
