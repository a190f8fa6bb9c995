"""Methods of a plan under one deadline: what each proves, and what a mode needs."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import pytest

from service.engine.logs.replay import last_problem
from service.engine.plan_methods import limit_of_mode, prove, run_method
from service.errors import InvalidInput
from service.model.plan import PlanRequest
from tests.support.numerics.drum_log import session

POSED = last_problem(session())[1]
assert POSED is not None
PROBLEM = POSED.problem
REQUEST = PlanRequest(correction_id="c", objective="residual_vibration")


def clock(step: float = 0.0) -> Callable[[], float]:
    ticks = itertools.count()
    return lambda: step * next(ticks)


def test_the_certified_method_is_jaya_and_then_the_proof() -> None:
    solved = run_method(PROBLEM, REQUEST, 0.0, clock())
    assert [part.method for part in solved.parts] == ["modified_jaya", "exact"]
    assert solved.result.status == "optimal"
    assert solved.result.value <= solved.parts[0].result.value


def test_jaya_alone_proves_nothing() -> None:
    solved = run_method(PROBLEM, replace(REQUEST, method="modified_jaya"), 0.0, clock())
    assert solved.result.status == "heuristic"
    exact = run_method(PROBLEM, replace(REQUEST, method="exact"), 0.0, clock())
    assert solved.result.value >= exact.result.value * (1.0 - 1e-9)


def test_a_stop_ends_the_search_with_what_it_has() -> None:
    state = prove(PROBLEM, None, 0, 0.0, lambda: True)
    assert not state.proved
    assert state.value < float("inf")


def test_alternatives_are_the_next_best() -> None:
    solved = run_method(PROBLEM, replace(REQUEST, alternatives=3), 0.0, clock())
    values = [solved.result.value, *(one.value for one in solved.others)]
    assert len(values) == 4
    assert values == sorted(values)
    assert len({one.pieces for one in (solved.result, *solved.others)}) == 4


def test_the_fewest_masses_need_a_limit() -> None:
    fewest = replace(REQUEST, mode="fewest")
    assert limit_of_mode(fewest, None) == 1.0  # every sensor within its own
    assert limit_of_mode(replace(fewest, norm="sum"), 3.0) == 3.0  # what is mounted now
    for wrong in (replace(fewest, norm="sum"), replace(fewest, method="modified_jaya", limit=2.0)):
        with pytest.raises(InvalidInput):
            limit_of_mode(wrong, None)
    assert limit_of_mode(replace(REQUEST, mode="fewest", limit=2.0), None) == 2.0
    few = run_method(PROBLEM, replace(REQUEST, mode="fewest", limit=6.0), 0.0, clock()).result
    best = run_method(PROBLEM, REQUEST, 0.0, clock()).result
    assert few.pieces is not None
    assert best.pieces is not None
    assert few.value <= 6.0
    assert sum(map(len, few.pieces)) < sum(map(len, best.pieces))
