"""Modified Jaya on the selection problem: a good searcher that proves nothing.

Each plane has as many slots as it takes pieces; a slot is a mass (0: left empty) and a position. With the improved
rules positions lie on a circle and a member that breaks a limit is repaired by emptying slots; as published (thesis,
chapters 4 and 5) angles run from first to last and a broken limit costs a fixed penalty.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np

from service.balancing.checks import validate
from service.balancing.objectives import evaluate
from service.balancing.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.placements import Selection, effective_g, result_of, slots, within_g
from service.balancing.selection import Piece, SelectionProblem, SelectionResult
from service.optimize.jaya import Jaya, Stop
from service.optimize.problem import Circular, Discrete, MixedProblem, Variable

MOST_SLOTS = 24
"""Slots a plane at most: beyond that the search is hopeless and would only take memory."""
PUBLISHED_BUDGETS = {1: (20, 100), 2: (100, 500), 3: (200, 3000), 4: (300, 3000)}
"""Masses a plane -> population and generations of the published runs."""
DEFAULT_BUDGETS = {1: (20, 100), 2: (60, 200), 3: (100, 300), 4: (150, 400)}
"""The same for the improved rules when the caller states none; beyond 4 masses a plane the last one holds."""


@dataclass(frozen=True)
class _Layout:
    """Where each slot's variables stand, and what their values mean."""

    plane: IntArray  # (slots,) plane of each slot
    mass: FloatArray  # (I + 1,) mass of each rank, ascending; rank 0 is the empty slot
    item: IntArray  # (I + 1,) stock item of each rank, -1 for the empty slot
    order: tuple[IntArray, ...]  # per plane: positions by ascending angle
    turned: tuple[FloatArray, ...]  # per plane: those angles, 0 <= angle < 2 pi


@dataclass(frozen=True)
class JayaState:
    """After one generation: the best selection so far."""

    generation: int
    selection: Selection
    value: float
    evaluations: int


def search_jaya(
    problem: SelectionProblem,
    rng: np.random.Generator,
    *,
    members: int | None = None,
    as_published: bool = False,
) -> Iterator[JayaState]:
    """Endless iterator, one step per generation; the caller decides when to stop. Deterministic for a given `rng`."""
    validate(problem)
    layout = _layout(problem)
    if layout.plane.size == 0:
        return _nothing_fits(problem)
    population = members or budget(problem, as_published=as_published)[0]
    mixed = _as_mixed(problem, layout, as_published)
    return _states(
        problem, layout, Jaya(mixed, population, rng, rules="published" if as_published else "improved"), as_published
    )


def solve_jaya(
    problem: SelectionProblem,
    seed: int,
    *,
    members: int | None = None,
    generations: int | None = None,
    as_published: bool = False,
    stop: Stop = lambda: False,
) -> SelectionResult:
    """Best selection after `generations` (default: by masses a plane), or when `stop()` says so; nothing is proved.

    details: `generations`, `members`, `seed`. Raises NumericsError for an invalid problem.
    """
    validate(problem)
    default = budget(problem, as_published=as_published)
    population, rounds = members or default[0], generations or default[1]
    search = search_jaya(problem, np.random.default_rng(seed), members=population, as_published=as_published)
    state = next(search)
    while state.generation < rounds and not stop():
        state = next(search)
    ended = "stopped" if state.generation < rounds else "budget spent"
    return result_of(
        problem,
        state.selection,
        "heuristic",
        f"modified Jaya, {state.generation} generations of {population}, {ended}; nothing is proved",
        state.evaluations,
        details={"generations": state.generation, "members": population, "seed": seed},
    )


def budget(problem: SelectionProblem, *, as_published: bool) -> tuple[int, int]:
    """Return population and generations for the greatest number of masses that a plane may carry."""
    most = max(slots(plane, problem.stock) for plane in problem.planes)
    table = PUBLISHED_BUDGETS if as_published else DEFAULT_BUDGETS
    return table[min(max(most, 1), max(table))]


def _layout(problem: SelectionProblem) -> _Layout:
    mass = effective_g(problem.stock)
    rank = np.argsort(mass, kind="stable")
    turned = [np.mod(plane.angles, 2.0 * math.pi) for plane in problem.planes]
    order = [np.argsort(angles, kind="stable") for angles in turned]
    many = [min(slots(plane, problem.stock), MOST_SLOTS) for plane in problem.planes]
    return _Layout(
        plane=np.repeat(np.arange(len(many)), many),
        mass=np.concatenate([[0.0], mass[rank]]),
        item=np.concatenate([[-1], rank]).astype(np.int64),
        order=tuple(order),
        turned=tuple(a[o] for a, o in zip(turned, order, strict=True)),
    )


