"""Modified Jaya on the selection problem: a metaheuristic without a proof.

Each plane has as many slots as it takes pieces; a slot is a mass (0: left empty) and a position. With the improved
rules positions lie on a circle and a member that breaks a limit is repaired by emptying slots; as published (thesis,
chapters 4 and 5) angles run from first to last and a broken limit costs a fixed penalty.

Members and independent runs are rows of the same arrays: several runs advance together, one generation a step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate, count

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, effective_g, result_of, slots, within_g
from service.balancing.selection.problem import Piece, SelectionProblem, SelectionResult
from service.balancing.selection.validation import validate
from service.errors import NumericsError
from service.messages import Message, Word
from service.optimize.jaya import Jaya, Rules, Stop
from service.optimize.problem import Circular, Discrete, MixedProblem, Variable

MAX_SLOTS = 24
"""Slots a plane at most: beyond that the search is hopeless and would only take memory."""
PUBLISHED_BUDGETS = {1: (20, 100), 2: (100, 500), 3: (200, 3000), 4: (300, 3000)}
"""Masses a plane -> population and generations of the published runs."""
DEFAULT_BUDGETS = {1: (20, 100), 2: (60, 200), 3: (100, 300), 4: (150, 400)}
"""The same for the improved rules when the caller states none; beyond 4 masses a plane the last one holds."""
MAX_TOGETHER = 60_000
"""Slots of all members of all runs that one step may move: some forty milliseconds."""
SAME = 1e-9
"""Relative difference below which two runs ended at the same value."""


@dataclass(frozen=True)
class _Binding:
    """Whether pieces a position, grams a position, grams a plane, the box, or barred positions can stand in the way."""

    pieces: bool
    grams: bool
    total: bool
    stock: bool
    barred: bool


@dataclass(frozen=True)
class _Layout:
    """Where each slot's variables stand, and what their values mean."""

    plane: IntArray  # (slots,) plane of each slot
    slots: tuple[slice, ...]  # per plane: its slots
    mass: FloatArray  # (I + 1,) mass of each rank, ascending; rank 0 is the empty slot
    item: IntArray  # (I + 1,) stock item of each rank, -1 for the empty slot
    order: tuple[IntArray, ...]  # per plane: positions by ascending angle
    turned: tuple[FloatArray, ...]  # per plane: those angles, 0 <= angle < 2 pi
    turns: tuple[ComplexArray, ...]  # per plane: unit vectors at those angles
    binding: tuple[_Binding, ...]  # per plane: the limits that full slots can break at all


FREE = _Binding(pieces=False, grams=False, total=False, stock=False, barred=False)
"""No limit that full slots can break."""


@dataclass(frozen=True)
class JayaState:
    """After one generation: the best selection so far of all runs, and the value of each run's best."""

    generation: int
    selection: Selection
    value: float
    evaluations: int
    values: tuple[float, ...]


def search_jaya(
    problem: SelectionProblem,
    rng: np.random.Generator,
    *,
    members: int | None = None,
    runs: int = 1,
    as_published: bool = False,
) -> Iterator[JayaState]:
    """Endless iterator, one step a generation of every run; the caller decides when to stop.

    Deterministic for a given `rng`. Raises NumericsError for an invalid problem, and for more than a step may move.
    """
    validate(problem)
    return _search(problem, rng, members, runs, as_published)


def _search(
    problem: SelectionProblem, rng: np.random.Generator, members: int | None, runs: int, as_published: bool
) -> Iterator[JayaState]:
    layout = _layout(problem)
    if layout.plane.size == 0:
        return _nothing_fits(problem, runs)
    population = members or budget(problem, as_published=as_published)[0]
    if runs * population * layout.plane.size > MAX_TOGETHER and runs > 1:
        raise NumericsError(
            Message(
                "numerics.jaya_runs",
                runs=runs,
                members=population,
                slots=layout.plane.size,
                most=runs_together(problem, population),
            ),
            field="runs",
            value=runs,
        )
    mixed = _as_mixed(problem, layout, as_published)
    rules: Rules = "published" if as_published else "improved"
    return _states(problem, layout, Jaya(mixed, population, rng, runs=runs, rules=rules), as_published)


