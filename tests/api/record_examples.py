"""Examples of the API document, recorded from a session that really runs: `python -m tests.api.record_examples`.

The walk is the job a technician does, with fixed identifiers, clock and seed. Whoever adds an operation adds a step;
of each operation the first request and its answer become its example. Review the difference before it is stored.
"""

from __future__ import annotations

import json
import math
import re
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import service.api
from tests.support.http.workshop import (
    DRUM,
    LinearDrum,
    Workshop,
    application,
    box_body,
    mass,
    on_rotor,
    reading,
    workshop,
)

FILE = Path(service.api.__file__).with_name("examples.json")
THREE = LinearDrum(
    initial={**DRUM.initial, "M": 2.0 + 1.5j},
    influence={**DRUM.influence, ("M", "1"): 0.006 + 0.002j, ("M", "2"): 0.005 - 0.003j},
)
MACHINE = {
    "name": "Thresher 7",
    "type": "threshing drum",
    "rotor_mass_kg": 120.0,
    "service_speed_rpm": 460.0,
    "rotation": "cw",
    "seen_from": "the drive side",
    "balance_grade_mm_s": 16.0,
    "vibration_limit_mm_s": 0.8,
    "bearings": [{"name": "P", "axial_mm": -480.0}, {"name": "Q", "axial_mm": 440.0}],
    "planes": [
        {
            "name": name,
            "radius_mm": 330.0,
            "axial_mm": place,
            "positions_deg": [60.0 * hole for hole in range(6)],
            "hole_labels": [f"{name}{hole + 1}" for hole in range(6)],
            "max_masses": 3,
        }
        for name, place in (("1", -330.0), ("2", 330.0))
    ],
    "sensors": [
        {"name": "P", "axial_mm": -480.0, "bearing": "P", "direction": "horizontal"},
        {"name": "Q", "axial_mm": 440.0, "bearing": "Q", "direction": "horizontal"},
        {"name": "M", "axial_mm": 0.0, "direction": "vertical", "limit": 1.5},
    ],
}
DAY = "2025-12-01T12:"


class Recorder:
    """Requests to a workshop; of each operation the first one is kept with its answer."""

    def __init__(self, shop: Workshop) -> None:
        self.shop = replace_stopwatch(shop)
        self.examples: dict[str, dict[str, Any]] = {}
        self._operations: list[tuple[str, re.Pattern[str], str]] = [
            (method.upper(), re.compile(re.sub(r"{\w+}", "[^/]+", path) + "$"), operation["operationId"])
            for path, operations in application().openapi()["paths"].items()
            for method, operation in operations.items()
        ]

    def ask(self, method: str, path: str, body: Any = None) -> Any:
        """The answer, recorded."""
        answer = self.shop.ask(method, path, body)
        self._keep(method, path, {"response": answer} if body is None else {"request": body, "response": answer})
        return answer

    def stream(self, path: str) -> None:
        """A stream of events that ends by itself, recorded as the text it is."""
        answer = self.shop.client.get(f"/api/v1{path}")
        assert answer.is_success, answer.text
        self._keep("GET", path, {"response": answer.text})

    def name(self, method: str, path: str) -> str:
        """The operation that a request asks for."""
        plain = "/api/v1" + path.partition("?")[0]
        return next(name for verb, pattern, name in self._operations if verb == method and pattern.match(plain))

    def _keep(self, method: str, path: str, example: dict[str, Any]) -> None:
        self.examples.setdefault(self.name(method, path), example)


def replace_stopwatch(shop: Workshop) -> Workshop:
    """The workshop with a stop-watch that stands: how long a computer took is no part of an example."""
    application().state.work = replace(shop.work, monotonic=lambda: 0.0)
    return shop


def record() -> dict[str, dict[str, Any]]:
    """Every operation's example, in the order of its name."""
    with tempfile.TemporaryDirectory() as folder, workshop(f"sqlite:///{folder}/examples.db") as shop:
        return dict(sorted(walk(Recorder(shop)).examples.items()))


Walker = TypeVar("Walker", bound=Recorder)


