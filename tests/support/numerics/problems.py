"""Selection problems that several tests share: the thesis's rotors and drum, and its field experiment."""

from __future__ import annotations

import math

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.rotor.reactions import inherent_reactions, reaction_matrix
from service.balancing.selection.objectives import components, relative_reactions
from service.balancing.selection.problem import UNLIMITED, Objective, Piece, SelectionPlane, SelectionProblem, Stock

THESIS_MASSES = (10.0, 20.0, 50.0, 100.0, 200.0, 300.0)


def rotor(case: str) -> tuple[ComplexArray, FloatArray]:
    """Reactions (2,) in N of the bare rotor, and (2, 2) N per g in its two planes."""
    if case == "drum":
        mass, rpm, e, inertia, radius = 120.0, 460.0, -0.154 + 1.20j, 0j, 330.0
        bearings, planes = np.array([-480.0, 440.0]), np.array([-330.0, 330.0])
    else:
        mass, rpm, e, radius = 60.0, 1500.0, 1.0 + 0.25j, 150.0
        inertia = -0.004 - 0.01j if case == "dynamic" else 0j
        bearings, planes = np.array([-200.0, 300.0]), np.array([-250.0, 350.0])
    speed = rpm * math.pi / 30.0
    return inherent_reactions(mass, e, inertia, bearings, speed), radius * reaction_matrix(planes, bearings, speed)


def even_positions(holes: int) -> FloatArray:
    """Radians of `holes` positions, the first one step after 0, the last one at 360 degrees."""
    return np.deg2rad(np.arange(1, holes + 1) * 360.0 / holes)


def plane(angles: FloatArray, pieces: int, capacity: int = UNLIMITED) -> SelectionPlane:
    holes = len(angles)
    return SelectionPlane(angles, np.full(holes, capacity), np.full(holes, np.inf), pieces)


def stock(masses: tuple[float, ...] = THESIS_MASSES, counts: int = UNLIMITED) -> Stock:
    return Stock(np.array(masses), np.full(len(masses), counts), np.zeros(len(masses)))


def problem(objective: Objective, pieces: int, holes: int) -> SelectionProblem:
    """As in the thesis: its masses, a position takes any number, the box holds any number."""
    return SelectionProblem(objective, (plane(even_positions(holes), pieces),) * objective.matrix.shape[1], stock())


def thesis_rotor(case: str, pieces: int) -> SelectionProblem:
    """Eq 5.14 for the static or the dynamic rotor, positions 30, 60 .. 360 degrees."""
    initial, per_gram = rotor(case)
    return problem(relative_reactions(per_gram.astype(np.complex128), initial), pieces, 12)


FIELD_TARGET = np.array([170.2 * np.exp(1j * math.radians(70.0)), 292.2 * np.exp(1j * math.radians(113.0))])


def field_experiment(pieces: int) -> SelectionProblem:
    """Eq 5.16 for the balancer's answer of the published experiment, positions 20, 40 .. 360 degrees."""
    return problem(components(FIELD_TARGET, np.array([330.0, 330.0])), pieces, 18)


def placed(problem: SelectionProblem, *planes: str) -> tuple[tuple[Piece, ...], ...]:
    """Selection written as the thesis prints it, one text per plane: "200@180 50@240"."""
    masses = problem.stock.masses_g.tolist()
    selection = []
    for where, text in zip(problem.planes, planes, strict=True):
        degrees = np.rint(np.rad2deg(where.angles)).tolist()
        pairs = [part.split("@") for part in text.split()]
        selection.append(tuple(sorted(Piece(degrees.index(float(a)), masses.index(float(m))) for m, a in pairs)))
    return tuple(selection)
