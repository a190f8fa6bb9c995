"""Parts and stock masses as one problem: for each arrangement the best selection, best bound first.

No selection brings an arrangement below what the nearest vector sums of each plane leave, stock shared or not. The
arrangements are taken in the order of that bound and each is selected for exactly, until the bound of the next one is
not below the best: then all of them are proved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from service.balancing.arrangement.exact.enumeration import MAX_ENUMERATED, count_bound, every_arrangement
from service.balancing.arrangement.exact.few_moves import few_changes, listed_changes, open_changes
from service.balancing.arrangement.exact.region import axes_of, length_factor
from service.balancing.arrangement.exact.slots import slots_of
from service.balancing.arrangement.problem import ArrangementProblem
from service.balancing.arrangement.rating import moves, new_parts, residuals, values, within_limits
from service.balancing.arrangement.record import TIE
from service.balancing.arrangement.solve import search_best
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.exact.search import solve_exact
from service.balancing.selection.objectives import norm_of
from service.balancing.selection.placements import Selection, effective_g, slots
from service.balancing.selection.problem import Objective, SelectionPlane, SelectionProblem, Stock

MAX_SUMS = 300_000
"""Vector sums of one plane that are listed for the bound; beyond that the bound leaves the plane's part out."""
FAR = 1e15
"""Level that every arrangement is below, where all with few moves are listed."""
LISTED_MOVES = 3
"""Changed places up to which the arrangements of a large problem are listed."""
GUESSES = 30
"""Steps of the search for the best arrangement without masses, which the joint search begins with."""


@dataclass(frozen=True)
class MassChoice:
    """Where stock masses may go: planes and box as of a selection; matrix: (S, Q), unit of r per gram in each plane."""

    planes: tuple[SelectionPlane, ...]
    stock: Stock
    matrix: ComplexArray

    def problem(self, objective: Objective, offset: ComplexArray) -> SelectionProblem:
        """The selection that is left once the parts are arranged."""
        return SelectionProblem(
            Objective(self.matrix, offset, objective.weights, objective.norm), self.planes, self.stock
        )


@dataclass(frozen=True)
class JointResult:
    """The best arrangement with its stock masses; None where there is none.

    vectors: (Q,) complex g, what was fixed included. proved: nothing better is left. moves_bound: no fewer moves meet
    the limit, where one is given.
    """

    arrangement: IntArray | None
    pieces: Selection | None
    vectors: ComplexArray
    value: float
    lower_bound: float
    evaluations: int
    proved: bool
    moves_bound: int | None = None