def solve_jaya(
    problem: SelectionProblem,
    seed: int,
    *,
    members: int | None = None,
    generations: int | None = None,
    runs: int = 1,
    as_published: bool = False,
    stop: Stop = lambda: False,
) -> SelectionResult:
    """Best selection of `runs` runs after `generations` (default: by masses a plane), or when `stop()` says so.

    Nothing is proved. details: `generations`, `members`, `runs`, `seed`, and `agreeing`, the runs that ended at the
    same value. Raises NumericsError as `search_jaya`.
    """
    validate(problem)
    population, rounds = members or 0, generations or 0
    if not (population and rounds):
        default = budget(problem, as_published=as_published)
        population, rounds = members or default[0], generations or default[1]
    search = _search(problem, np.random.default_rng(seed), population, runs, as_published)
    state = next(search)
    while state.generation < rounds and not stop():
        state = next(search)
    agreeing = sum(value <= state.value * (1.0 + SAME) for value in state.values)
    return result_of(
        problem,
        state.selection,
        "heuristic",
        Message(
            "jaya_ended" if runs > 1 else "jaya_ended.one_run",
            generations=state.generation,
            members=population,
            ended=Word("stopped" if state.generation < rounds else "budget_spent"),
            agreeing=agreeing,
            runs=runs,
        ),
        state.evaluations,
        details={
            "generations": state.generation,
            "members": population,
            "runs": runs,
            "agreeing": agreeing,
            "seed": seed,
        },
    )


