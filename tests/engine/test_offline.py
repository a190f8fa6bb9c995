"""Correct and plan in memory; through it the modules of a plan: problem, methods, kept masses, alternatives."""

from __future__ import annotations

import pytest

from service.engine import correct, plan
from service.errors import InvalidInput, NumericsError
from tests.support.numerics.drum_log import RUNS, session

LOG = session()


def test_a_session_is_corrected_and_planned() -> None:
    chosen = plan(LOG, correct(LOG))
    assert chosen.status in ("optimal", "within_uncertainty")
    assert chosen.objective_value is not None
    assert chosen.lower_bound is not None
    assert chosen.lower_bound <= chosen.objective_value
    assert {piece.plane for piece in chosen.placements} == {"1", "2"}


def test_the_same_question_has_the_same_answer() -> None:
    one, other = (plan(LOG, correct(LOG)) for _ in range(2))
    assert one.placements == other.placements
    assert one.objective_value == other.objective_value


def test_a_session_without_a_box_has_no_plan() -> None:
    bare = session(box=None)
    with pytest.raises(InvalidInput):
        plan(bare, correct(bare))


def test_too_few_runs_are_refused() -> None:
    with pytest.raises((InvalidInput, NumericsError)):
        correct(session(RUNS[:2]))
