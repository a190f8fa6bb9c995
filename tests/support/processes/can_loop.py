"""The whole way of a balancing job over CAN, run inside a network namespace: prints what came of it as JSON."""

from __future__ import annotations

import json
import sqlite3
import sys
import time
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx2

from drivers.can.bus import BusAddress
from drivers.can.mapping_file import standard_mapping
from drivers.can.sender import CanOut
from drivers.reading import Answer
from drivers.simulator.example import threshing_drum_example
from service.cli.support.demo_machine import catalogue_of, machine_of
from tests.support.processes.processes import Process, serve

SEED = 5
PORT, CONTROL = 8000, 8100
PER_RUN = 16
TRIAL_G = 200.0
ANSWER = (("1", 170.2, 70.0), ("2", 292.2, 113.0))


def main(folder: Path) -> None:
    """The drum is balanced by what the bridge carries; the service reads the same bus itself, as another source."""
    database = folder / "drumtrue.db"
    processes = [serve(database, PORT, "--can", "udp_multicast", "--source", "direct")]
    try:
        spool = str(folder / "spool.db")
        bridge = Process("bridge", "--can", "udp_multicast", "--spool", spool, "--status", "0.5")
        bridge.wait_for("bridge: ")
        processes.append(bridge)
        drum = Process(
            *("simulate", "--to", "can", "--control", f"127.0.0.1:{CONTROL}", "--seed", str(SEED), "--interval", "0.02")
        )
        processes.append(drum)
        drum.wait_for("posted")
        api = httpx2.Client(base_url=f"http://127.0.0.1:{PORT}/api/v1", trust_env=False, timeout=60.0)
        result = balance(api, database)
        result["answered"] = balance_by_the_balancer(api)
        result["statuses"] = [process.stop() for process in reversed(processes)]
        result["bridged"], result["direct"] = vectors(database, "can"), vectors(database, "direct")
        print(json.dumps(result))
    finally:
        for process in processes:
            if process.popen.poll() is None:
                process.kill()


def balance(api: httpx2.Client, database: Path) -> dict[str, Any]:
    """Initial run, trial runs, correction, plan, masses bolted on, check run."""
    spec = threshing_drum_example(SEED)
    machine = told(api.post("/machines", json=machine_of(spec, "drum")))
    box = told(api.post("/catalogues", json=catalogue_of("box")))
    for source in ("can", "direct"):
        told(api.put(f"/sources/{source}", json={"machine_id": machine["id"]}))
    session = told(api.post("/sessions", json={"machine_id": machine["id"], "catalogue_id": box["id"]}))["id"]
    run(api, database, session, "initial", [])
    for plane in spec.planes:
        run(api, database, session, "trial", [{"plane": plane.name, "mass_g": TRIAL_G, "angle_deg": 0.0}])
    correction = told(api.post(f"/sessions/{session}/corrections", json={"source": "fit"}))
    request = {"correction_id": correction["id"], "objective": "residual_vibration", "seed": 1}
    plan = told(api.post(f"/sessions/{session}/plans", json=request))
    fitted = told(api.post(f"/plans/{plan['id']}/fitted", json={}))["fitted"]
    pieces = [{"plane": p["plane"], "mass_g": p["mass_g"], "angle_deg": p["position_deg"]} for p in fitted]
    run(api, database, session, "check", pieces)
    report = told(api.get(f"/sessions/{session}/report.json"))
    return {
        "pieces": pieces,
        "reductions": [line["reduction"] for line in report["before_after"]],
        "plan": plan["status"],
    }


def balance_by_the_balancer(api: httpx2.Client) -> dict[str, Any]:
    """A plan for the masses that the balancer computed itself and told on the bus, each of them in one frame."""
    session = api.get("/sessions").json()[0]
    told(api.patch(f"/sessions/{session['id']}", json={"state": "closed"}))
    body = {"machine_id": session["machine_id"], "catalogue_id": told(api.get("/catalogues"))[0]["id"]}
    again = told(api.post("/sessions", json=body))["id"]
    out = CanOut(BusAddress("udp_multicast"), standard_mapping(("P", "Q"), ("1", "2")))
    out.answer(Answer("balancer", 1, datetime.now(UTC), ANSWER), 1)
    out.close()

    def listed() -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = told(api.get(f"/sessions/{again}/balancer-answers"))
        return found

    until(lambda: {one["source"] for one in listed()} == {"can", "direct"})
    bridged = next(one for one in listed() if one["source"] == "can")
    correction = told(
        api.post(f"/sessions/{again}/corrections", json={"source": "balancer", "answer_id": bridged["id"]})
    )
    request = {"correction_id": correction["id"], "objective": "components", "seed": 1}
    plan = told(api.post(f"/sessions/{again}/plans", json=request))
    return {"answers": listed(), "corrections": correction["corrections"], "plan": plan}


def run(api: httpx2.Client, database: Path, session: str, kind: str, masses: list[dict[str, Any]]) -> None:
    """Bolt on, let the drum run, and take the run from what came over the bus meanwhile."""
    told(httpx2.put(f"http://127.0.0.1:{CONTROL}/masses", json=masses, trust_env=False))
    begun = datetime.now(UTC)
    time.sleep(0.02 * PER_RUN)
    ended = datetime.now(UTC)
    take = {"source": "can", "from": begun.isoformat(), "to": ended.isoformat()}
    body = {"kind": kind, "masses": masses, "take": take}
    # The drum goes on: once a later reading is stored, all of this run are.
    until(lambda: newest(database) > f"{ended:%Y-%m-%d %H:%M:%S.%f}")
    told(api.post(f"/sessions/{session}/runs", json=body))


def vectors(database: Path, source: str) -> list[tuple[object, ...]]:
    """What is stored of a source, in its order."""
    query = "SELECT sensor, amplitude, phase_deg, speed_rpm FROM reading WHERE source = ? ORDER BY sequence"
    with closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        return list(connection.execute(query, (source,)))


def newest(database: Path) -> str:
    """When the newest stored reading was taken."""
    with closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        (moment,) = connection.execute("SELECT max(taken_at) FROM reading WHERE source = 'can'").fetchone()
    return moment or ""


def until(holds: Callable[[], bool], seconds: float = 20.0) -> None:
    """Wait for something to hold."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.02)


def told(answer: httpx2.Response) -> Any:
    """The body of a success."""
    assert answer.is_success, f"{answer.request.url}: {answer.text}"
    return answer.json()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