def _as_mixed(problem: SelectionProblem, layout: _Layout, as_published: bool) -> MixedProblem:
    """Slot s is variable 2 s, the rank of its mass or the mass itself, and variable 2 s + 1, the angle."""
    ranks = np.arange(len(layout.mass), dtype=np.float64)
    masses = np.unique(layout.mass) if as_published else ranks
    variables: list[Variable] = []
    for p in layout.plane:
        angles = tuple(layout.turned[p].tolist())
        variables += [Discrete(tuple(masses.tolist())), Discrete(angles) if as_published else Circular(angles)]

    def values(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        rank, position = _decode(layout, x, as_published)
        objective = evaluate(problem.objective, _vectors(problem, layout, rank, position))
        if not as_published:
            return objective, np.zeros((len(x), 1))
        broken = (_repaired(problem, layout, rank, position) != rank).any(axis=1)
        return objective, broken[:, None].astype(np.float64)

    def repair(x: FloatArray) -> FloatArray:
        rank, position = _decode(layout, x, as_published)
        mended = x.copy()
        mended[:, 0::2] = _repaired(problem, layout, rank, position)
        return mended

    return MixedProblem(tuple(variables), values, None if as_published else repair)


def _decode(layout: _Layout, x: FloatArray, as_published: bool) -> tuple[IntArray, IntArray]:
    """(n, slots) ranks of masses and positions in order of angle."""
    rank = np.searchsorted(layout.mass, x[:, 0::2]) if as_published else x[:, 0::2].astype(np.int64)
    position = np.empty(rank.shape, dtype=np.int64)
    for p, angles in enumerate(layout.turned):
        mine = layout.plane == p
        position[:, mine] = np.searchsorted(angles, x[:, 1::2][:, mine])
    return rank.astype(np.int64), position


def _vectors(problem: SelectionProblem, layout: _Layout, rank: IntArray, position: IntArray) -> ComplexArray:
    u = np.empty((len(rank), len(problem.planes)), dtype=np.complex128)
    for p, plane in enumerate(problem.planes):
        mine = layout.plane == p
        turn = np.exp(1j * layout.turned[p])
        u[:, p] = plane.fixed + (layout.mass[rank[:, mine]] * turn[position[:, mine]]).sum(axis=1)
    return u


def _repaired(problem: SelectionProblem, layout: _Layout, rank: IntArray, position: IntArray) -> IntArray:
    """Ranks with every slot emptied that breaks a limit, slots taken in order."""
    n = np.arange(len(rank))
    left = np.tile(problem.stock.counts, (len(rank), 1))
    mended = rank.copy()
    for p, plane in enumerate(problem.planes):
        order = layout.order[p]
        pieces = np.tile(plane.capacity[order], (len(rank), 1))
        grams = np.zeros((len(rank), len(order)))
        total = np.zeros(len(rank))
        for s in np.flatnonzero(layout.plane == p):
            where, mass, item = position[:, s], layout.mass[rank[:, s]], layout.item[rank[:, s]]
            taken = rank[:, s] > 0
            fits = (pieces[n, where] > 0) & within_g(grams[n, where] + mass, plane.capacity_g[order][where])
            fits &= within_g(total + mass, plane.max_mass_g) & (left[n, item] > 0)
            if plane.allowed is not None:
                fits &= plane.allowed[order[where], item]
            mended[:, s] = np.where(fits, rank[:, s], 0)
            kept = fits & taken
            pieces[n, where] -= kept
            grams[n, where] += kept * mass
            total += kept * mass
            left[n, item] -= kept
    return mended


def _states(problem: SelectionProblem, layout: _Layout, search: Jaya, as_published: bool) -> Iterator[JayaState]:
    """Each generation's best as a selection; a member that breaks a limit is emptied where it does."""
    for state in search:
        rank, position = _decode(layout, state.x[None, :], as_published)
        rank = _repaired(problem, layout, rank, position)
        value = float(evaluate(problem.objective, _vectors(problem, layout, rank, position))[0])
        yield JayaState(state.number, _pieces(layout, rank[0], position[0]), value, state.evaluations)


def _pieces(layout: _Layout, rank: IntArray, position: IntArray) -> Selection:
    return tuple(
        tuple(
            sorted(
                Piece(int(order[position[s]]), int(layout.item[rank[s]]))
                for s in np.flatnonzero((layout.plane == p) & (rank > 0))
            )
        )
        for p, order in enumerate(layout.order)
    )


def _nothing_fits(problem: SelectionProblem) -> Iterator[JayaState]:
    """No plane takes a piece: the empty selection is the only one."""
    empty = np.array([plane.fixed for plane in problem.planes])
    value = float(evaluate(problem.objective, empty))
    for generation in count(1):
        yield JayaState(generation, tuple(() for _ in problem.planes), value, 1)
