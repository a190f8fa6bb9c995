"""Other answers: the next best, the front, the fewest within a limit, preferences within a slack, why none."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest

from service.balancing.selection.alternatives import best_selections, front, most_pieces, prefer, solve_fewest
from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.objectives import components, evaluate
from service.balancing.selection.placements import broken_limit, effective_g, vectors_of
from service.balancing.selection.problem import Piece, SelectionProblem
from service.errors import NumericsError
from service.messages import Message, render
from tests.support.numerics.problems import even_positions, field_experiment, plane, stock
from tests.support.numerics.random_problems import KINDS, random_problem

CLOSE = 1e-8


def told(message: Message | None) -> str:
    return "" if message is None else render(message)


def every_selection(problem: SelectionProblem) -> list[tuple[float, int, float]]:
    """Value, pieces and mass of every selection, one position and item at a time."""
    pairs = [Piece(h, i) for h in range(len(problem.planes[0].angles)) for i in range(len(problem.stock.masses_g))]
    choices = [(), *((p,) for p in pairs), *((p, q) for p, q in product(pairs, pairs) if p <= q)]
    mass = effective_g(problem.stock)
    found = []
    for selection in product(choices, repeat=len(problem.planes)):
        if broken_limit(problem, selection) is None:
            value = float(evaluate(problem.objective, vectors_of(problem, selection)))
            pieces = [p for chosen in selection for p in chosen]
            found.append((value, len(pieces), sum(float(mass[p.item]) for p in pieces)))
    return sorted(found)


def small() -> SelectionProblem:
    """Two planes of three uneven positions, two pieces a plane, three masses, few in the box."""
    angles = np.deg2rad(np.array([10.0, 130.0, 275.0]))
    objective = components(np.array([40.0 * np.exp(1j), 25.0 * np.exp(3j)]), np.array([300.0, 200.0]))
    box = replace(stock((10.0, 15.0, 40.0)), counts=np.array([2, 1, 2]))
    return SelectionProblem(objective, (plane(angles, 2, capacity=1), plane(angles, 2)), box)


@cache
def judged() -> list[tuple[float, int, float]]:
    """Every selection of the small problem, best first."""
    return every_selection(small())


def test_the_k_best_are_the_k_best() -> None:
    judge = judged()
    found = best_selections(small(), 25)
    assert [r.value for r in found] == pytest.approx([value for value, _, _ in judge[:25]], rel=CLOSE)
    assert len({r.pieces for r in found}) == 25
    assert all(r.pieces is not None and broken_limit(small(), r.pieces) is None for r in found)
    assert {r.status for r in found} == {"optimal"}


def test_asked_for_more_than_there_are_gives_all() -> None:
    judge = judged()
    found = best_selections(small(), len(judge) + 10)
    assert [r.value for r in found] == pytest.approx([value for value, _, _ in judge], rel=CLOSE)


def test_the_front_is_the_best_for_each_number_of_pieces() -> None:
    judge = judged()
    points = list(front(small()))
    assert [p.pieces for p in points] == sorted({p.pieces for p in points})
    for point in points:
        best = min(value for value, pieces, _ in judge if pieces <= point.pieces)
        assert point.result.value == pytest.approx(best, rel=CLOSE)
        assert point.result.pieces is not None
        assert sum(len(p) for p in point.result.pieces) == point.pieces
    assert points[-1].result.value == pytest.approx(judge[0][0], rel=CLOSE)


@pytest.mark.parametrize("kind", KINDS)
def test_the_front_ends_at_the_optimum_and_equals_brute_force(kind: str) -> None:
    for seed in range(6):
        problem = random_problem(kind, 300 + seed)
        points = list(front(problem))
        for point in points:
            judge = solve_exhaustive(problem, most_pieces=point.pieces)
            assert point.result.value == pytest.approx(judge.value, rel=CLOSE, abs=CLOSE)
        assert points[-1].result.value == pytest.approx(solve_exact(problem).value, rel=CLOSE, abs=CLOSE)


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 1.0])
def test_the_fewest_that_meet_a_limit(part: float) -> None:
    judge = judged()
    worst = judge[0][0] + part * (float(evaluate(small().objective, np.zeros(2, complex))) - judge[0][0])
    found = solve_fewest(small(), worst)
    needed = min(pieces for value, pieces, _ in judge if value <= worst * (1.0 + CLOSE))
    assert found.status == "optimal"
    assert found.details["at_least"] == needed
    assert found.value == pytest.approx(min(v for v, pieces, _ in judge if pieces == needed), rel=CLOSE)


@pytest.mark.parametrize("slack", [0.0, 500.0, 2000.0, 6000.0])
def test_within_a_slack_fewest_pieces_then_least_mass(slack: float) -> None:
    judge = judged()
    best = solve_exact(small())
    found = prefer(small(), best, slack)
    good = [(pieces, mass) for value, pieces, mass in judge if value <= best.value + slack + 1e-6]
    assert found.pieces is not None
    mass = sum(float(effective_g(small().stock)[p.item]) for chosen in found.pieces for p in chosen)
    assert (sum(len(p) for p in found.pieces), mass) == min(good)
    assert found.lower_bound == best.lower_bound


def test_equals_are_told_apart_by_stock() -> None:
    """20 g at one position, or the same effect from a rarer 20 g mass with another fastener."""
    objective = components(np.array([20j]), np.array([100.0]))
    box = replace(stock((20.0, 18.0, 15.0)), fasteners_g=np.array([0.0, 2.0, 5.0]), counts=np.array([2, 9, 1]))
    found = solve_exact(SelectionProblem(objective, (plane(even_positions(4), 2),), box))
    assert found.pieces == ((Piece(0, 1),),)


def test_no_selection_meets_the_limit_and_the_reason_says_what_would() -> None:
    objective = components(np.array([60j]), np.array([100.0]))
    one = SelectionProblem(objective, (plane(even_positions(4), 2, capacity=1),), stock((20.0,), counts=2))
    refused = solve_fewest(one, 1.0)
    assert refused.status == "infeasible"
    assert refused.pieces is None
    assert math.isinf(refused.value)
    assert refused.details["nearest"] == pytest.approx(2000.0)
    assert refused.details["missing"] == pytest.approx(1999.0)
    assert refused.reason is not None
    assert "leaves 2000, the limit is 1" in told(refused.reason)
    assert "no single change is enough" in told(refused.reason)
    roomy = replace(one, planes=(plane(even_positions(4), 3),))
    assert "one more 20 g piece" in told(solve_fewest(roomy, 1.0).reason)
    tight = replace(one, planes=(plane(even_positions(4), 2),), stock=stock((20.0, 60.0)))
    blocked = replace(tight.planes[0], capacity=np.array([0, 1, 1, 1]))
    assert "the blocked positions" in told(solve_fewest(replace(tight, planes=(blocked,)), 1.0).reason)
    light = replace(tight.planes[0], max_mass_g=45.0)
    assert "no limit on the mass of a plane" in told(solve_fewest(replace(tight, planes=(light,)), 1.0).reason)


def test_what_no_mass_can_do_is_said() -> None:
    whole = field_experiment(2)
    tall = replace(
        whole.objective,
        matrix=np.array([[0.01, 0.0], [0.01, 0.0], [0.0, 0.01]], dtype=np.complex128),
        offset=np.array([1.0, -1.0, 0.3j]),
        weights=np.ones(3),
        norm="sum",
    )
    refused = solve_fewest(replace(whole, objective=tall), 0.5)
    assert refused.status == "infeasible"
    assert refused.details["continuous"] == pytest.approx(2.0, rel=1e-3)
    assert "another cause than unbalance" in told(refused.reason)


def test_stops_are_honest() -> None:
    stopped = solve_fewest(field_experiment(3), 1.0, stop=lambda: True)
    assert stopped.status == "limit_reached"
    assert {r.status for r in best_selections(field_experiment(3), 3, stop=lambda: True)} == {"limit_reached"}
    assert [p.pieces for p in front(field_experiment(3), stop=lambda: True)] == [0]


def test_wrong_questions_are_refused() -> None:
    with pytest.raises(NumericsError, match="at least 1 selection must be asked for, got 0"):
        best_selections(small(), 0)
    with pytest.raises(NumericsError, match="a limit must be 0 or more, got nan"):
        solve_fewest(small(), math.nan)
    with pytest.raises(NumericsError, match="a slack must be 0 or more, got -1"):
        prefer(small(), solve_exact(small()), -1.0)
    assert most_pieces(small()) == 4


class Ticks:
    """A stop that says yes after so many questions."""

    def __init__(self, many: int) -> None:
        self.left = many

    def __call__(self) -> bool:
        self.left -= 1
        return self.left < 0


def test_a_slack_without_time_to_use_it_says_so() -> None:
    """After however many steps it ends: proved is what equals the judge, the rest is told as open."""
    judge, best, slack = judged(), solve_exact(small()), 6000.0
    good = min((pieces, mass) for value, pieces, mass in judge if value <= best.value + slack + 1e-6)
    proved = set()
    for many in range(0, 120, 8):
        found = prefer(small(), best, slack, stop=Ticks(many))
        assert found.pieces is not None
        assert found.value <= best.value + slack * (1.0 + CLOSE)
        pieces = [p for chosen in found.pieces for p in chosen]
        kept = (len(pieces), sum(float(effective_g(small().stock)[p.item]) for p in pieces))
        proved.add(found.details["slack_proved"])
        if found.details["slack_proved"]:
            assert kept == good
            assert "stopped" not in told(found.message)
        else:
            assert "; stopped before" in told(found.message)
        if found.value == best.value:
            assert kept >= good
    assert proved == {0.0, 1.0}
    assert "slack_proved" not in prefer(small(), best, 0.0).details


def test_as_few_pieces_are_all_that_a_front_and_the_fewest_speak_of() -> None:
    points = list(front(small()))
    assert len(points) > 2
    for point in points[:-1]:
        assert told(point.result.message) == "proved: no selection of as few pieces is better"
    fewest = solve_fewest(small(), points[1].result.value)
    assert (
        told(fewest.message) == "1 piece meets the limit, fewer do not; proved: no selection of as few pieces is better"
    )
    none = solve_fewest(small(), points[0].result.value)
    assert told(none.message).startswith("the limit is met without any piece; proved: no selection of as few")
    assert told(solve_exact(small()).message) == "proved: no selection within the limits is better"


def infeasible_box() -> SelectionProblem:
    """90 g are wanted in one hole that takes all; the box holds two pieces of 20 g, three may be fitted."""
    objective = components(np.array([90j]), np.array([100.0]))
    return SelectionProblem(objective, (plane(even_positions(4), 3),), stock((20.0, 15.0), counts=2))


def test_reasons_cut_short_say_so() -> None:
    """However early the time is over, a reason names only what helps, and says when not everything was tried."""
    limit = 1600.0  # 32 g may be missing: three pieces of 20 g will do
    whole = told(solve_fewest(infeasible_box(), limit).reason)
    assert "it can be met with one more piece in each plane or one more 20 g piece" in whole
    assert "no time" not in whole
    begun = 0
    for many in range(0, 200, 9):
        found = solve_fewest(infeasible_box(), limit, stop=Ticks(many))
        if found.status != "infeasible":
            continue
        begun += 1
        reason = told(found.reason)
        assert ("no time to try" in reason) or reason == whole
        assert "no single change is enough" not in reason
        assert "one more 15 g piece" not in reason
    assert begun > 6


def test_a_long_box_is_told_in_a_short_reason() -> None:
    """Thirteen kinds, one piece of each, and one piece too few: whichever is bought helps."""
    objective = components(np.array([14 * 20.24]), np.array([100.0]))
    kinds = tuple(20.0 + 0.04 * n for n in range(13))
    one = SelectionProblem(objective, (plane(even_positions(1), 14),), stock(kinds, counts=1))
    reason = told(solve_fewest(one, 100.0).reason)
    assert reason.count("one more") == 12
    assert ", or with 1 other pieces" in reason
