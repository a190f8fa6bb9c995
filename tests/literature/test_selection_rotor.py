"""Rigid rotor and published best designs.

Source: thesis on the dynamic performance of the thresher machine, chapter 5 (two-plane discrete balancing); its data
with the printed slips corrected, forces recomputed: reactions within 0.05 N, designs to the digits shown.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from service.balancing.rotor.reactions import bearing_reactions, inherent_reactions
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.objectives import bearing_force, evaluate
from service.balancing.selection.placements import vectors_of
from tests.support.numerics.problems import placed, rotor, thesis_rotor

DESIGNS = [
    ("static", 1, "200@180", "200@180", 266.89, 209.37),
    ("static", 2, "200@180 50@240", "200@180 50@300", 72.04, 38.98),
    ("static", 3, "200@180 50@240 20@240", "200@180 20@240 50@330", 11.32, 1.879),
    ("static", 4, "10@210 200@180 10@270 50@240", "50@330 10@240 10@240 200@180", 1.371, 2.674),
    ("dynamic", 1, "200@150", "300@210", 208.01, 204.15),
    ("dynamic", 2, "100@180 100@150", "300@210 50@360", 15.17, 13.12),
    ("dynamic", 3, "200@150 50@240 10@330", "20@120 200@300 300@180", 4.474, 13.14),
    ("dynamic", 4, "20@360 10@270 100@300 300@150", "10@150 300@210 50@360 10@300", 4.043, 10.01),
]


@pytest.mark.parametrize(
    ("case", "expected"), [("static", (915.60, 610.40)), ("dynamic", (742.27, 1017.34)), ("drum", (161.12, 175.77))]
)
def test_reactions_of_the_bare_rotor(case: str, expected: tuple[float, float]) -> None:
    initial, _ = rotor(case)
    assert np.abs(initial) == pytest.approx(expected, abs=0.05)


def test_drum_residuals_follow_from_planes_symmetric_about_the_mass_centre() -> None:
    initial, per_gram = rotor("drum")
    added = 200.0 * np.exp(1j * math.radians(280.0))
    assert np.abs(initial + per_gram @ np.array([added, added])) == pytest.approx((16.31, 17.79), abs=0.05)


def test_drum_with_its_printed_plane_gives_other_residuals() -> None:
    bearings, speed = np.array([-480.0, 440.0]), 460.0 * math.pi / 30.0
    initial = inherent_reactions(120.0, -0.154 + 1.20j, 0j, bearings, speed)
    added = np.full(2, 330.0 * 200.0 * np.exp(1j * math.radians(280.0)))
    forces = initial + bearing_reactions(added, np.array([-350.0, 330.0]), bearings, speed)
    assert np.abs(forces) == pytest.approx((13.44, 20.80), abs=0.05)


@pytest.mark.parametrize(("case", "pieces", "first", "second", "force_p", "force_q"), DESIGNS)
def test_published_designs(case: str, pieces: int, first: str, second: str, force_p: float, force_q: float) -> None:
    problem = thesis_rotor(case, pieces)
    u = vectors_of(problem, placed(problem, first, second))
    initial, per_gram = rotor(case)
    assert np.abs(initial + per_gram @ u) == pytest.approx((force_p, force_q), rel=5e-4, abs=5e-3)
    expected = 0.5 * force_p / abs(initial[0]) + 0.5 * force_q / abs(initial[1])
    assert float(evaluate(problem.objective, u)) == pytest.approx(expected, rel=5e-4)


def test_bearing_force_states_the_rotor_table_from_an_equivalent_correction() -> None:
    """The initial unbalance is minus the continuous correction; posed from the drum's own unbalance it is the table."""
    initial, per_gram = rotor("drum")
    target = np.linalg.solve(per_gram, -initial).astype(np.complex128)
    objective = bearing_force(
        target, np.array([330.0, 330.0]), np.array([-330.0, 330.0]), np.array([-480.0, 440.0]), 460.0 * math.pi / 30.0
    )
    assert np.abs(objective.offset) == pytest.approx((161.12, 175.77), abs=0.05)
    assert float(evaluate(objective, np.zeros(2, np.complex128))) == pytest.approx(1.0)
    assert float(evaluate(objective, target)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("case", "pieces", "first", "second"), [d[:4] for d in DESIGNS])
def test_no_published_design_beats_the_proved_optimum(case: str, pieces: int, first: str, second: str) -> None:
    problem = thesis_rotor(case, pieces)
    published = float(evaluate(problem.objective, vectors_of(problem, placed(problem, first, second))))
    found = solve_exact(problem)
    assert found.status == "optimal"
    assert found.gap == pytest.approx(0.0, abs=1e-12)
    assert found.value <= published * (1.0 + 1e-9)
    if (case, pieces) in (("static", 3), ("dynamic", 4)):
        assert found.value < published * 0.999, "a strictly better design is known"
