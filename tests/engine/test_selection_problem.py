"""A plan's problem in arrays: blocked holes, kept pieces and limits; and selections as pieces in holes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from service.balancing.selection.problem import Piece
from service.engine import correct
from service.engine.logs.replay import last_problem
from service.engine.selection_problem import PlanProblem, fit_of, pose
from service.engine.validation import label_at
from service.errors import InvalidInput
from service.model.plan import BlockedPosition, Placement, PlanRequest
from service.model.run import MassOnRotor
from tests.support.numerics.drum_log import INFLUENCE, INITIAL, session

LOG = session()
POSED = last_problem(LOG)[1]
assert POSED is not None
GROUND = POSED.ground
REQUEST = PlanRequest(correction_id=GROUND.correction.id, objective="residual_vibration")


def posed(**changes: object) -> PlanProblem:
    return pose(GROUND, replace(REQUEST, **changes))  # type: ignore[arg-type]


def test_the_objective_is_the_drum_over_its_limits() -> None:
    objective = posed().objective
    np.testing.assert_allclose(objective.offset, [INITIAL["P"], INITIAL["Q"]], rtol=1e-9)
    np.testing.assert_allclose(objective.matrix[0], [INFLUENCE["P", "1"], INFLUENCE["P", "2"]], rtol=1e-9)
    np.testing.assert_allclose(objective.weights, [1.0 / 0.7] * 2)


def test_blocked_holes_take_nothing() -> None:
    found = posed(blocked=(BlockedPosition(plane="1", position_deg=40.0),)).problem.planes
    assert np.flatnonzero(found[0].capacity == 0).tolist() == [2]
    assert (found[1].capacity > 0).all()


def test_the_fewer_of_two_limits_on_the_number_counts() -> None:
    assert [plane.max_pieces for plane in posed(max_masses_per_plane=2).problem.planes] == [2, 2]
    assert [plane.max_pieces for plane in posed(max_masses_per_plane=9).problem.planes] == [3, 3]


def test_the_force_that_a_hole_takes_limits_its_grams() -> None:
    """0.766 N for each gram: 76.6 N are 100 g."""
    planes = tuple(replace(plane, max_force_n=76.575) for plane in GROUND.machine.planes)
    limited = replace(GROUND, machine=replace(GROUND.machine, planes=planes))
    assert pose(limited, REQUEST).problem.planes[0].capacity_g[0] == pytest.approx(100.0, rel=1e-3)


def test_a_selection_is_placements_with_the_holes_names() -> None:
    problem = posed()
    on, off = problem.placements(((Piece(2, 4),), (Piece(0, 0), Piece(17, 5))))
    assert [(one.plane, one.position_deg, one.mass_g) for one in on] == [
        ("1", 40.0, 200.0),
        ("2", 0.0, 10.0),
        ("2", 340.0, 300.0),
    ]
    assert [one.hole for one in on] == [label_at(GROUND.machine.planes[0], one.position_deg) for one in on]
    assert off == ()


def test_kept_pieces_use_up_their_place() -> None:
    kept = Placement(plane="1", position_deg=40.0, hole="3", mass_g=50.0)
    present = replace(GROUND, inputs=replace(GROUND.inputs, present=(kept,)))
    plane = pose(present, replace(REQUEST, base="present")).problem.planes[0]
    assert (plane.capacity[2], plane.max_pieces) == (0, 2)


def test_a_plan_rests_on_the_fit_of_its_correction() -> None:
    assert fit_of(GROUND) is not None
    balancer = correct(LOG, source="balancer", masses=(MassOnRotor(plane="1", mass_g=10.0, angle_deg=0.0),))
    assert fit_of(replace(GROUND, correction=balancer)) is None


def test_a_hole_that_is_none_cannot_be_blocked() -> None:
    with pytest.raises(InvalidInput):
        posed(blocked=(BlockedPosition(plane="1", position_deg=41.0),))
