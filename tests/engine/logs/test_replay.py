"""A log read and solved again: the answers it holds come out, and others are told."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from service.engine import correct, plan
from service.engine.logs.replay import last_problem, read_log, resolve
from service.errors import InvalidInput
from service.model.base import write_json
from tests.support.numerics.drum_log import RUNS, machine, session

LOG = session()
CORRECTION = correct(LOG)
ANSWERED = replace(LOG, corrections=(CORRECTION,), plans=(plan(LOG, CORRECTION),))


def test_a_log_written_by_hand_is_numbered_and_timed() -> None:
    log = read_log(json.dumps({"machine": machine(), "runs": list(RUNS)}))
    assert [run.number for run in log.runs] == [1, 2, 3]
    assert len({run.id for run in log.runs}) == 3
    assert {run.nominal_speed_rpm for run in log.runs} == {460.0}


def test_a_log_reads_back_as_it_was_written() -> None:
    assert read_log(write_json(ANSWERED)) == ANSWERED


def test_answers_are_solved_again_and_are_the_same() -> None:
    found = resolve(ANSWERED)
    assert found.changed == ()
    assert found.corrections[0].corrections == CORRECTION.corrections
    assert found.plans[0].placements == ANSWERED.plans[0].placements


def test_a_log_without_answers_gets_one_of_each() -> None:
    found = resolve(LOG)
    assert (len(found.corrections), len(found.plans)) == (1, 1)
    assert resolve(session(box=None)).plans == ()


def test_an_answer_that_was_changed_is_told() -> None:
    first = CORRECTION.corrections[0]
    forged = replace(CORRECTION, corrections=(replace(first, mass_g=first.mass_g + 50.0), *CORRECTION.corrections[1:]))
    (line,) = resolve(replace(LOG, corrections=(forged,), plans=())).changed
    assert line.startswith("correction 1: plane 1:")


def test_the_last_problem_is_posed_again() -> None:
    fitted, posed = last_problem(ANSWERED)
    assert fitted is not None
    assert posed is not None
    assert len(posed.problem.planes) == 2


@pytest.mark.parametrize("text", ["", "[]", "{}", "nan", '{"machine": 3}', "[" * 100_000])
def test_what_is_no_log_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput):
        read_log(text)


def test_an_unknown_sensor_is_refused_with_its_place() -> None:
    wrong = json.loads(json.dumps(RUNS[0]).replace('"P"', '"X"'))
    with pytest.raises(InvalidInput) as refused:
        read_log(json.dumps({"machine": machine(), "runs": [wrong]}))
    assert refused.value.field == "runs[0].readings[0].sensor"
