"""Every engine of the search against trying every arrangement, on problems with every feature."""

from __future__ import annotations

import numpy as np
import pytest

from service.balancing.arrangement import search_best, search_fewest, search_front, solve, within_limits
from service.balancing.arrangement.exact.bounds import relaxed_bound
from service.balancing.arrangement.exact.few_moves import open_changes
from service.balancing.arrangement.exact.slots import slots_of
from tests.balancing.arrangement.random_problems import FEATURES, NORMS, judge, random_problem, value_of

SEEDS = range(7)
CLOSE = 1e-9


@pytest.fixture(params=["as it comes", "never enumerated"])
def search(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Small problems are enumerated; without that the searches of large ones are put to the test."""
    if request.param == "never enumerated":
        monkeypatch.setattr(solve, "MAX_ENUMERATED", 0)
    return str(request.param)


@pytest.mark.parametrize("feature", FEATURES)
def test_the_least_objective_is_proved(feature: str, search: str) -> None:
    for norm in NORMS:
        for seed in SEEDS:
            problem = random_problem(feature, norm, seed)
            truth = judge(problem).value
            last = None
            for state in search_best(problem, np.random.default_rng(seed)):
                assert state.lower_bound <= truth * (1.0 + CLOSE) + CLOSE, (norm, seed)
                last = state
            assert last is not None
            assert last.proved
            assert last.value == pytest.approx(truth, rel=CLOSE, abs=1e-6), (norm, seed)
            if last.arrangement is not None:
                assert within_limits(problem, last.arrangement[None, :]).all()
                assert value_of(problem, last.arrangement.tolist()) == pytest.approx(truth, rel=CLOSE, abs=1e-6)


@pytest.mark.parametrize("feature", FEATURES)
def test_the_fewest_moves_are_proved(feature: str, search: str) -> None:
    for norm in NORMS:
        for seed in SEEDS[:3]:
            problem = random_problem(feature, norm, seed)
            every = judge(problem)
            reached = sorted(value for value in every.by_moves if np.isfinite(value))
            limit = 1.000001 * reached[len(reached) // 2] if reached else 1.0
            wanted = judge(problem, limit).fewest
            last = None
            for state in search_fewest(problem, limit, np.random.default_rng(seed)):
                assert wanted is None or state.moves_bound <= wanted[0], (norm, seed)
                last = state
            assert last is not None
            assert last.proved, (norm, seed)
            if wanted is None:
                assert last.arrangement is None
                continue
            assert last.arrangement is not None
            assert last.moves_bound == wanted[0], (norm, seed)
            fresh = int(np.append(problem.new, False)[last.arrangement].sum())
            assert fresh == wanted[1], (norm, seed)
            assert last.value == pytest.approx(wanted[2], rel=CLOSE, abs=1e-6), (norm, seed)


@pytest.mark.parametrize("feature", FEATURES)
def test_every_proved_point_of_the_front_is_the_best(feature: str, search: str) -> None:
    for norm in NORMS:
        for seed in SEEDS[:2]:
            problem = random_problem(feature, norm, seed)
            by_moves = np.minimum.accumulate(judge(problem).by_moves)
            front = list(search_front(problem, np.random.default_rng(seed)))[-1]
            for moved, state in front.items():
                assert not state.proved or state.value == pytest.approx(by_moves[moved], rel=CLOSE, abs=1e-6)
            proved = [moved for moved, state in front.items() if state.proved]
            slots = slots_of(problem)
            # Where places compete for their present parts, fewer moves are searched completely.
            searched = 4 if slots is None else 4 - open_changes(slots).again
            for moved in range(min(problem.places, searched) + 1):
                least = min((front[m].value for m in proved if m <= moved), default=np.inf)
                assert least == pytest.approx(by_moves[moved], rel=CLOSE, abs=1e-6), (norm, seed, moved)


def test_the_relaxed_bound_is_below_every_arrangement() -> None:
    for feature in FEATURES:
        for norm in NORMS:
            problem = random_problem(feature, norm, 3)
            slots = slots_of(problem)
            if slots is not None:
                assert relaxed_bound(slots).value <= judge(problem).value * (1.0 + CLOSE)
