"""A selection problem as a mixed-integer linear one, for solvers that know nothing else.

How many pieces of each item go into each position are whole numbers n; joint planes, stock, capacity and limits are
rows G n <= h. `components` is linear. The modulus of `sum` and `max` is not: it is replaced by its greatest component
in `SIDES` directions, so that the linear optimum is a lower bound, at most `POLYGON_GAP` of it too low. `rms` is
quadratic and cannot be stated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.placements import Selection, effective_g
from service.balancing.selection.problem import Piece, SelectionProblem

SIDES = 32
"""Directions that stand for a circle."""
POLYGON_GAP = 1.0 - math.cos(math.pi / SIDES)


@dataclass(frozen=True)
class Linear:
    """Minimise sum(t) over n, t with C n + d <= t[of], G n <= h, 0 <= n <= most.

    plane, position, item, most: (K,) of each n. C: (R, K), d: (R,), of: (R,) index of t. G: (L, K), h: (L,).
    vector: (K,) complex g, of one piece.
    """

    plane: IntArray
    position: IntArray
    item: IntArray
    most: IntArray
    C: FloatArray
    d: FloatArray
    of: IntArray
    G: FloatArray
    h: FloatArray
    vector: ComplexArray

    def selection(self, counts: IntArray, planes: int) -> Selection:
        """Pieces that n = `counts` stand for."""
        return tuple(
            tuple(
                sorted(
                    Piece(int(self.position[k]), int(self.item[k]))
                    for k in np.flatnonzero((self.plane == p) & (counts > 0))
                    for _ in range(int(counts[k]))
                )
            )
            for p in range(planes)
        )


def cannot_state(problem: SelectionProblem) -> str | None:
    """Why a problem has no such form; None where it has."""
    return "rms is quadratic" if problem.objective.norm == "rms" else None


def linear(problem: SelectionProblem) -> Linear:
    """State a problem with norm components, sum or max."""
    bare = linear_without_costs(problem)
    C, d, of = _cost(problem, bare.plane, bare.vector)
    return replace(bare, C=C, d=d, of=of)


def linear_without_costs(problem: SelectionProblem) -> Linear:
    """State the whole numbers and limits of a problem; C, d and of are empty."""
    places = [
        (p, h, i)
        for p, plane in enumerate(problem.planes)
        for h in range(len(plane.angles))
        for i in range(len(problem.stock.masses_g))
        if plane.allowed is None or plane.allowed[h, i]
    ]
    plane, position, item = np.array(places, dtype=np.int64).reshape(-1, 3).T
    mass = effective_g(problem.stock)[item]
    angles = np.array([problem.planes[p].angles[h] for p, h, _ in places])
    G, h = _limits(problem, plane, position, item, mass)
    capacity = np.array([problem.planes[p].capacity[h] for p, h, _ in places])
    pieces = np.array([problem.planes[p].max_pieces for p, _, _ in places])
    most = np.minimum(np.minimum(capacity, pieces), problem.stock.counts[item])
    empty = np.empty((0, len(places)))
    vector = np.asarray(mass * np.exp(1j * angles), dtype=np.complex128)
    return Linear(plane, position, item, most, empty, np.empty(0), np.empty(0, np.int64), G, h, vector)


def _cost(problem: SelectionProblem, plane: IntArray, vector: ComplexArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Rows whose greatest, for each t, is what a residual costs."""
    objective = problem.objective
    weighted = objective.weights[:, None] * objective.matrix[:, plane] * vector
    fixed = np.array([p.fixed for p in problem.planes])
    start = objective.weights * (objective.offset + objective.matrix @ fixed)
    sides = 4 if objective.norm == "components" else SIDES
    C, d, of = [], [], []
    for s in range(len(start)):
        for k in range(sides):
            turn = np.exp(-2j * math.pi * k / sides)
            C.append((weighted[s] * turn).real)
            d.append(float((start[s] * turn).real))
            of.append(2 * s + k % 2 if objective.norm == "components" else 0 if objective.norm == "max" else s)
    return np.array(C), np.array(d), np.array(of, dtype=np.int64)


def _limits(
    problem: SelectionProblem, plane: IntArray, position: IntArray, item: IntArray, mass: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows for pieces and grams of planes and positions, and for the box; those without a limit are left out."""
    rows: list[FloatArray] = []
    limits: list[float] = []

    def add(row: FloatArray, limit: float) -> None:
        if limit < min(1e12, float(row.sum()) * 1e6):
            rows.append(row)
            limits.append(limit)

    for p, where in enumerate(problem.planes):
        mine = (plane == p).astype(np.float64)
        add(mine, float(where.max_pieces))
        add(mine * mass, where.max_mass_g)
        for h in range(len(where.angles)):
            here = mine * (position == h)
            add(here, float(where.capacity[h]))
            add(here * mass, float(where.capacity_g[h]))
    for i, count in enumerate(problem.stock.counts.tolist()):
        add((item == i).astype(np.float64), float(count))
    return np.array(rows).reshape(-1, len(plane)), np.array(limits)
