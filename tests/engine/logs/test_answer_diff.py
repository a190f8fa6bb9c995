"""Differences of answers: within the tolerance they are the same, within the stated uncertainty they are covered."""

from __future__ import annotations

from dataclasses import replace

from service.engine import correct, plan
from service.engine.logs.answer_diff import differences
from service.model.correction import Correction
from tests.support.numerics.drum_log import session

LOG = session()
WAS = correct(LOG)
PLAN = plan(LOG, WAS)


def lines(now: Correction, tolerance: float = 1e-9) -> tuple[str, ...]:
    return differences(((WAS,), ()), ((now,), ()), tolerance)


def heavier(grams: float) -> Correction:
    first = WAS.corrections[0]
    return replace(WAS, corrections=(replace(first, mass_g=first.mass_g + grams), *WAS.corrections[1:]))


def test_the_same_answers_differ_in_nothing() -> None:
    assert differences(((WAS,), (PLAN,)), ((WAS,), (PLAN,)), 1e-9) == ()


def test_a_mass_within_the_tolerance_is_the_same() -> None:
    greatest = max(one.mass_g for one in WAS.corrections)
    assert lines(heavier(0.9e-6 * greatest), 1e-6) == ()
    assert len(lines(heavier(1.1e-6 * greatest), 1e-6)) == 1


def test_a_mass_within_its_ellipse_is_covered_and_beyond_it_is_not() -> None:
    ellipse = WAS.corrections[0].ellipse
    assert ellipse is not None
    (covered,) = lines(heavier(0.5 * ellipse.minor_g))
    (beyond,) = lines(heavier(2.0 * ellipse.major_g))
    assert covered.endswith("(within its stated uncertainty)")
    assert not beyond.endswith("uncertainty)")


def test_a_plane_that_is_missing_is_told_once() -> None:
    assert lines(replace(WAS, corrections=WAS.corrections[:1])) == ("correction 1: planes 1, 2 -> 1",)


def test_a_plan_s_status_pieces_and_objective_are_compared() -> None:
    other = replace(PLAN, status="limit_reached", placements=PLAN.placements[1:], objective_value=9.0)
    found = differences(((), (PLAN,)), ((), (other,)), 1e-9)
    assert [line.split()[2] for line in found] == ["status", "placements", "objective"]
    assert differences(((), (PLAN,)), ((), (replace(PLAN, seconds=99.0),)), 1e-9) == ()


def test_lists_are_compared_as_far_as_the_log_goes() -> None:
    assert differences(((), ()), ((WAS,), (PLAN,)), 1e-9) == ()
