"""Problems of `drumtrue bench selection`: the thesis's cases, and boxes as rich as workshops have them.

Thesis: dynamic performance of the thresher machine, chapters 4 and 5, its printed slips corrected: a position takes any
number of masses and the box holds any number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from service.balancing.influence.fit import RunSet, fit_influence
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.rotor.reactions import inherent_reactions, reaction_matrix
from service.balancing.selection.objectives import components, relative_reactions, residual_vibration
from service.balancing.selection.problem import UNLIMITED, Objective, SelectionPlane, SelectionProblem, Stock
from service.engine.influence_fits import FittedModel
from service.engine.objective_uncertainty import objective_scatter
from service.model.plan import ObjectiveName

THESIS_MASSES = (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)
RICH_MASSES = (10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 75.0, 100.0, 120.0, 150.0, 200.0, 300.0)
FIELD_TARGET = np.array([170.2 * np.exp(1j * math.radians(70.0)), 292.2 * np.exp(1j * math.radians(113.0))])
"""The balancer's answer of the thesis's field experiment, g."""
SCATTER = 0.03
"""Scatter of a reading, as part of its amplitude, where a problem comes from readings."""
LIMIT = 0.7
"""Vibration limit, mm/s."""


@dataclass(frozen=True)
class Case:
    """A problem, the time in which it has to be answered, and what its readings cannot tell.

    aim_s: of a proof; where `uncertainty` (in the objective's unit) may end it, the line says so.
    published: there is a published budget for it.
    """

    name: str
    problem: SelectionProblem
    aim_s: float
    uncertainty: float = 0.0
    hard: bool = False
    small: bool = False
    published: bool = False


def cases() -> list[Case]:
    """All problems, smallest first."""
    found = []
    for pieces in (1, 2, 3, 4):
        aim = 0.02 if pieces < 4 else 0.08
        for name in ("static", "dynamic", "drum"):
            found.append(
                Case(f"{name}, {pieces} a plane", thesis_rotor(name, pieces), aim, small=pieces < 2, published=True)
            )
        found.append(Case(f"match, {pieces} a plane", matching(pieces), aim, small=pieces < 3))
    return found + _rich()


def _rich() -> list[Case]:
    """Boxes with counts, one mass a position, readings with scatter."""
    two, target = _influence(2, 2), FIELD_TARGET
    three, third = _influence(4, 3), np.append(FIELD_TARGET, 120.0 * np.exp(1j))
    match = components(target, np.full(2, 330.0))
    felt, felt3 = (residual_vibration(A, -A @ t, np.full(len(A), LIMIT)) for A, t in ((two, target), (three, third)))
    told = uncertainty_of(felt, "residual_vibration", two, target)
    told3 = uncertainty_of(felt3, "residual_vibration", three, third)
    box, rich = _stock(THESIS_MASSES, 8), _stock(RICH_MASSES, 3)
    return [
        Case("24 x 12 x 4 with stock, match", _posed(match, 24, 4, rich, 1), 0.25),
        Case("24 x 12 x 4 with stock, vibration", _posed(felt, 24, 4, rich, 1), 0.25),
        Case("6 a plane, 18 x 6", _posed(felt, 18, 6, box, 1), 1.5, told, hard=True),
        Case("6 a plane, 24 x 12", _posed(felt, 24, 6, rich, 1), 1.5, told, hard=True),
        Case("3 planes x 4, 18 x 6", _posed(felt3, 18, 4, box, 1), 1.5, told3, hard=True),
        Case("3 planes x 4, 24 x 12", _posed(felt3, 24, 4, rich, 1), 1.5, told3, hard=True),
    ]


def thesis_rotor(name: str, pieces: int) -> SelectionProblem:
    """Eq 5.14: the static and the dynamic rotor with 12 positions a plane, the drum with 18."""
    if name == "drum":
        mass, rpm, e, inertia, radius, holes = 120.0, 460.0, -0.154 + 1.20j, 0j, 330.0, 18
        bearings, planes = np.array([-480.0, 440.0]), np.array([-330.0, 330.0])
    else:
        mass, rpm, e, radius, holes = 60.0, 1500.0, 1.0 + 0.25j, 150.0, 12
        inertia = -0.004 - 0.01j if name == "dynamic" else 0j
        bearings, planes = np.array([-200.0, 300.0]), np.array([-250.0, 350.0])
    speed = rpm * math.pi / 30.0
    per_gram = (radius * reaction_matrix(planes, bearings, speed)).astype(np.complex128)
    initial = inherent_reactions(mass, e, inertia, bearings, speed)
    return _posed(relative_reactions(per_gram, initial), holes, pieces, _stock(THESIS_MASSES, UNLIMITED), UNLIMITED)


def matching(pieces: int) -> SelectionProblem:
    """Eq 5.16 for the field experiment: both components of what is missed, 18 positions a plane."""
    objective = components(FIELD_TARGET, np.full(2, 330.0))
    return _posed(objective, 18, pieces, _stock(THESIS_MASSES, UNLIMITED), UNLIMITED)


def uncertainty_of(objective: Objective, name: ObjectiveName, influence: ComplexArray, target: ComplexArray) -> float:
    """What a plan takes as uncertainty where as found and a trial run a plane are read with `SCATTER`."""
    masses = np.concatenate([np.zeros((1, len(target))), 200.0 * np.eye(len(target))]).astype(np.complex128)
    vibration = (masses - target) @ influence.T
    runs = RunSet(masses, vibration, SCATTER * np.abs(vibration))
    return objective_scatter(objective, name, FittedModel((), fit_influence(runs), runs), target)


def _influence(sensors: int, planes: int) -> ComplexArray:
    """Some influence coefficients, mm/s per g."""
    rng = np.random.default_rng(1)
    drawn = rng.normal(size=(sensors, planes)) + 1j * rng.normal(size=(sensors, planes))
    return np.asarray(0.01 * drawn, dtype=np.complex128)


def _posed(objective: Objective, holes: int, pieces: int, stock: Stock, capacity: int) -> SelectionProblem:
    plane = SelectionPlane(_even(holes), np.full(holes, capacity), np.full(holes, np.inf), pieces)
    return SelectionProblem(objective, (plane,) * objective.matrix.shape[1], stock)


def _even(holes: int) -> FloatArray:
    """Positions from one step after the mark to 360 degrees, radians."""
    return np.asarray(np.deg2rad(np.arange(1, holes + 1) * 360.0 / holes), dtype=np.float64)


def _stock(masses: tuple[float, ...], count: int) -> Stock:
    return Stock(np.array(masses), np.full(len(masses), count), np.zeros(len(masses)))