def walk(recorder: Walker) -> Walker:
    """The job, every operation asked for through the recorder."""
    machine, box = prepare(recorder)
    study_designs(recorder)
    session = open_and_learn(recorder, machine, box)
    balance(recorder, session)
    look_back(recorder, machine, session)
    import_session(recorder, session)
    from_a_bridge(recorder, machine, box)
    arrange_bars(recorder, machine)
    recorder.ask("GET", f"/sessions/{session}/history?limit=3")
    recorder.ask("GET", "/history?limit=3")
    recorder.ask("GET", "/health")
    return recorder


def study_designs(recorder: Recorder) -> None:
    """A gear pair as published, checked, evaluated and chosen anew; a flywheel's energy against its mass."""
    recorder.ask("GET", "/designs")
    gear = {**recorder.ask("GET", "/designs/gear_pair")["document"], "published": []}
    recorder.ask("GET", "/designs/gear_pair/verdict")
    recorder.ask("POST", "/design-checks", {"document": {**gear, "gear": {**gear["gear"], "ratio": 0.5}}})
    recorder.ask("POST", "/design-evaluations", {"document": gear})
    recorder.ask("POST", "/design-optima", {"document": gear})
    wheel = {**recorder.shop.ask("GET", "/designs/flywheel_thresher")["document"], "published": [], "limits": {}}
    recorder.ask("POST", "/design-fronts", {"document": wheel, "points": 3})
    keep_designs(recorder, gear)


def keep_designs(recorder: Recorder, gear: dict[str, Any]) -> None:
    """A study that is kept and changed, and a run of it."""
    study = recorder.ask("POST", "/design-studies", {"name": "Gear of the drive", "document": gear})["id"]
    wider = {**gear, "design": {**gear["design"], "width": 95.0}}
    changed = {"name": "Gear of the drive", "document": wider, "note": "wider"}
    recorder.ask("PUT", f"/design-studies/{study}", changed)
    recorder.ask("GET", f"/design-studies/{study}")
    recorder.ask("GET", "/design-studies")
    recorder.ask("GET", f"/design-studies/{study}/versions")
    recorder.ask("GET", f"/design-studies/{study}/versions/1")
    run = recorder.ask("POST", "/design-runs", {"study_id": study})["id"]
    recorder.shop.work.background.wait(run)
    recorder.ask("GET", f"/design-runs/{run}")
    recorder.ask("GET", f"/design-runs?study_id={study}")
    recorder.ask("GET", f"/design-runs/{run}/now")
    recorder.stream(f"/design-runs/{run}/events")
    recorder.ask("DELETE", f"/design-runs/{run}")


def prepare(recorder: Recorder) -> tuple[str, str]:
    """A machine and a box, found in their lists, changed a little."""
    machine = recorder.ask("POST", "/machines", MACHINE)["id"]
    recorder.ask("GET", f"/machines/{machine}")
    recorder.ask("GET", "/machines?limit=1")
    recorder.ask("PATCH", f"/machines/{machine}", {"balance_grade_mm_s": 6.3})
    box = recorder.ask("POST", "/catalogues", box_body("Box of the workshop", 4, (50.0, 100.0, 200.0)))["id"]
    recorder.ask("GET", f"/catalogues/{box}")
    recorder.ask("GET", "/catalogues?limit=1")
    received, counted = [{"mass_g": 200.0, "pieces": 2}], [{"mass_g": 50.0, "pieces": 3}]
    recorder.ask("PATCH", f"/catalogues/{box}", {"received": received, "counted": counted})
    recorder.ask("POST", f"/catalogues/{box}/stock", {"kind": "received", "pieces": received, "note": "delivery 4711"})
    recorder.ask("POST", f"/catalogues/{box}/stock", {"kind": "withdrawn", "pieces": received, "note": "lent"})
    return machine, box