def solve_with_masses(
    problem: ArrangementProblem,
    choice: MassChoice,
    seed: int,
    *,
    limit: float | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> JointResult:
    """Least objective of parts and masses together; with `limit` the fewest moves, then new parts, that meet it."""
    search = _Joint(problem, choice, limit, stop)
    listed = _listed(problem, stop)
    if listed is None:
        search.run(_guessed(problem, seed, stop), complete=False)
    else:
        search.run(listed, complete=True)
    return search.result()


class _Joint:
    def __init__(
        self, problem: ArrangementProblem, choice: MassChoice, limit: float | None, stop: Callable[[], bool]
    ) -> None:
        self.problem, self.choice, self.limit, self.stop = problem, choice, limit, stop
        self.bound = _SelectionBound(problem.objective, choice)
        self.arrangement: IntArray | None = None
        self.pieces: Selection | None = None
        self.vectors = np.zeros(len(choice.planes), dtype=np.complex128)
        self.value, self.floor, self.evaluations = math.inf, 0.0, 0
        self.rank: tuple[int, int] = (0, 0)
        self.proved = False
        self.moves_bound = 0

    def run(self, arrangements: IntArray, *, complete: bool) -> None:
        """Select for arrangements (n, P), best bound first; complete: they are all there are."""
        least = self.bound.of(residuals(self.problem, arrangements)) if len(arrangements) else np.zeros(0)
        changed, fresh = moves(self.problem, arrangements), new_parts(self.problem, arrangements)
        if self.limit is None:
            order = np.lexsort((changed, least))
        else:
            arrangements, least = arrangements[least <= self.limit], least
            keep = least <= self.limit
            least, changed, fresh = least[keep], changed[keep], fresh[keep]
            order = np.lexsort((least, fresh, changed))
        for row in order.tolist():
            rank = (int(changed[row]), int(fresh[row]))
            if self._done(rank, float(least[row])):
                break
            if self.stop():
                self.floor = min(float(least[row]), self.value) if self.limit is None and complete else 0.0
                return
            if self.limit is not None:
                self.moves_bound = rank[0] if complete else 0
                if float(least[row]) >= self.value:
                    continue
            self._select(arrangements[row], rank)
        self.proved = complete and not self.stop()
        if self.proved:
            self.floor = self.value if self.limit is None else 0.0

    def _done(self, rank: tuple[int, int], least: float) -> bool:
        """Whether neither this arrangement nor a later one can be better."""
        if self.arrangement is None:
            return False
        if self.limit is None:
            return least >= self.value * (1.0 - TIE)
        return rank > self.rank

    def _select(self, arrangement: IntArray, rank: tuple[int, int]) -> None:
        offset = residuals(self.problem, arrangement[None, :])[0]
        found = solve_exact(self.choice.problem(self.problem.objective, offset), stop=self.stop)
        self.evaluations += 1 + found.evaluations
        if found.pieces is None or (self.limit is not None and found.value > self.limit * (1.0 + TIE)):
            return
        if found.value < self.value * (1.0 - TIE):
            self.arrangement, self.pieces, self.value, self.rank = arrangement, found.pieces, found.value, rank
            self.vectors = found.vectors

    def result(self) -> JointResult:
        """What was found."""
        return JointResult(
            self.arrangement,
            self.pieces,
            self.vectors,
            self.value,
            min(self.floor, self.value) if self.arrangement is not None else self.floor,
            self.evaluations,
            self.proved,
            None if self.limit is None else self.moves_bound,
        )


class _SelectionBound:
    """Least objective that any selection leaves of a residual, from the nearest vector sums of each plane."""

    def __init__(self, objective: Objective, choice: MassChoice) -> None:
        self.objective = objective
        self.weighted = choice.matrix * objective.weights[:, None]
        self.trees = [_tree(plane, choice.stock) for plane in choice.planes]
        strength = np.linalg.svd(self.weighted, compute_uv=False)
        self.weakest = float(strength.min()) if len(strength) == self.weighted.shape[1] else 0.0
        square = self.weighted.shape[0] == self.weighted.shape[1]
        self.diagonal = square and not np.abs(self.weighted - np.diag(np.diag(self.weighted))).any()
        self.inverse = np.linalg.pinv(self.weighted)
        self.plain = replace(objective, weights=np.ones(len(objective.weights)))

    def of(self, r: ComplexArray) -> FloatArray:
        """Bounds (n,) for residuals (n, S)."""
        rho = r * self.objective.weights
        wanted = -rho @ self.inverse.T
        away = np.stack([_distance(tree, wanted[:, q]) for q, tree in enumerate(self.trees)], axis=1)
        if self.diagonal:
            return norm_of(self.plain, np.asarray(away * np.abs(np.diag(self.weighted)), dtype=np.complex128))
        rest = rho + wanted @ self.weighted.T
        square = (np.abs(rest) ** 2).sum(axis=1) + (self.weakest**2) * (away**2).sum(axis=1)
        return np.asarray(np.sqrt(square) / length_factor(self.objective.norm, r.shape[1]) * (1.0 - TIE))


def _distance(tree: KDTree | None, wanted: ComplexArray) -> FloatArray:
    if tree is None:
        return np.zeros(len(wanted))
    return np.asarray(tree.query(np.stack([wanted.real, wanted.imag], axis=1))[0])


def _tree(plane: SelectionPlane, stock: Stock) -> KDTree | None:
    """Vector sums of a plane, some that the box or the holes do not allow among them; None where there are too many."""
    if not len(stock.masses_g) or not plane.max_pieces or not plane.capacity.any():
        return KDTree([[plane.fixed.real, plane.fixed.imag]])
    holes = np.flatnonzero(plane.capacity > 0)
    placed = (effective_g(stock)[None, :] * np.exp(1j * plane.angles[holes])[:, None]).ravel()
    most = slots(plane, stock)
    if sum(math.comb(len(placed) + n - 1, n) for n in range(1, most + 1)) > MAX_SUMS:
        return None
    sums, last = np.array([plane.fixed]), np.zeros(1, dtype=np.int64)
    every = [sums]
    for _ in range(most):
        count = len(placed) - last
        row = np.repeat(np.arange(len(sums)), count)
        step = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        last = last[row] + step
        sums = sums[row] + placed[last]
        every.append(sums)
    points = np.concatenate(every)
    return KDTree(np.stack([points.real, points.imag], axis=1))


def _listed(problem: ArrangementProblem, stop: Callable[[], bool]) -> IntArray | None:
    """Every arrangement (n, P) within the limits, where they can be listed; else None."""
    if problem.parts <= 62 and count_bound(problem) <= MAX_ENUMERATED:
        return _joined(problem, every_arrangement(problem))
    whole = slots_of(problem)
    if whole is None:
        return np.zeros((0, problem.places), dtype=np.int64)
    if not whole.size:
        return whole.fixed[None, :]
    if problem.max_moves is None:
        return None
    few = min(problem.max_moves + open_changes(whole).again, whole.open_places)
    if few > LISTED_MOVES or listed_changes(whole, few) > MAX_ENUMERATED:
        return None
    axes = axes_of(whole, None, FAR)

    def changed() -> Iterator[IntArray]:
        for number in range(few + 1):
            for found in few_changes(whole, axes, number, [FAR]):
                rows = whole.arrangements(found)
                yield rows[within_limits(problem, rows)]
                if stop():
                    return

    rows = _joined(problem, changed())
    return None if stop() else rows


def _joined(problem: ArrangementProblem, some: Iterator[IntArray]) -> IntArray:
    return np.concatenate([np.zeros((0, problem.places), dtype=np.int64), *some])


def _guessed(problem: ArrangementProblem, seed: int, stop: Callable[[], bool]) -> IntArray:
    """Good arrangements (n, P) without masses: the present one and those that a search comes by."""
    rows: list[IntArray] = []
    present = problem.present
    if within_limits(problem, present[None, :])[0] and ((present >= 0) | problem.may_be_empty).all():
        rows.append(present)
    for number, state in enumerate(search_best(problem, np.random.default_rng(seed))):
        if state.arrangement is not None and not any(state.arrangement is row for row in rows):
            rows.append(state.arrangement)
        if number >= GUESSES or stop():
            break
    found = np.array(rows, dtype=np.int64).reshape(len(rows), problem.places)
    return found[np.argsort(values(problem, found))] if len(found) else found
