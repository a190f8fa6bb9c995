"""Methods that the search is measured against, each within a budget of processor time.

Pair-swap descent from random starts, simulated annealing, and the differencing of Karmarkar and Karp (1982) carried
over to the plane: the answer of practice and of the literature on blades (Laporte and Mercure 1988; Choi and Storer
2004). CP-SAT and HiGHS: the assignment with the norm cut to a polygon.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from service.balancing.arrangement import ArrangementProblem, values, within_limits
from service.balancing.rotor.phasors import IntArray

Peer = Callable[[ArrangementProblem, int, float], "IntArray | None"]
DIRECTIONS = 8
"""Half of the directions that a circle is cut to for the linear peers: 1.9 % off at most."""
SCALE = 10.0
"""Steps in which CP-SAT counts a g.mm."""


def pair_swap_descent(problem: ArrangementProblem, seed: int, budget_s: float) -> IntArray | None:
    """Swap the best pair until none helps; start again at random."""
    rng, end = np.random.default_rng(seed), time.process_time() + budget_s
    best: tuple[float, IntArray] | None = None
    while time.process_time() < end:
        row = _random(problem, rng)
        if row is None:
            return None
        value = _value(problem, row)
        while time.process_time() < end:
            swaps = _swaps(problem, row)
            rated = values(problem, swaps)
            pick = int(rated.argmin()) if len(rated) else -1
            if pick < 0 or rated[pick] >= value:
                break
            row, value = swaps[pick], float(rated[pick])
        if best is None or value < best[0]:
            best = (value, row)
    return None if best is None else best[1]


def annealing(problem: ArrangementProblem, seed: int, budget_s: float) -> IntArray | None:
    """Random swaps, a worse one taken with exp(-increase / temperature), cooled a thousandfold within the budget."""
    rng, begun = np.random.default_rng(seed), time.process_time()
    row = _random(problem, rng)
    if row is None:
        return None
    value = _value(problem, row)
    hot, best = value, (value, row)
    while (spent := time.process_time() - begun) < budget_s:
        temperature = hot * 10.0 ** (-4.0 * spent / budget_s)
        i, j = rng.choice(problem.places, 2, replace=False)
        if not (problem.allowed[row[i], j] and problem.allowed[row[j], i]):
            continue
        other = row.copy()
        other[[i, j]] = row[[j, i]]
        changed = _value(problem, other)
        if changed < value or rng.random() < math.exp(-(changed - value) / temperature):
            row, value = other, changed
            if value < best[0]:
                best = (value, row)
    return best[1]


def differencing(problem: ArrangementProblem, _seed: int, _budget_s: float) -> IntArray | None:
    """Neighbours in rank opposite each other, the pairs with the largest difference first, each where it helps most.

    None where places have no opposites, or parts do not fit everywhere.
    """
    count = problem.places
    if count % 2 or problem.parts != count or not problem.allowed.all():
        return None
    ranked = np.argsort(-problem.masses_g, kind="stable")
    pairs = sorted(zip(ranked[::2], ranked[1::2], strict=True), key=lambda p: -_difference(problem, *p))
    mean = problem.effects.mean(axis=0)
    r = problem.objective.offset + mean.sum(axis=0)
    out = np.full(count, -1, dtype=np.int64)
    free = set(range(count // 2))
    for heavy, light in pairs:
        tried = []
        for axis in free:
            for one, two in ((heavy, light), (light, heavy)):
                change = problem.effects[one, axis] - mean[axis]
                change = change + problem.effects[two, axis + count // 2] - mean[axis + count // 2]
                tried.append((float(np.abs(r + change).max()), axis, int(one), int(two), change))
        _, axis, one, two, change = min(tried, key=lambda t: t[:4])
        out[axis], out[axis + count // 2] = one, two
        free.discard(axis)
        r = r + change
    return out


def highs(problem: ArrangementProblem, _seed: int, budget_s: float) -> IntArray | None:
    """HiGHS on the assignment, the norm cut to a polygon."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    parts, places, _ = problem.effects.shape
    count = parts * places
    matrix, least = _polygon(problem)
    cost = np.append(np.zeros(count), 1.0)
    each_place = np.kron(np.ones(parts), np.eye(places))
    each_part = np.kron(np.eye(parts), np.ones(places))
    pad = np.zeros
    found = milp(
        cost,
        integrality=np.append(np.ones(count), 0.0),
        bounds=Bounds(0.0, np.append(problem.allowed.ravel().astype(float), np.inf)),
        constraints=[
            LinearConstraint(np.hstack([each_place, pad((places, 1))]), 1.0, 1.0),
            LinearConstraint(np.hstack([each_part, pad((parts, 1))]), 0.0, 1.0),
            LinearConstraint(np.hstack([matrix, -np.ones((len(matrix), 1))]), -np.inf, -least),
        ],
        options={"time_limit": budget_s},
    )
    return None if found.x is None else _read(found.x[:count].reshape(parts, places))


