"""Masses that stay may break a limit by themselves: then there is no plan, and the reason names which."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from service.engine.kept_masses import broken_limits
from service.engine.logs.replay import last_problem
from service.engine.selection_problem import PlanContext, pose
from service.messages import render
from service.model.machine import Plane
from service.model.plan import BlockedPosition, Placement, PlanRequest
from tests.support.numerics.drum_log import session

POSED = last_problem(session())[1]
assert POSED is not None
GROUND = POSED.ground


def piece(position: float, mass_g: float = 50.0) -> Placement:
    return Placement(plane="1", position_deg=position, hole=str(round(position / 20.0) + 1), mass_g=mass_g)


def reason(*kept: Placement, blocked: tuple[float, ...] = (), base: str = "present", **plane: Any) -> str | None:
    planes = tuple(replace(one, **plane) for one in GROUND.machine.planes)
    changed: PlanContext = replace(
        GROUND, machine=replace(GROUND.machine, planes=planes), inputs=replace(GROUND.inputs, present=kept)
    )
    request = PlanRequest(
        correction_id=GROUND.correction.id,
        objective="components",
        base=base,  # type: ignore[arg-type]
        blocked=tuple(BlockedPosition(plane="1", position_deg=at) for at in blocked),
    )
    found = broken_limits(pose(changed, request))
    return None if found is None or found.reason is None else render(found.reason)


def test_pieces_that_keep_all_limits_stay() -> None:
    assert reason(piece(0.0), piece(20.0), piece(40.0)) is None
    assert isinstance(GROUND.machine.planes[0], Plane)


@pytest.mark.parametrize(
    ("kept", "limits", "words"),
    [
        ((0.0, 20.0, 40.0, 60.0), {}, 'plane "1" must carry at most 3 masses, it has 4'),
        ((0.0, 20.0), {"max_total_mass_g": 99.0}, "at most 99 g, it has 100 g"),
        ((0.0, 0.0), {}, 'hole "1" of plane "1" must carry at most 1'),
        ((0.0,), {"max_force_n": 30.0}, "at most 30 N, it is with 38 N"),
    ],
)
def test_each_limit_is_named(kept: tuple[float, ...], limits: dict[str, float], words: str) -> None:
    told = reason(*map(piece, kept), **limits)  # type: ignore[arg-type]
    assert told is not None
    assert words in told


def test_a_limit_that_is_just_met_is_kept() -> None:
    assert reason(piece(0.0), piece(20.0), max_total_mass_g=100.0) is None
    assert reason(piece(0.0), piece(0.0), masses_per_position=2) is None


def test_a_blocked_hole_must_not_carry_one_that_stays() -> None:
    told = reason(piece(40.0), blocked=(40.0,))
    assert told is not None
    assert 'hole "3" of plane "1" is blocked' in told


def test_only_a_plan_that_leaves_them_on_asks() -> None:
    assert reason(piece(0.0), piece(0.0), base="as_found") is None
