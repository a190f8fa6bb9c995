"""The three objectives against their formulas, written out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.rotor.phasors import ComplexArray
from service.balancing.rotor.reactions import bearing_reactions
from service.balancing.selection.objectives import bearing_force, components, evaluate, residual_vibration
from service.errors import NumericsError

finite = st.floats(-500.0, 500.0)
pair = st.tuples(st.builds(complex, finite, finite), st.builds(complex, finite, finite)).map(np.array)


@given(target=pair, u=pair)
def test_components_is_half_the_sum_of_both_components_missed(target: ComplexArray, u: ComplexArray) -> None:
    radius = np.array([330.0, 250.0])
    missed = radius * (u - target)
    expected = 0.5 * float(np.abs(missed.real).sum() + np.abs(missed.imag).sum())
    assert float(evaluate(components(target, radius), u)) == pytest.approx(expected, abs=1e-6)


@given(u=pair)
def test_residual_norms(u: ComplexArray) -> None:
    influence = np.array([[0.01 + 0.02j, 0.005], [0.001j, 0.02], [0.004, -0.01j]])
    present, limits = np.array([3.0, 2.0j, -1.0]), np.array([1.0, 2.0, 4.0])
    parts = np.abs(present + influence @ u) / limits
    for norm, expected in (("sum", parts.sum()), ("max", parts.max()), ("rms", np.sqrt((parts**2).mean()))):
        value = evaluate(residual_vibration(influence, present, limits, norm), u)  # type: ignore[arg-type]
        assert float(value) == pytest.approx(float(expected), rel=1e-12)


def test_many_selections_at_once_equal_one_by_one() -> None:
    rng = np.random.default_rng(5)
    u = rng.normal(size=(4, 7, 2)) + 1j * rng.normal(size=(4, 7, 2))
    objective = components(np.array([1.0, 2.0j]), np.array([100.0, 200.0]))
    together = evaluate(objective, u)
    assert together.shape == (4, 7)
    assert together[2, 3] == pytest.approx(float(evaluate(objective, u[2, 3])), rel=1e-14)


def test_a_negligible_reaction_is_divided_by_the_larger_one() -> None:
    axial, bearings = np.array([-400.0, 400.0]), np.array([-400.0, 400.0])
    objective = bearing_force(np.array([100.0, 0j]), np.array([330.0, 330.0]), axial, bearings, 50.0)
    assert objective.weights == pytest.approx(np.full(2, 0.5 / 82.5), rel=1e-12)
    assert float(evaluate(objective, np.array([100.0, 10.0]))) == pytest.approx(0.05, rel=1e-12)


def test_no_correction_at_all_has_no_reaction_to_reduce() -> None:
    with pytest.raises(
        NumericsError, match="the continuous correction must not be zero: no reaction is left to reduce"
    ):
        bearing_force(np.zeros(2, complex), np.ones(2), np.array([-1.0, 1.0]), np.array([-2.0, 2.0]), 50.0)


def test_builders_refuse_wrong_shapes_and_values() -> None:
    with pytest.raises(
        NumericsError, match=r"radius_mm must have one value per entry of target_g, got the shapes \(3,\) and \(2,\)"
    ):
        components(np.zeros(2, complex), np.ones(3))
    with pytest.raises(NumericsError, match="every value of radius_mm must be a finite number above 0, got 0"):
        components(np.zeros(2, complex), np.array([1.0, 0.0]))
    with pytest.raises(
        NumericsError, match="influence must have one row for each of 2 sensors and one column per plane, got the"
    ):
        residual_vibration(np.zeros((3, 2), complex), np.zeros(2, complex), np.ones(2))
    with pytest.raises(NumericsError, match="every value of limits must be a finite number above 0, got -1"):
        residual_vibration(np.zeros((2, 2), complex), np.zeros(2, complex), np.array([1.0, -1.0]))


def test_reactions_carry_the_unbalance_in_force_and_moment() -> None:
    unbalance, axial = np.array([3e4 + 1e4j, -2e4j]), np.array([-250.0, 350.0])
    bearings, speed = np.array([-200.0, 300.0]), 48.0
    forces = bearing_reactions(unbalance, axial, bearings, speed)
    assert forces.sum() == pytest.approx(speed**2 * 1e-6 * unbalance.sum())
    assert (forces * bearings).sum() == pytest.approx(speed**2 * 1e-6 * (unbalance * axial).sum())


def test_reactions_refuse_what_they_cannot_use() -> None:
    two = np.array([-200.0, 300.0])
    for unbalance, axial, bearings, speed, message in [
        (
            np.zeros(1, complex),
            two,
            two,
            10.0,
            r"unbalance must have one value for each of 2 axial positions, got the shape \(1,\)",
        ),
        (
            np.zeros(2, complex),
            two[:, None],
            two,
            10.0,
            r"axial_mm must have one position per unbalance, got the shape \(2, 1\)",
        ),
        (np.zeros(2, complex), two, np.zeros(3), 10.0, "exactly two bearings"),
        (
            np.zeros(2, complex),
            two,
            np.ones(2),
            10.0,
            "the bearings must have different axial positions, got 1 mm twice",
        ),
        (np.zeros(2, complex), two * np.nan, two, 10.0, "axial positions must be finite numbers of mm"),
        (np.zeros(2, complex), two, two, 0.0, "speed_rad_s must be above 0, got 0"),
    ]:
        with pytest.raises(NumericsError, match=message):
            bearing_reactions(unbalance, axial, bearings, speed)
