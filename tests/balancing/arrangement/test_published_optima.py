"""The nine published problems: their optima by full enumeration, proved; the chopper's front up to four moves."""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

import numpy as np
import pytest

from service.balancing.arrangement import (
    EMPTY,
    ArrangementProblem,
    end_gains,
    part_effects,
    plane_shares,
    search_best,
    search_front,
    solve_best,
)
from service.balancing.selection.problem import Norm, Objective

CASES = json.loads(resources.files("service.bench.arrangement").joinpath("cases.json").read_text())["cases"]
OPTIMA = [(case, norm) for case in CASES for norm in case.get("optimum", {})]
STATED = 1e-6
"""Relative tolerance that the optima are stated for."""


def problem_of(case: dict[str, Any], norm: Norm) -> ArrangementProblem:
    """One case in arrays."""
    places, parts = case["places"], case["parts"]
    axial = np.array([[place["axial_mm"][0], place["axial_mm"][-1]] for place in places])
    shares = plane_shares(axial, np.array(case["planes_axial_mm"], dtype=np.float64))
    gains = end_gains(
        np.array([place["radius_mm"] for place in places]),
        np.radians([place["angle_deg"] for place in places]),
        axial,
        shares,
    )
    ends = np.array([part["mass_g"] if isinstance(part["mass_g"], list) else [part["mass_g"], 0.0] for part in parts])
    labels = [place["label"] for place in places]
    present = np.full(len(places), EMPTY, dtype=np.int64)
    for k, part in enumerate(parts):
        if "present" in part:
            present[labels.index(part["present"])] = k
    return ArrangementProblem(
        objective=Objective(
            np.eye(2, dtype=np.complex128), np.array([complex(*o) for o in case["offset_g_mm"]]), np.ones(2), norm
        ),
        effects=part_effects(np.repeat(ends[:, None, :], len(places), axis=1), gains),
        allowed=np.array([[part.get("kind") == place.get("kind") for place in places] for part in parts]),
        may_be_empty=np.zeros(len(places), dtype=np.bool_),
        present=present,
        new=np.zeros(len(parts), dtype=np.bool_),
        masses_g=ends.sum(axis=1),
    )


@pytest.mark.parametrize(("case", "norm"), OPTIMA, ids=[f"{case['name']}, {norm}" for case, norm in OPTIMA])
def test_the_published_optimum_is_found_and_proved(case: dict[str, Any], norm: Norm) -> None:
    result = solve_best(problem_of(case, norm), seed=1)
    assert result.status == "optimal"
    assert result.value == pytest.approx(case["optimum"][norm], rel=STATED)
    assert result.lower_bound == result.value


def test_the_choppers_front_is_exact_up_to_four_moves() -> None:
    case = next(case for case in CASES if "front_max" in case)
    problem = problem_of(case, "max").with_max_moves(4)
    front = list(search_front(problem, np.random.default_rng(1)))[-1]
    assert {str(moved): state.value for moved, state in front.items()} == pytest.approx(case["front_max"], rel=STATED)
    assert all(state.proved for state in front.values())


def test_a_proof_of_few_moves_among_many_parts_ends() -> None:
    case = next(case for case in CASES if "front_max" in case)
    last = list(search_best(problem_of(case, "max").with_max_moves(3), np.random.default_rng(1)))[-1]
    assert last.proved
    assert last.value == pytest.approx(case["front_max"]["3"], rel=STATED)
