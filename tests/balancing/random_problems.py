"""Small random selection problems with every kind of limit, small enough to try them all."""

from __future__ import annotations

import math

import numpy as np

from service.balancing.exhaustive import count_combinations
from service.balancing.objectives import bearing_force, components, residual_vibration
from service.balancing.phasors import ComplexArray
from service.balancing.selection import UNLIMITED, Objective, SelectionPlane, SelectionProblem, Stock

KINDS = ("components", "bearing_force", "sum", "max", "rms")
MOST_TRIED = 40_000


def random_problem(kind: str, seed: int) -> SelectionProblem:
    """One to three planes, uneven and blocked holes, limits in pieces and in grams, a small shared box."""
    rng = np.random.default_rng(seed)
    while True:
        planes = 2 if kind == "bearing_force" else int(rng.integers(1, 4))
        problem = SelectionProblem(
            _objective(kind, rng, planes), tuple(_plane(rng) for _ in range(planes)), _stock(rng)
        )
        if count_combinations(problem) <= MOST_TRIED:
            return problem


def _complex(rng: np.random.Generator, *shape: int) -> ComplexArray:
    return np.asarray(rng.normal(size=shape) + 1j * rng.normal(size=shape), dtype=np.complex128)


def _objective(kind: str, rng: np.random.Generator, planes: int) -> Objective:
    target = _complex(rng, planes) * rng.choice([30.0, 100.0, 400.0])
    radius = rng.choice([200.0, 330.0], planes)
    if kind == "components":
        return components(target, radius)
    if kind == "bearing_force":
        return bearing_force(target, radius, np.array([-300.0, 350.0]), np.array([-450.0, 500.0]), 48.0)
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
