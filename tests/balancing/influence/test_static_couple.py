"""Static and couple parts, and fits in modes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.balancing.influence.corrections import least_squares
from service.balancing.influence.fit import fit_influence
from service.balancing.influence.static_couple import decompose, decoupled, in_modes, static_couple_modes
from service.errors import NumericsError
from tests.support.numerics.runs import measured, normal

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_parts_add_up_and_keep_to_themselves(seed: int) -> None:
    rng = np.random.default_rng(seed)
    radius, axial = rng.uniform(100.0, 400.0, 2), np.array([-1.0, 1.0]) * rng.uniform(50.0, 500.0, 2)
    masses = normal(rng, 2)
    found = decompose(masses, radius, axial)
    np.testing.assert_allclose(found.static + found.couple, masses)
    assert abs((found.static * radius * axial).sum()) < 1e-7
    assert abs((found.couple * radius).sum()) < 1e-9
    assert (found.static * radius).sum() == pytest.approx(found.unbalance)
    assert (found.couple * radius * axial).sum() == pytest.approx(found.moment)


@given(seeds)
def test_modes_answer_as_planes_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    modes = static_couple_modes(np.array([330.0, 300.0]), np.array([-300.0, 350.0]))
    pairs = np.array([[0, 0], [8.0, 0], [0, 6j]], dtype=np.complex128)
    runs = measured(normal(rng, 3, 2), normal(rng, 3), np.asarray(pairs @ modes.T, dtype=np.complex128))
    through_modes = modes @ least_squares(fit_influence(in_modes(runs, modes, ("static", "couple")))).masses
    np.testing.assert_allclose(through_modes, least_squares(fit_influence(runs)).masses, atol=1e-6)


def test_a_static_pair_alone_corrects_the_static_part_with_one_trial() -> None:
    modes = static_couple_modes(np.array([330.0, 330.0]), np.array([-330.0, 330.0]))
    A, v0 = np.array([[0.03, 0.01j], [0.01j, 0.03]]), np.array([2.0, 2.0 + 0j])
    runs = measured(A, v0, np.array([[0, 0], [50.0, 50.0]], dtype=complex))
    static = modes[:, :1]
    found = least_squares(fit_influence(in_modes(runs, static, ("static",))))
    np.testing.assert_allclose(A @ (static @ found.masses), -v0)


def test_the_classic_method_is_exact_where_both_ends_are_alike() -> None:
    modes = static_couple_modes(np.array([330.0, 330.0]), np.array([-330.0, 330.0]))
    A, v0 = np.array([[0.03, 0.01j], [0.01j, 0.03]]), np.array([2.0, -1.0j])
    np.testing.assert_allclose(decoupled(A, v0, modes), np.linalg.solve(A, -v0))
    unlike = A + np.array([[0.01, 0.0], [0.0, 0.0]])
    assert np.abs(v0 + unlike @ decoupled(unlike, v0, modes)).max() > 0.1


def test_masses_that_are_no_pair_are_refused() -> None:
    modes = static_couple_modes(np.array([330.0, 330.0]), np.array([-330.0, 330.0]))
    runs = measured(np.eye(2, dtype=complex), np.ones(2, complex), np.array([[0, 0], [50.0, 20.0]], dtype=complex))
    with pytest.raises(NumericsError, match="the masses of run 2 must be made of the 1 modes asked for"):
        in_modes(runs, modes[:, :1])


@pytest.mark.parametrize("axial", [[100.0, 300.0], [0.0, 300.0], [-100.0, -300.0]])
def test_planes_on_one_side_have_no_static_pair(axial: list[float]) -> None:
    with pytest.raises(NumericsError, match="mass centre between them"):
        static_couple_modes(np.array([330.0, 330.0]), np.array(axial))
