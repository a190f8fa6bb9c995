"""How sure an answer is: the same figures wherever the draws are solved, and the spread of the readings in them."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from service.batch import executors, studies
from service.batch.executors import executor
from service.batch.studies import Study, study
from service.engine.logs.replay import read_log, resolve
from service.errors import InvalidInput, Unavailable
from service.model.plan import NormName, ObjectiveName
from service.model.session import SessionLog
from tests.batch.test_comparing import old_session

DRAWS = 10


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> SessionLog:
    """A session of the simulated drum whose readings have 2 % scatter."""
    return _scattered(old_session(tmp_path_factory.mktemp("study"), "one.json", 3), 0.02)


def _scattered(path: Path, part: float) -> SessionLog:
    stated = json.loads(path.read_text())
    for run in stated["runs"]:
        for reading in run["readings"]:
            reading["scatter"] = part * reading["amplitude"]
    return read_log(json.dumps(stated))


@pytest.fixture(scope="module")
def here(log: SessionLog) -> Study:
    return study(log, DRAWS, 7, workers=1)


def test_the_same_figures_on_one_process_on_two_and_on_a_cluster(log: SessionLog, here: Study) -> None:
    from distributed import LocalCluster

    assert study(log, DRAWS, 7, workers=2) == here
    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None, protocol="tcp"
    ) as cluster:
        assert study(log, DRAWS, 7, cluster=cluster.scheduler_address) == here
    assert study(log, 1, 8, workers=1) != study(log, 1, 7, workers=1)


def test_the_spread_is_that_of_the_readings(log: SessionLog) -> None:
    narrow, wide = (study(_with_scatter(log, part), 15, 1, workers=1) for part in (0.002, 0.02))
    assert narrow.answered == wide.answered == 15
    for small, large in zip(narrow.masses, wide.masses, strict=True):
        assert (large.high - large.low) / (small.high - small.low) == pytest.approx(10.0, rel=0.5)
    answer = resolve(log).corrections[-1]
    for mass, spread in zip(answer.corrections, narrow.masses, strict=True):
        assert spread.median == pytest.approx(mass.mass_g, rel=0.02)
        assert spread.low < spread.median < spread.high


def _with_scatter(log: SessionLog, part: float) -> SessionLog:
    runs = tuple(
        replace(run, readings=tuple(replace(one, scatter=part * one.amplitude) for one in run.readings))
        for run in log.runs
    )
    return replace(log, runs=runs, corrections=log.corrections[-1:], plans=())


@pytest.mark.parametrize(
    ("objective", "norm"),
    [
        ("residual_vibration", "sum"),
        ("residual_vibration", "max"),
        ("residual_vibration", "rms"),
        ("components", None),
        ("bearing_force", None),
    ],
)
def test_draws_answered_together_are_those_answered_alone(
    log: SessionLog, objective: ObjectiveName, norm: NormName | None
) -> None:
    """Fit, correction, plan and prediction, two masses a plane."""
    plan = log.plans[-1]
    asked = replace(plan.request, objective=objective, norm=norm, max_masses_per_plane=2)
    one = studies._last_only(replace(log, plans=(replace(plan, request=asked),)))
    assert studies.prepared_of(one, None) is not None
    together = studies.draw_some(one, range(12), 7, None)
    for number, draw in enumerate(together):
        alone = studies._alone(one, number, 7, None)
        assert draw.placements == alone.placements
        assert [name for name, _ in draw.predicted] == [name for name, _ in alone.predicted]
        assert [v for _, v in draw.predicted] == pytest.approx([v for _, v in alone.predicted], rel=1e-7, abs=1e-9)
        for (mass, angle), (same_mass, same_angle) in zip(draw.masses, alone.masses, strict=True):
            assert (mass, angle) == pytest.approx((same_mass, same_angle), rel=1e-8)


def test_without_scatter_every_draw_is_the_answer_itself(log: SessionLog) -> None:
    bare = tuple(replace(run, readings=tuple(replace(one, scatter=None) for one in run.readings)) for run in log.runs)
    unstated = replace(log, runs=bare)
    found = study(unstated, 3, 1, scatter=0.0, workers=1)
    assert found.same == 1.0
    for spread in (*found.masses, *found.predicted):
        assert spread.low == pytest.approx(spread.high, rel=1e-9)
    with pytest.raises(InvalidInput, match="must state its scatter in run 1"):
        study(unstated, 3, 1, workers=1)


def test_a_draw_without_an_answer_is_counted_with_its_reason(log: SessionLog) -> None:
    found = study(_with_scatter(log, 1.0), 8, 5, workers=1)
    assert found.answered + sum(count for _, count in found.refused) == found.draws == 8
    assert all(math.isfinite(spread.high) for spread in found.masses)


def test_a_session_without_an_answer_is_refused(log: SessionLog) -> None:
    with pytest.raises(InvalidInput, match="the session as it is cannot be solved"):
        study(replace(log, runs=log.runs[:1], corrections=(), plans=()), 3, 1, scatter=0.01, workers=1)


def test_no_cluster_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "CONNECT_S", 0.5)
    with pytest.raises(Unavailable, match="no Dask scheduler answers"), executor(cluster="tcp://127.0.0.1:9"):
        pass