def runs_together(problem: SelectionProblem, members: int) -> int:
    """Most independent runs of this many members that one step may move; at least 1."""
    return max(1, MAX_TOGETHER // max(1, members * _layout(problem).plane.size))


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
    many = [min(slots(plane, problem.stock), MAX_SLOTS) for plane in problem.planes]
    slotted = sum(many)
    binding = [
        _Binding(
            pieces=bool(plane.capacity.min() < slots_here),
            grams=bool(np.isfinite(plane.capacity_g).any()),
            total=math.isfinite(plane.max_mass_g),
            stock=bool(problem.stock.counts.min() < slotted),
            barred=plane.allowed is not None,
        )
        for plane, slots_here in zip(problem.planes, many, strict=True)
    ]
    sorted_angles = [a[o] for a, o in zip(turned, order, strict=True)]
    return _Layout(
        plane=np.repeat(np.arange(len(many)), many),
        slots=tuple(slice(end - own, end) for end, own in zip(accumulate(many), many, strict=True)),
        mass=np.concatenate([[0.0], mass[rank]]),
        item=np.concatenate([[-1], rank]).astype(np.int64),
        order=tuple(order),
        turned=tuple(sorted_angles),
        turns=tuple(np.exp(1j * angles) for angles in sorted_angles),
        binding=tuple(binding),
    )


def _as_mixed(problem: SelectionProblem, layout: _Layout, as_published: bool) -> MixedProblem:
    """Slot s is variable 2 s, the rank of its mass or the mass itself, and variable 2 s + 1, the angle."""
    ranks = np.arange(len(layout.mass), dtype=np.float64)
    masses = np.unique(layout.mass) if as_published else ranks
    mass = Discrete(tuple(masses.tolist()))
    angle = [(Discrete if as_published else Circular)(tuple(angles.tolist())) for angles in layout.turned]
    variables: list[Variable] = [variable for p in layout.plane for variable in (mass, angle[p])]

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

    bound = any(binding != FREE for binding in layout.binding)
    return MixedProblem(tuple(variables), values, repair if bound and not as_published else None)


def _decode(layout: _Layout, x: FloatArray, as_published: bool) -> tuple[IntArray, IntArray]:
    """(n, slots) ranks of masses and positions in order of angle."""
    rank = np.searchsorted(layout.mass, x[:, 0::2]) if as_published else x[:, 0::2].astype(np.int64)
    position = np.empty(rank.shape, dtype=np.int64)
    for mine, angles in zip(layout.slots, layout.turned, strict=True):
        position[:, mine] = angles.searchsorted(x[:, 1::2][:, mine])
    return rank.astype(np.int64), position


def _vectors(problem: SelectionProblem, layout: _Layout, rank: IntArray, position: IntArray) -> ComplexArray:
    u = np.empty((len(rank), len(problem.planes)), dtype=np.complex128)
    mass = layout.mass[rank]
    for p, (plane, mine) in enumerate(zip(problem.planes, layout.slots, strict=True)):
        u[:, p] = plane.fixed + (mass[:, mine] * layout.turns[p][position[:, mine]]).sum(axis=1)
    return u


def _repaired(problem: SelectionProblem, layout: _Layout, rank: IntArray, position: IntArray) -> IntArray:
    """Ranks with every slot emptied that breaks a limit, slots taken in order.

    Each slot is compared with those before it, not with a table of positions and stock: a box may be long.
    """
    mended, mass = rank.copy(), layout.mass[rank]
    counts = np.append(problem.stock.counts, 0)[layout.item]
    for p, plane in enumerate(problem.planes):
        order = layout.order[p]
        capacity, capacity_g = plane.capacity[order], plane.capacity_g[order]
        mine, binding = np.flatnonzero(layout.plane == p), layout.binding[p]
        total = np.zeros(len(rank))
        for s in mine if binding != FREE else ():
            before, where, grams = slice(mine[0], s), position[:, s], mass[:, s]
            fits = np.ones(len(rank), dtype=bool)
            if binding.pieces or binding.grams:
                here = (mended[:, before] > 0) & (position[:, before] == where[:, None])
                fits &= here.sum(axis=1) < capacity[where]
            if binding.grams:
                fits &= within_g((here * mass[:, before]).sum(axis=1) + grams, capacity_g[where])
            if binding.total:
                fits &= within_g(total + grams, plane.max_mass_g)
            if binding.stock:
                fits &= (mended[:, :s] == rank[:, s : s + 1]).sum(axis=1) < counts[rank[:, s]]
            if plane.allowed is not None:
                fits &= plane.allowed[order[where], layout.item[rank[:, s]]]
            mended[:, s] = np.where(fits, rank[:, s], 0)
            total += fits * grams
    return mended


def _states(problem: SelectionProblem, layout: _Layout, search: Jaya, as_published: bool) -> Iterator[JayaState]:
    """Each generation's best as a selection; a member that breaks a limit is emptied where it does."""
    known: FloatArray | None = None
    for state in search:
        bests = search.run_bests()
        if known is None or not np.array_equal(bests, known):
            known = bests
            rank, position = _decode(layout, bests, as_published)
            if as_published:
                rank = _repaired(problem, layout, rank, position)
            values = evaluate(problem.objective, _vectors(problem, layout, rank, position))
            best = int(values.argmin())
            pieces = _pieces(layout, rank[best], position[best])
        yield JayaState(state.number, pieces, float(values[best]), state.evaluations, tuple(values.tolist()))


def _pieces(layout: _Layout, rank: IntArray, position: IntArray) -> Selection:
    return tuple(
        tuple(
            sorted(
                Piece(int(order[where]), int(layout.item[chosen]))
                for chosen, where in zip(rank[mine].tolist(), position[mine].tolist(), strict=True)
                if chosen > 0
            )
        )
        for mine, order in zip(layout.slots, layout.order, strict=True)
    )


def _nothing_fits(problem: SelectionProblem, runs: int) -> Iterator[JayaState]:
    """No plane takes a piece: the empty selection is the only one."""
    empty = np.array([plane.fixed for plane in problem.planes])
    value = float(evaluate(problem.objective, empty))
    for generation in count(1):
        yield JayaState(generation, tuple(() for _ in problem.planes), value, 1, (value,) * runs)