def cp_sat(problem: ArrangementProblem, seed: int, budget_s: float) -> IntArray | None:
    """OR-Tools' CP-SAT on the assignment, the norm cut to a polygon and counted in tenths of a unit."""
    cp_model: Any = importlib.import_module("ortools.sat.python.cp_model")

    parts, places, _ = problem.effects.shape
    matrix, least = _polygon(problem)
    model = cp_model.CpModel()
    x = [[model.new_bool_var(f"{k},{p}") for p in range(places)] for k in range(parts)]
    for p in range(places):
        model.add_exactly_one(x[k][p] for k in range(parts) if problem.allowed[k, p])
    for k in range(parts):
        model.add_at_most_one(x[k])
        for p in range(places):
            if not problem.allowed[k, p]:
                model.add(x[k][p] == 0)
    top = model.new_int_var(0, 2**40, "norm")
    whole, flat = np.rint(SCALE * matrix).astype(np.int64), [one for row in x for one in row]
    for row, start in zip(whole.tolist(), np.rint(SCALE * least).astype(np.int64).tolist(), strict=True):
        model.add(sum(c * v for c, v in zip(row, flat, strict=True)) + start <= top)
    model.minimize(top)
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = budget_s
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = seed
    if solver.solve(model) not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return None
    return _read(np.array([[solver.value(one) for one in row] for row in x]))


PEERS: dict[str, Peer] = {
    "pair-swap descent": pair_swap_descent,
    "annealing": annealing,
    "differencing": differencing,
    "CP-SAT": cp_sat,
    "HiGHS": highs,
}


def _polygon(problem: ArrangementProblem) -> tuple[np.ndarray[tuple[int, int], np.dtype[np.float64]], IntArray]:
    """Rows (2 S DIRECTIONS, K P) and constants: the projections of the weighted residual on the directions."""
    turns = np.exp(-2j * np.pi * np.arange(2 * DIRECTIONS) / (2 * DIRECTIONS))
    weighted = problem.effects * problem.objective.weights
    rows = np.einsum("kps,d->sdkp", weighted, turns).real.reshape(-1, problem.parts * problem.places)
    least = np.outer(problem.objective.offset * problem.objective.weights, turns).real.ravel()
    return rows, least


def _read(chosen: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> IntArray:
    return np.asarray(np.argmax(chosen, axis=0), dtype=np.int64)


def _value(problem: ArrangementProblem, row: IntArray) -> float:
    return float(values(problem, row[None, :])[0])


def _difference(problem: ArrangementProblem, one: int, two: int) -> float:
    return float(abs(problem.masses_g[one] - problem.masses_g[two]))


def _random(problem: ArrangementProblem, rng: np.random.Generator) -> IntArray | None:
    """A random arrangement of parts that fit; None where a limit goes beyond that."""
    cost = np.where(problem.allowed, rng.random(problem.allowed.shape), 1e6)
    parts, places = linear_sum_assignment(cost)
    row = np.full(problem.places, -1, dtype=np.int64)
    row[places] = parts
    fits = (row >= 0).all() and problem.allowed[row, np.arange(problem.places)].all()
    return row if fits and within_limits(problem, row[None, :])[0] else None


def _swaps(problem: ArrangementProblem, row: IntArray) -> IntArray:
    i, j = np.triu_indices(problem.places, 1)
    fits = problem.allowed[row[i], j] & problem.allowed[row[j], i]
    i, j = i[fits], j[fits]
    out = np.repeat(row[None, :], len(i), axis=0)
    at = np.arange(len(i))
    out[at, i], out[at, j] = row[j], row[i]
    return out
