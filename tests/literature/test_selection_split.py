"""Published splits of a continuous correction into stock masses.

Field experiment: thesis on the dynamic performance of the thresher machine, chapter 5, balancer's answer 170.2 g at 70
and 292.2 g at 113 degrees, radius 330 mm; optima recomputed by enumeration, to the digits shown.
Huang 2009: plane BZ-A as given in hsbalance's notebook `hsbalance_Playground-splitting.ipynb` (GitHub,
MagedMohamedTurk/Turbomachinery-Rotors-Balancing), tolerance of its printed error 0.0005 g.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from service.balancing.selection.brute_force import solve_exhaustive
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import vectors_of
from service.balancing.selection.problem import Objective, Piece, SelectionPlane, SelectionProblem, Stock
from tests.support.numerics.problems import field_experiment

RADIUS_MM = 330.0


def one_plane_at_a_time(pieces: int) -> list[SelectionProblem]:
    """With an unlimited box, objective B is a sum over planes: each is a small problem of its own."""
    whole = field_experiment(pieces)
    return [
        SelectionProblem(
            Objective(
                whole.objective.matrix[p : p + 1, p : p + 1],
                whole.objective.offset[p : p + 1],
                whole.objective.weights[p : p + 1],
                "components",
            ),
            (whole.planes[p],),
            whole.stock,
        )
        for p in range(2)
    ]


@pytest.mark.parametrize(("pieces", "optimum_g"), [(1, 50.02), (2, 4.880), (3, 1.965)])
def test_optima_of_the_field_experiment(pieces: int, optimum_g: float) -> None:
    results = [solve_exhaustive(problem) for problem in one_plane_at_a_time(pieces)]
    assert sum(r.value for r in results) / RADIUS_MM == pytest.approx(optimum_g, abs=0.005)
    whole = field_experiment(pieces)
    u = vectors_of(whole, [r.pieces[0] for r in results if r.pieces])
    assert float(evaluate(whole.objective, u)) == pytest.approx(sum(r.value for r in results), rel=1e-12)


def huang2009() -> SelectionProblem:
    target = complex(178.48435221, 614.4911797)
    angles = np.deg2rad(np.arange(30.0, 143.0, 7.5))
    plane = SelectionPlane(angles, np.ones(16, dtype=np.int64), np.full(16, np.inf), 16, 2000.0)
    stock = Stock(np.array([142.0]), np.array([16]), np.zeros(1))
    return SelectionProblem(
        Objective(np.eye(1, dtype=np.complex128), np.array([-target]), np.ones(1), "sum"), (plane,), stock
    )


def test_huang2009_published_split() -> None:
    problem = huang2009()
    degrees = np.rad2deg(problem.planes[0].angles).round(1).tolist()
    published = [tuple(Piece(degrees.index(a), 0) for a in (37.5, 52.5, 75.0, 97.5, 105.0))]
    u = vectors_of(problem, published)
    assert float(evaluate(problem.objective, u)) == pytest.approx(2.10034846, abs=0.0005)
    assert abs(u[0]) == pytest.approx(640.2, abs=0.05)
    assert math.degrees(np.angle(u[0])) == pytest.approx(73.6, abs=0.05)


def test_the_exact_search_proves_both() -> None:
    for pieces, optimum_g in ((1, 50.02), (2, 4.880), (3, 1.965)):
        found = solve_exact(field_experiment(pieces))
        assert found.status == "optimal"
        assert found.value / RADIUS_MM == pytest.approx(optimum_g, abs=0.005)
    split = solve_exact(huang2009())
    assert split.status == "optimal"
    assert split.value == pytest.approx(2.10034846, abs=0.0005)
