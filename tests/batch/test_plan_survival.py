"""Probabilities of a plan against Monte Carlo draws of the whole chain: readings, fit, prediction, selection."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.placements import vectors_of
from service.batch import drawn_answers, studies
from service.engine.logs.replay import last_problem, resolve
from service.engine.mapping import limits, placement_vectors
from service.engine.plan_solver import solve
from service.engine.plan_survival import plan_survival
from service.engine.selection_problem import pose
from service.model.plan import Robust
from service.model.session import SessionLog
from tests.batch.test_comparing import old_session
from tests.batch.test_studies import _scattered

CHAIN = 10_000


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> SessionLog:
    return studies._last_only(_scattered(old_session(tmp_path_factory.mktemp("survival"), "one.json", 3), 0.05))


def test_stated_probabilities_are_those_of_the_whole_chain(log: SessionLog) -> None:
    fitted, posed = last_problem(log)
    prepared = studies.prepared_of(log, None)
    assert fitted is not None
    assert posed is not None
    assert prepared is not None
    vectors = placement_vectors(log.machine, resolve(log).plans[-1].placements)
    nothing = vectors_of(posed.problem, tuple(() for _ in log.machine.planes))
    asked = replace(posed.request, objective="robust", robust=Robust(aim="probability_within_limits"))
    robust = solve(pose(posed.ground, asked), time.process_time).result.vectors
    stated = plan_survival(posed, [vectors, nothing, robust])
    assert stated is not None
    assert stated.best is not None
    assert stated.within is not None
    vibration = drawn_answers._vibration(prepared, range(CHAIN), 11)
    initial, influence, good = drawn_answers._fit(prepared, vibration)
    assert good.all()
    answers = drawn_answers.answer(prepared, range(CHAIN), 11)
    allowed = limits(log.machine, fitted.rows)
    for number, candidate in enumerate((vectors, nothing, robust)):
        left = drawn_answers._amplitudes(initial, influence, np.repeat(candidate[None], CHAIN, axis=0))
        assert stated.within[number] == pytest.approx((left <= allowed).all(axis=1).mean(), abs=0.02)
        value = (left / allowed).sum(axis=1)
        assert stated.quantile_95[number] == pytest.approx(np.quantile(value, 0.95), rel=0.05)
        same = (answers.amplitudes / allowed).sum(axis=1) >= value * (1.0 - 1e-9)
        assert stated.best[number] == pytest.approx(same.mean(), abs=0.02)


def test_without_scatter_nothing_is_stated(log: SessionLog) -> None:
    bare = tuple(replace(run, readings=tuple(replace(one, scatter=None) for one in run.readings)) for run in log.runs)
    initial_and_trials = replace(log, runs=bare)
    _, posed = last_problem(initial_and_trials)
    assert posed is not None
    found = plan_survival(posed, [np.zeros(len(log.machine.planes), dtype=np.complex128)])
    known = posed.fitted is not None and bool(np.isfinite(posed.fitted.fit.covariance).all())
    assert (found is not None) is known
