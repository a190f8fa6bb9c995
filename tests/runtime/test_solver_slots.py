"""Turns to compute: so many at once, the next are told to come again, and nothing is kept of a refused one."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace

import pytest

from service.errors import Unavailable
from service.runtime.solver_slots import SolverSlots
from tests.support.http.workshop import Workshop, application, problem_of


def test_a_turn_is_free_again_after_its_block_whatever_became_of_it() -> None:
    turns = SolverSlots(1, wait_s=0.0)
    for _ in range(3):
        with pytest.raises(KeyError), turns.turn():
            raise KeyError
    with turns.turn(), pytest.raises(Unavailable) as refused, turns.turn():
        pass
    assert (refused.value.code, refused.value.retry_after_s) == ("too_many_solves", 2)
    with turns.turn():
        pass


def test_sixteen_wait_for_a_turn_and_the_next_is_refused_at_once() -> None:
    turns = SolverSlots(1, wait_s=60.0)

    def compute() -> bool:
        with turns.turn():
            return True

    with ThreadPoolExecutor(16) as threads:
        with turns.turn():
            waiting = [threads.submit(compute) for _ in range(16)]
            # All are in the queue once it has no place left: one that was taken to look is given back at once.
            while turns._queue.acquire(blocking=False):
                turns._queue.release()
                assert not any(one.done() for one in waiting)
            with pytest.raises(Unavailable), turns.turn():
                pass
        assert all(one.result() for one in waiting)


def test_beyond_the_limit_a_plan_is_refused_with_when_to_come_again(shop: Workshop) -> None:
    turns = SolverSlots(2, wait_s=0.0)
    application().state.work = replace(shop.work, turns=turns)
    session = shop.session()
    shop.learn(session)
    plan = shop.plan(session, correction := shop.correct(session))
    body = {"correction_id": correction["id"], "objective": "components"}
    with ExitStack() as taken:
        for _ in range(2):
            taken.enter_context(turns.turn())
        for method, path, sent in (
            ("POST", f"/sessions/{session}/plans", body),
            ("POST", f"/plans/{plan['id']}/what-if", {}),
            ("GET", f"/plans/{plan['id']}/front", None),
        ):
            answer = shop.client.request(method, f"/api/v1{path}", json=sent, headers={"idempotency-key": "k"})
            assert problem_of(answer, 503, "too_many_solves")["advice"]
            assert answer.headers["retry-after"] == "2"
    assert shop.count("plan") == 1
    again = shop.client.post(f"/api/v1/sessions/{session}/plans", json=body, headers={"idempotency-key": "k"})
    assert again.status_code == 201
    assert shop.count("plan") == 2
