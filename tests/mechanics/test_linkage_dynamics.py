"""Kinematics, reactions and the quadratic forms against an independent formulation, on random linkages."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from service.mechanics.chain import GROUND, Linkage
from service.mechanics.dynamics import features, mass_numbers
from service.mechanics.kinematics import motion, whole_turn
from service.mechanics.reactions import reactions
from tests.mechanics.random_linkages import linkages
from tests.mechanics.spectral import answer

SAMPLES = 1024
SPEED = 7.0


def near(one: np.ndarray, other: np.ndarray, tolerance: float) -> None:
    """Equal to a part of the largest value."""
    peak = max(float(np.abs(other).max()), 1e-12)
    assert float(np.abs(one - other).max()) <= tolerance * peak


@given(linkages())
@settings(max_examples=40)
def test_engine_agrees_with_derivatives_of_positions(linkage: Linkage) -> None:
    moving = motion(linkage, whole_turn(SAMPLES), SPEED)
    found, p, judge = features(linkage, moving), mass_numbers(linkage), answer(linkage, SPEED, SAMPLES)
    for name, place in judge.joints.items():
        near(moving.points[name], place, 1e-11)
    near(found.shaking_force(p), judge.force, 1e-9)
    near(found.shaking_moment(p), judge.moment, 1e-9)
    near(found.driving_torque(p), judge.torque, 1e-9)


@given(linkages())
@settings(max_examples=25)
def test_reactions_balance_every_link_and_the_frame(linkage: Linkage) -> None:
    moving = motion(linkage, whole_turn(64), SPEED)
    found, p = features(linkage, moving), mass_numbers(linkage)
    at = reactions(linkage, moving, p)
    near(at.frame, found.shaking_force(p), 1e-11)
    near(at.frame_moment, found.shaking_moment(p), 1e-11)
    near(at.torque, found.driving_torque(p), 1e-11)
    largest = max(float(np.abs(one.force).max()) for one in at.joints)
    for k, link in enumerate(linkage.links):
        centre = moving.origin[k] + moving.axis[k] * link.body.centre
        swing = 1j * moving.alpha[k] - moving.omega[k] ** 2
        acceleration = moving.acceleration[k] + swing * moving.axis[k] * link.body.centre + 1j * linkage.gravity
        force = -link.body.mass * acceleration
        moment = -link.body.central_inertia * moving.alpha[k]
        if link.name == linkage.crank:
            moment = moment + at.torque
        for one in at.joints:
            sign = (one.on == link.name) - (one.by == link.name)
            force = force + sign * one.force
            moment = moment + sign * np.imag(np.conj(moving.points[one.joint] - centre) * one.force)
        assert np.abs(force).max() < 1e-9 * largest
        assert np.abs(moment).max() < 1e-9 * largest * 10.0


@given(linkages(), st.integers(1, 3))
@settings(max_examples=25)
def test_mean_squares_are_quadratic_forms(linkage: Linkage, factor: int) -> None:
    found, p = features(linkage, motion(linkage, whole_turn(48), SPEED)), mass_numbers(linkage)
    many = np.stack([p, factor * p])
    mean = np.mean(np.abs(found.shaking_force(p)) ** 2)
    np.testing.assert_allclose(found.mean_square("force", many), [mean, factor**2 * mean], rtol=1e-10)
    np.testing.assert_allclose(found.mean_square("moment", p), np.mean(found.shaking_moment(p) ** 2), rtol=1e-9)
    np.testing.assert_allclose(found.mean_square("torque", p), np.mean(found.driving_torque(p) ** 2), rtol=1e-9)


@given(linkages())
@settings(max_examples=25)
def test_over_a_turn_nothing_is_left_without_gravity(linkage: Linkage) -> None:
    still = Linkage(linkage.ground, linkage.crank, linkage.links, linkage.dyads, linkage.moment_point)
    found, p = features(still, motion(still, whole_turn(SAMPLES), SPEED)), mass_numbers(still)
    for one in (found.shaking_force(p), found.shaking_moment(p), found.driving_torque(p)):
        assert abs(one.mean()) < 1e-10 * np.abs(one).max()


@given(linkages())
@settings(max_examples=15)
def test_forces_are_named_from_ground_to_the_last_link(linkage: Linkage) -> None:
    at = reactions(linkage, motion(linkage, whole_turn(24), SPEED), mass_numbers(linkage))
    assert len(at.joints) == 1 + 3 * len(linkage.dyads)
    assert at.joints[0].by == GROUND
