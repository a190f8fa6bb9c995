"""`drumtrue demo` balances every drum it draws, and its log gives the same answers again."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from db.database import Database
from service.cli.commands.demo import run_demo
from service.engine.logs.replay import read_log, resolve
from service.model.base import to_plain, write_json
from service.model.session import SessionLog
from service.runtime.context import AppContext
from service.usecases.sessions import sessions
from tests.support.http.workshop import Workshop

SEEDS = range(1, 21)
SOLVED_AGAIN = range(1, 5)
"""Seeds whose log is solved again; the first of them by a fresh process."""
GOAL = 0.9


@pytest.fixture(scope="module")
def url(tmp_path_factory: pytest.TempPathFactory) -> str:
    """One database for all demos, as on a technician's laptop."""
    return f"sqlite:///{tmp_path_factory.mktemp('demo') / 'drumtrue.db'}"


def log_of(url: str, session_id: str) -> SessionLog:
    """The log of a session as it is stored, the service having ended."""
    database = Database(url)
    try:
        return sessions.log(AppContext(database=database), session_id)
    finally:
        database.close()


@pytest.mark.parametrize("seed", SEEDS)
def test_demo(url: str, seed: int, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run_demo(seed=seed, speed_rpm=460.0, as_json=True, serve=False, database_url=url) == 0
    said = json.loads(capsys.readouterr().out)
    log = log_of(url, said["session_id"])

    first = next(run for run in log.runs if run.kind == "initial")
    last = next(run for run in reversed(log.runs) if run.kind == "check")
    before, after = ({r.sensor: r.amplitude for r in run.readings} for run in (first, last))
    down = {sensor: 1.0 - after[sensor] / before[sensor] for sensor in ("P", "Q")}
    assert min(down.values()) >= GOAL
    assert said["reductions"] == pytest.approx(down)
    assert said["trims"] == sum(run.kind == "check" for run in log.runs) - 1 <= 1
    assert [f["residual_g"] for f in said["field_experiment"]] == pytest.approx([50.02, 4.880, 1.965], abs=0.005)

    if seed in SOLVED_AGAIN:
        text = write_json(log)
        (tmp_path / "log.json").write_text(text, encoding="utf-8")
        afresh = seed == SOLVED_AGAIN[0]
        assert_same_answers(text, solved(tmp_path / "log.json") if afresh else to_plain(resolve(read_log(text))))


def assert_same_answers(text: str, again: dict[str, Any]) -> None:
    """What was computed again is what the log holds."""
    assert again["changed"] == []
    logged = json.loads(text)
    for kind in ("corrections", "plans"):
        assert [answer(one) for one in again[kind]] == [answer(one) for one in logged[kind]]


def solved(file: Path) -> Any:
    """What a fresh `drumtrue solve` makes of a log."""
    command = [sys.executable, "-m", "service", "solve", str(file), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def answer(document: dict[str, Any]) -> dict[str, Any]:
    """What must come out again of a correction or plan: all but the time it took and what became of it later."""
    later = {"stale", "state", "version", "fitted", "seconds", "per_method", "bearing_forces_n", "predicted"}
    later |= {"changed_after_run", "changed_at"}
    return {key: value for key, value in document.items() if key not in later}


def test_the_same_question_has_the_same_answer(shop: Workshop) -> None:
    """The same session, seed and version; identifiers and times apart."""
    session = shop.session()
    shop.learn(session)
    correction = shop.correct(session)
    for method in ("modified_jaya", "exact", "certified"):
        request = {"method": method, "max_masses_per_plane": 3, "seed": 7}
        one, other = (shop.plan(session, correction, **request) for _ in range(2))
        for plan in (one, other):
            for key in ("id", "number", "seconds", "created_at"):
                del plan[key]
            for part in plan["per_method"]:
                del part["seconds"]
        assert one == other