def arrange_bars(recorder: Recorder, machine: str) -> None:
    """Six rasp bars weighed whole: arranged, questioned, mounted."""
    places = [
        {"label": str(n + 1), "angle_deg": 60.0 * n, "radius_mm": 310.0, "axial_mm": [0.0], "kind": "bar"}
        for n in range(6)
    ]
    recorder.ask("PUT", f"/machines/{machine}/place-sets/rasp bars", {"places": places})
    recorder.ask("GET", f"/machines/{machine}/place-sets")
    masses = (6025.0, 5978.0, 5978.0, 6012.0, 5989.0, 6013.0)
    bars = [{"id": f"b{n}", "mass_g": mass, "kind": "bar", "present": str(n)} for n, mass in enumerate(masses, 1)]
    request = {"machine_id": machine, "set": "rasp bars", "parts": bars, "norm": "max", "scale_resolution_g": 1.0}
    made = recorder.ask("POST", "/arrangements", request)["id"]
    recorder.ask("GET", f"/arrangements/{made}")
    recorder.ask("GET", f"/arrangements?machine_id={machine}&limit=1")
    recorder.ask("GET", f"/arrangements/{made}/front")
    recorder.ask("POST", f"/arrangements/{made}/what-if", {"stay": ["b1"], "max_moves": 3, "replace": "4"})
    recorder.ask("POST", f"/arrangements/{made}/mounted", {"note": "after the season"})
    spare = {"place_set": "rasp bars", "parts": [{"part": "b7", "mass_g": 6003.0}], "note": "a spare from the shelf"}
    recorder.ask("POST", f"/machines/{machine}/parts", spare)
    recorder.ask("GET", f"/machines/{machine}/parts")
    recorder.ask("GET", f"/machines/{machine}/parts/history?part=b1&limit=3")


def run_body(kind: str, masses: list[dict[str, Any]], wander: complex = 0j) -> dict[str, Any]:
    """A run of the drum, its readings off by so much, with their scatter."""
    readings = [
        reading(sensor, vector * (1.0 + wander), speed_rpm=460.0, scatter=0.02)
        for sensor, vector in THREE.vibration(masses).items()
    ]
    return {"kind": kind, "masses": masses, "readings": readings}


def open_and_learn(recorder: Recorder, machine: str, box: str) -> str:
    """A session with an initial run, trial runs, and a run that was typed in wrong."""
    body = {"machine_id": machine, "catalogue_id": box, "technician": "A. Technician", "note": "after a new bar"}
    session = str(recorder.ask("POST", "/sessions", body)["id"])
    recorder.ask("GET", "/sessions?limit=1")
    recorder.ask("PATCH", f"/sessions/{session}", {"note": "after two new bars"})
    runs = f"/sessions/{session}/runs"
    recorder.shop.ask("POST", runs, run_body("initial", []))
    recorder.ask("GET", f"/sessions/{session}/trial-masses")
    recorder.ask("POST", runs, run_body("trial", [mass("1", 200.0, 0.0)], 0.003 + 0.002j))
    typo = recorder.ask("POST", runs, run_body("trial", [mass("1", 200.0, 0.0)]))["id"]
    recorder.ask("PATCH", f"{runs}/{typo}", {"excluded": True, "reason": "the mass was in plane 2"})
    recorder.ask("POST", runs, run_body("trial", [mass("2", 200.0, 0.0)], -0.002 + 0.003j))
    return session


def balance(recorder: Recorder, session: str) -> None:
    """Correction, plan, what if, off and on again, check, and what the session came to."""
    correction = recorder.ask("POST", f"/sessions/{session}/corrections", {"source": "fit"})["id"]
    request = {"correction_id": correction, "objective": "residual_vibration", "max_masses_per_plane": 1, "seed": 1}
    plan = recorder.ask("POST", f"/sessions/{session}/plans", request)
    path = f"/plans/{plan['id']}"
    recorder.ask("GET", path)
    recorder.ask("GET", f"{path}/front")
    recorder.ask("POST", f"{path}/what-if", {"missing": [{"mass_g": 200.0, "pieces": 6}]})
    recorder.ask("POST", f"{path}/reserve", {"minutes": 60})
    recorder.ask("GET", f"/catalogues/{plan['inputs']['catalogue_id']}/stock?limit=5")
    recorder.ask("POST", f"{path}/release")
    recorder.ask("POST", f"{path}/fitted", {})
    recorder.ask("POST", f"{path}/unfit")
    fitted = recorder.shop.ask("POST", f"{path}/fitted", {})["fitted"]
    check = run_body("check", on_rotor(fitted), 0.002 - 0.001j)
    del check["masses"]  # they default to the fitted plan
    recorder.ask("POST", f"/sessions/{session}/runs", check)
    for part in ("", "/report.json"):
        recorder.ask("GET", f"/sessions/{session}{part}")
    recorder.ask("GET", f"/sessions/{session}/log")


