"""Plans: pieces, proof and prediction, judged by the drum's own arithmetic."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import pytest

from service.engine import correct, plan
from service.engine.logs.replay import last_problem
from service.engine.plan_solver import changes_of, forces, refitted
from service.engine.selection_problem import pose
from service.model.plan import BlockedPosition, Plan
from tests.support.numerics.drum_log import session, still

LOG = session()
CORRECTION = correct(LOG)
POSED = last_problem(LOG)[1]
assert POSED is not None
GROUND = POSED.ground


def sums(made: Plan) -> dict[str, complex]:
    out = {"1": 0j, "2": 0j}
    for piece in made.placements:
        out[piece.plane] += cmath.rect(piece.mass_g, math.radians(piece.position_deg))
    return out


def test_the_value_is_what_the_pieces_leave_over_the_limits() -> None:
    made = plan(LOG, CORRECTION)
    left = [abs(still(sensor, sums(made))) for sensor in ("P", "Q")]
    assert made.objective_value == pytest.approx(sum(left) / 0.7)
    assert [one.amplitude for one in made.predicted] == pytest.approx(left)


@pytest.mark.parametrize(("norm", "of"), [("max", max), ("rms", lambda v: math.sqrt(sum(x * x for x in v) / len(v)))])
def test_norms(norm: str, of: object) -> None:
    made = plan(LOG, CORRECTION, norm=norm)
    left = [abs(still(sensor, sums(made))) / 0.7 for sensor in ("P", "Q")]
    assert made.objective_value == pytest.approx(of(left))  # type: ignore[operator]


def test_components_are_what_is_missed_of_the_correction() -> None:
    """Half the sum of both components of both planes, g.mm."""
    made = plan(LOG, CORRECTION, objective="components")
    wanted = {one.plane: cmath.rect(one.mass_g, math.radians(one.angle_deg)) for one in CORRECTION.corrections}
    missed = [sums(made)[name] - wanted[name] for name in ("1", "2")]
    assert made.objective_value == pytest.approx(330.0 * 0.5 * sum(abs(m.real) + abs(m.imag) for m in missed))
    assert made.objective_unit == "g.mm"


def test_an_infeasible_problem_is_an_answer_with_its_reason() -> None:
    """All holes blocked and a limit that nothing meets."""
    every = tuple(BlockedPosition(plane=name, position_deg=20.0 * hole) for name in ("1", "2") for hole in range(18))
    made = plan(LOG, CORRECTION, mode="fewest", limit=1e-6, blocked=every)
    assert made.status == "infeasible"
    assert made.placements == ()
    assert made.reason


def test_the_prediction_is_done_again_for_what_was_really_mounted() -> None:
    made = plan(LOG, CORRECTION)
    lighter = tuple(replace(piece, weighed_g=piece.mass_g - 5.0) for piece in made.placements)
    again = refitted(GROUND, made, lighter)
    taken = dict.fromkeys(("1", "2"), 0j)
    for piece in lighter:
        taken[piece.plane] += cmath.rect(piece.mass_g - 5.0, math.radians(piece.position_deg))
    assert [one.amplitude for one in again.predicted] == pytest.approx([abs(still(s, taken)) for s in ("P", "Q")])


def test_changes_begin_with_what_comes_off() -> None:
    """The trial mass at 80 degrees is still on."""
    made = plan(LOG, CORRECTION)
    found = changes_of(GROUND, made.placements, ())
    assert {one.action for one in found} <= {"remove", "add", "keep"}
    assert len([one for one in found if one.action != "remove"]) == len(made.placements)


def test_bearing_forces_before_are_those_of_the_unbalance_that_the_correction_states() -> None:
    """Nothing mounted: before and after are equal; mounted as asked for: none is left."""
    problem = pose(GROUND, POSED.request if POSED is not None else GROUND.correction)  # type: ignore[arg-type]
    none = forces(LOG.machine, problem.target, 0.0 * problem.target)
    exact = forces(LOG.machine, problem.target, problem.target)
    assert none is not None
    assert exact is not None
    assert none.before == pytest.approx(none.after)
    assert exact.after == pytest.approx([0.0, 0.0], abs=1e-9)
    assert forces(replace(LOG.machine, sensors=()), problem.target, problem.target) is None
