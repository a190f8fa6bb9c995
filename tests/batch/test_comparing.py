"""Old sessions solved again: what is the same, what changed, what cannot be solved, over several processes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from drivers.clock import ManualClock
from drivers.simulator.drum_driver import SimulatedDrum, threshing_drum_example
from drivers.simulator.spec import FittedMass
from service.batch.comparing import compare_folder, compare_one, summary
from service.cli.support.demo_machine import catalogue_of, machine_of
from service.engine.logs.replay import read_log, resolve
from service.errors import InvalidInput
from service.model.base import to_plain

PIECES: tuple[list[FittedMass], ...] = ([], [FittedMass("1", 200.0, 0.0)], [FittedMass("2", 200.0, 0.0)])


def old_session(folder: Path, name: str, seed: int) -> Path:
    """A session as it was logged, with its answers."""
    spec = threshing_drum_example(seed)
    log: dict[str, object] = {"format": "drumtrue-session", "machine": machine_of(spec, f"drum {seed}")}
    log["catalogue"] = catalogue_of("box")
    runs = []
    with SimulatedDrum(spec, seed=seed, clock=ManualClock()) as drum:
        for pieces in PIECES:
            drum.fit_masses(pieces)
            stated = [
                {"sensor": one.sensor, "amplitude": one.amplitude, "phase_deg": one.phase_deg}
                for one in drum.measure(1)
            ]
            masses = [{"plane": p.plane, "mass_g": p.mass_g, "angle_deg": p.angle_deg} for p in pieces]
            runs.append({"kind": "trial" if pieces else "initial", "masses": masses, "readings": stated})
    log["runs"] = runs
    text = json.dumps(log)
    answers = to_plain(resolve(read_log(text)))
    path = folder / name
    path.write_text(json.dumps(log | {"corrections": answers["corrections"], "plans": answers["plans"]}))
    return path


def test_every_answer_that_changed_is_listed_and_only_those(tmp_path: Path) -> None:
    for seed in (1, 2):
        old_session(tmp_path, f"same{seed}.json", seed)
    changed = old_session(tmp_path, "changed.json", 3)
    log = json.loads(changed.read_text())
    log["corrections"][0]["corrections"][0]["mass_g"] += 1.0
    log["corrections"][0]["predicted"][1]["amplitude"] += 0.1
    log["plans"][0]["predicted"][0]["phase_deg"] += 1.0
    log["plans"][0]["objective_value"] *= 1.1
    log["plans"][0]["status"] = "heuristic"
    changed.write_text(json.dumps(log))
    (tmp_path / "broken.json").write_text("{")
    said: list[str] = []
    found = {Path(one.path).name: one for one in compare_folder(tmp_path, said.append, workers=2)}
    assert found["same1.json"].changed == found["same2.json"].changed == ()
    assert found["same1.json"].answers == 2
    assert [re.sub(r" [-0-9.e]+ .*", "", line) for line in found["changed.json"].changed] == [
        "correction 1: plane 1:",
        "correction 1: predicted Q:",
        "plan 1: status heuristic -> optimal",
        "plan 1: objective",
        "plan 1: predicted P:",
    ]
    assert found["broken.json"].error is not None
    assert summary(list(found.values())) == "4 sessions, 6 answers: 1 sessions changed, 1 could not be solved"
    assert [line.split("]")[0] for line in said if line.startswith("[")] == ["[1/4", "[2/4", "[3/4", "[4/4"]


def test_a_change_within_the_tolerance_is_none_and_one_within_the_uncertainty_is_said_to_be(tmp_path: Path) -> None:
    path = old_session(tmp_path, "old.json", 3)
    log = json.loads(path.read_text())
    mass = log["corrections"][0]["corrections"][1]
    mass["mass_g"] *= 1.0 + 1e-7
    path.write_text(json.dumps(log))
    assert compare_one(str(path)).changed == ()
    assert len(compare_one(str(path), tolerance=1e-9).changed) == 1
    mass["mass_g"] += 5.0
    mass["ellipse"] = {"major_g": 10.0, "minor_g": 6.0, "angle_deg": 33.0, "confidence": 0.95}
    log["corrections"][0]["corrections"][0]["angle_deg"] += 10.0
    path.write_text(json.dumps(log))
    first, second = compare_one(str(path)).changed
    assert first.startswith("correction 1: plane 1: ")
    assert "uncertainty" not in first
    assert second.endswith("(within its stated uncertainty)")
    assert compare_one(str(path), tolerance=10.0).changed == ()


def test_a_file_that_is_gone_is_told_not_raised(tmp_path: Path) -> None:
    assert "cannot be read" in (compare_one(str(tmp_path / "gone.json")).error or "")


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="must hold session logs"):
        compare_folder(tmp_path, print)