def import_session(recorder: Recorder, session: str) -> None:
    """A session just opened on another service: the same machine and box, an identifier of its own."""
    stored = recorder.shop.ask("GET", f"/sessions/{session}")
    body = {"machine_id": stored["machine_id"], "catalogue_id": stored["catalogue_id"]}
    other = recorder.shop.ask("POST", "/sessions", body)["id"]
    log = recorder.shop.ask("GET", f"/sessions/{other}/log")
    recorder.ask("POST", "/sessions/import", {**log, "session_id": f"{other}-elsewhere"})


def look_back(recorder: Recorder, machine: str, session: str) -> None:
    """What the session taught of the machine, and a second machine with it of their type."""
    recorder.ask("POST", f"/machines/{machine}/influence", {"session_id": session})
    recorder.ask("GET", f"/machines/{machine}/influence")
    shop = recorder.shop
    twin = shop.ask("POST", "/machines", {**MACHINE, "name": "Thresher 8"})["id"]
    other = shop.session(twin)
    for masses, wander in (([], 0j), ([mass("1", 200.0, 0.0)], 0.01 + 0j), ([mass("2", 200.0, 0.0)], -0.01j)):
        shop.ask("POST", f"/sessions/{other}/runs", run_body("trial" if masses else "initial", masses, wander))
    shop.ask("POST", f"/machines/{twin}/influence", {"session_id": other})
    recorder.ask("GET", "/influence-statistics?type=threshing%20drum")


def from_a_bridge(recorder: Recorder, machine: str, box: str) -> None:
    """What bridges, boxes and balancers send."""
    session = recorder.shop.session(machine, box)
    recorder.ask("PUT", "/sources/bridge 1", {"machine_id": machine})
    recorder.ask("GET", "/sources")
    stamp = {"source": "bridge 1", "taken_at": f"{DAY}00:00Z"}
    vectors = THREE.vibration([])
    sent = [{**stamp, "sequence": n, **reading(s, v, speed_rpm=460.0)} for n, (s, v) in enumerate(vectors.items())]
    recorder.ask("POST", "/readings", sent)
    recorder.ask("GET", f"/sessions/{session}/now")
    recorder.stream(f"/sessions/{session}/live?events=1")
    masses = [mass("1", 170.2, 70.0), mass("2", 292.2, 113.0)]
    recorder.ask("POST", "/balancer-answers", {**stamp, "sequence": 0, "session_id": session, "masses": masses})
    recorder.ask("GET", f"/sessions/{session}/balancer-answers")
    recorder.ask("POST", "/blocks", block(stamp))
    recorder.ask("GET", "/sources/bridge 1/readings?limit=1")
    wrong = {"source": "bridge 1", "sequences": [0], "reason": "the sensor hung loose"}
    recorder.ask("POST", "/readings/withdrawals", wrong)


def block(stamp: Mapping[str, Any]) -> dict[str, Any]:
    """A raw block: 0.2 m/s2 once a turn and 0.05 twice, over 16 turns at 480 r/min, 20 samples a turn."""
    turns, per_turn, frequency = 16, 20, 8.0
    angles = [math.tau * n / per_turn for n in range(turns * per_turn)]
    samples = [round(0.2 * math.cos(angle) + 0.05 * math.cos(2.0 * angle + 0.5), 4) for angle in angles]
    return {
        **stamp,
        "sequence": 100,
        "sample_rate_hz": per_turn * frequency,
        "channels": [{"sensor": "P", "samples": samples}],
        "edges_s": [turn / frequency for turn in range(turns)],
        "harmonics": 2,
    }


if __name__ == "__main__":
    FILE.write_text(json.dumps(record(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
