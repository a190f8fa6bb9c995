"""Small random selection problems with every kind of limit, small enough to try them all."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from service.balancing.rotor.phasors import ComplexArray
from service.balancing.selection.brute_force import count_combinations
from service.balancing.selection.mounted_pieces import MountedPiece, with_fitted
from service.balancing.selection.objectives import bearing_force, components, residual_vibration
from service.balancing.selection.problem import UNLIMITED, Objective, SelectionPlane, SelectionProblem, Stock

KINDS = ("components", "bearing_force", "sum", "max", "rms")
MAX_TRIED = 40_000


def random_problem(kind: str, seed: int) -> SelectionProblem:
    """One to three planes, uneven and blocked holes, limits in pieces and in grams, a small shared box."""
    rng = np.random.default_rng(seed)
    while True:
        planes = int(rng.integers(1, 4))
        problem = SelectionProblem(
            _objective(kind, rng, planes), tuple(_plane(rng) for _ in range(planes)), _stock(rng)
        )
        if count_combinations(problem) <= MAX_TRIED:
            return problem


def fitted_problem(kind: str, seed: int) -> SelectionProblem:
    """A random problem with pieces on the rotor that stay, move or come off."""
    rng = np.random.default_rng([seed, 1])
    while True:
        bare = random_problem(kind, int(rng.integers(2**31)))
        first = bare.planes[0].angles
        pieces = [
            MountedPiece(0, float(first[hole]), float(rng.choice([10.0, 25.0, 50.0])), may)
            for hole, may in enumerate(rng.permutation(["stay", "move", "remove"])[: int(rng.integers(1, 3))])
        ]
        whole = with_fitted(bare, pieces, in_offset=bool(rng.integers(2)), tolerance=0.01).problem
        if count_combinations(whole) <= MAX_TRIED:
            return whole


AWKWARD = ("dependent", "dead", "settled", "tiny target", "tiny pieces", "one heavy sensor", "far out of reach")


def awkward_problem(kind: str, seed: int) -> SelectionProblem:
    """A random problem made hard on the numerics: planes that act alike, dead sensors, nothing to correct, extremes."""
    rng = np.random.default_rng([seed, 2])
    how = AWKWARD[seed % len(AWKWARD)]
    bare = random_problem(kind, int(rng.integers(2**31)))
    objective, stock = bare.objective, bare.stock
    if how == "dependent":
        objective = replace(objective, matrix=np.repeat(objective.matrix[:, :1], len(bare.planes), axis=1))
    elif how == "dead":
        objective = replace(objective, matrix=objective.matrix * (rng.random(objective.matrix.shape) < 0.4))
    elif how == "settled":
        objective = replace(objective, offset=np.zeros_like(objective.offset))
    elif how == "tiny target":
        objective = replace(objective, offset=objective.offset * 10.0 ** float(rng.integers(-300, -20)))
    elif how == "tiny pieces":
        stock = replace(stock, masses_g=1e-9 * stock.masses_g, fasteners_g=1e-9 * stock.fasteners_g)
    elif how == "one heavy sensor":
        objective = replace(objective, weights=objective.weights * 10.0 ** rng.integers(-9, 9, len(objective.weights)))
    else:
        objective = replace(objective, offset=1e6 * objective.offset)
    made = replace(bare, objective=objective, stock=stock)
    return made if count_combinations(made) <= MAX_TRIED else awkward_problem(kind, seed + 1000 * len(AWKWARD))


def _complex(rng: np.random.Generator, *shape: int) -> ComplexArray:
    return np.asarray(rng.normal(size=shape) + 1j * rng.normal(size=shape), dtype=np.complex128)


def _objective(kind: str, rng: np.random.Generator, planes: int) -> Objective:
    target = _complex(rng, planes) * rng.choice([30.0, 100.0, 400.0])
    radius = rng.choice([200.0, 330.0], planes)
    if kind == "components":
        return components(target, radius)
    if kind == "bearing_force":
        return bearing_force(target, radius, np.array([-300.0, 350.0, 20.0])[:planes], np.array([-450.0, 500.0]), 48.0)
    sensors = int(rng.integers(1, 5))
    influence = 0.01 * _complex(rng, sensors, planes)
    present = -influence @ target + rng.choice([0.0, 0.5]) * _complex(rng, sensors)
    limits = rng.choice([1.0, 2.5], sensors)
    return residual_vibration(influence, present, limits, "sum" if kind == "sum" else "max" if kind == "max" else "rms")


def _plane(rng: np.random.Generator) -> SelectionPlane:
    holes = int(rng.integers(2, 7))
    even = 2.0 * math.pi * np.arange(holes) / holes
    angles = even if rng.random() < 0.5 else even + rng.uniform(0.0, 3.0 / holes, holes)
    return SelectionPlane(
        angles=angles,
        capacity=rng.choice([0, 1, 1, 2, UNLIMITED], holes),
        capacity_g=rng.choice([60.0, 150.0, math.inf], holes),
        max_pieces=int(rng.choice([0, 1, 2, 2, 3, UNLIMITED])),
        max_mass_g=float(rng.choice([100.0, 250.0, math.inf])),
        fixed=complex(*rng.choice([0.0, 25.0], 2)),
    )


def _stock(rng: np.random.Generator) -> Stock:
    items = int(rng.integers(1, 4))
    masses = rng.choice([10.0, 20.0, 30.0, 50.0, 72.5, 100.0, 200.0], items, replace=False)
    return Stock(masses, rng.choice([1, 2, 3], items), rng.choice([0.0, 4.5], items))
