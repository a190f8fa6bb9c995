"""Exact search with a certificate: levels of the objective, each searched completely before the next.

For a level z, everything better than z lies in an ellipsoid around the continuous optimum (`region`). Its shadow on
each plane is listed by meeting in the middle (`sums`), the lists are combined (`joint`), and what the box can supply is
rated. After that no selection is better than both z and the best found. Levels grow until they meet the best.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from service.balancing.checks import validate
from service.balancing.joint import Joint, PlaneList, combine, in_the_box
from service.balancing.objectives import evaluate
from service.balancing.placements import Selection, result_of, slots, vectors_of
from service.balancing.region import Bounds, Ellipsoid, bounds_of, ellipsoid
from service.balancing.selection import Piece, SelectionProblem, SelectionResult, Status
from service.balancing.sums import Halves, Placements, Sums, halves_of, near, placements_of

Stop = Callable[[], bool]

LARGEST_HALF = 5_000_000
"""Halves that one plane may list: 200 MB."""
LARGEST_LIST = 1_000_000
"""Selections of one plane that one level may list; beyond that the search ends with what is proved."""
STEP = 2.0
"""Growth of the level over the continuous bound from one level to the next."""
EXPECTED = 4.0
"""Joint selections that the first level is sized to hold."""
TIE = 1e-9
"""Relative difference below which two values are one."""


@dataclass(frozen=True)
class ExactState:
    """After one step: best selection so far, its value, and a bound that no selection is below."""

    selection: Selection
    value: float
    lower_bound: float
    evaluations: int
    proved: bool = False
    exhausted: bool = False


class _Search:
    """What the steps of one search share."""

    def __init__(self, problem: SelectionProblem, start: Selection | None, most: int | None) -> None:
        validate(problem)
        self._planes = len(problem.planes)
        self._open = [p for p, plane in enumerate(problem.planes) if slots(plane, problem.stock) > 0]
        self.problem = _only(problem, self._open)
        self.most = most
        self.selection: Selection = tuple(start[p] if start is not None else () for p in self._open)
        self.value = self._value()
        self.floor = 0.0
        self.evaluations = 0

    @cached_property
    def bounds(self) -> Bounds:
        """Bounds of the problem, which needs an open plane."""
        return bounds_of(self.problem)

    def state(self, *, proved: bool = False, exhausted: bool = False) -> ExactState:
        """Snapshot."""
        bound = self.value if proved else min(self.floor, self.value)
        whole: list[tuple[Piece, ...]] = [()] * self._planes
        for p, pieces in zip(self._open, self.selection, strict=True):
            whole[p] = pieces
        return ExactState(tuple(whole), self.value, bound, self.evaluations, proved, exhausted)

    def _value(self) -> float:
        return float(evaluate(self.problem.objective, vectors_of(self.problem, self.selection)))

    def rate(self, joint: Joint, lists: list[PlaneList], sums: list[Sums], placements: list[Placements]) -> None:
        """Take the best choice of `joint` that the box can supply, where it is better than the best so far."""
        values = evaluate(self.problem.objective, joint.vectors)
        self.evaluations += len(values)
        better = np.flatnonzero(values < self.value * (1.0 - TIE))
        if not better.size:
            return
        better = better[np.argsort(values[better], kind="stable")]
        fits = np.flatnonzero(in_the_box(lists, joint.rows[better], self.problem.stock.counts, self.most))
        if fits.size:
            row = joint.rows[better[fits[0]]]
            self.selection = tuple(
                placed.pieces(chosen.index[i]) for placed, chosen, i in zip(placements, sums, row, strict=True)
            )
            self.value = self._value()


def _only(problem: SelectionProblem, planes: list[int]) -> SelectionProblem:
    """Leave only some planes, the fixed vectors of the others moved into the offset."""
    objective = problem.objective
    others = [p for p in range(len(problem.planes)) if p not in planes]
    fixed = np.array([problem.planes[p].fixed for p in others], dtype=np.complex128)
    return replace(
        problem,
        objective=replace(
            objective, matrix=objective.matrix[:, planes], offset=objective.offset + objective.matrix[:, others] @ fixed
        ),
        planes=tuple(problem.planes[p] for p in planes),
    )


def search_exact(
    problem: SelectionProblem, *, start: Selection | None = None, most_pieces: int | None = None
) -> Iterator[ExactState]:
    """Return an iterator of states, ending when the optimum is proved or the search is `exhausted`: too much memory.

    start: a selection known to be allowed. most_pieces: at most so many in all planes together. A step takes some ten
    milliseconds; the caller stops by leaving. Raises NumericsError for an invalid problem.
    """
    search = _Search(problem, start, most_pieces)
    if not search.problem.planes or most_pieces == 0:
        yield search.state(proved=True)
        return
    search.floor = search.bounds.floor
    yield search.state()
    ladder = [4] if max(_pieces(search.problem, most_pieces)) > 4 else []
    for most in [*ladder, None]:
        last = most is None
        for state in _levels(search, most, prove=last):
            yield state
            if state.proved or state.exhausted:
                return


def _pieces(problem: SelectionProblem, most: int | None) -> list[int]:
    return [placements_of(plane, problem.stock, most).most for plane in problem.planes]


def _levels(search: _Search, most_per_plane: int | None, *, prove: bool) -> Iterator[ExactState]:
    """Levels of one rung: at most so many pieces a plane; only the last rung may prove."""
    problem = search.problem
    limits = [m for m in (most_per_plane, search.most) if m is not None]
    placements = [placements_of(plane, problem.stock, min(limits, default=None)) for plane in problem.planes]
    halves: list[Halves] = []
    for p, placed in enumerate(placements):
        same = next((q for q in range(p) if _alike(problem, p, q)), None)
        if same is not None:
            halves.append(halves[same])
            continue
        building = halves_of(placed, LARGEST_HALF)
        while True:
            try:
                next(building)
            except StopIteration as done:
                halves.append(done.value)
                break
            yield search.state()
    complete = prove and all(h.complete for h in halves)
    level = _first_level(search, halves)
    floor = search.bounds.floor
    while True:
        level = min(level, search.value)
        region = ellipsoid(search.bounds, level)
        if region is not None and not (yield from _search_level(search, halves, placements, region)):
            yield search.state(exhausted=prove)
            return
        reached = search.value <= level * (1.0 + TIE)
        if complete:
            search.floor = max(search.floor, min(level, search.value))
        yield search.state(proved=complete and reached, exhausted=prove and reached and not complete)
        if reached:
            return
        level = floor + STEP * (level - floor)


def _search_level(
    search: _Search, halves: list[Halves], placements: list[Placements], region: Ellipsoid
) -> Generator[ExactState, None, bool]:
    """Search one ellipsoid completely; False where its lists grow too long."""
    inverse = np.linalg.inv(region.form)
    sums: list[Sums] = []
    for p, (half, plane) in enumerate(zip(halves, search.problem.planes, strict=True)):
        shadow = np.linalg.cholesky(np.linalg.inv(inverse[2 * p : 2 * p + 2, 2 * p : 2 * p + 2])).T
        x, y = shadow[:, 0], shadow[:, 1]
        along, across = complex(x[0], x[1]), complex(y[0], y[1])
        shape = (along - 1j * across) / 2.0, (along + 1j * across) / 2.0
        centre = complex(region.centre[2 * p], region.centre[2 * p + 1]) - plane.fixed
        found: list[Sums] = []
        total = 0
        for part in near(half, centre, shape, 1.0 + TIE):
            found.append(part)
            total += len(part)
            if total > LARGEST_LIST:
                return False
            yield search.state()
        some = [part for part in found if len(part)] or [Sums(np.empty((0, 1), np.int64), np.empty(0, complex))]
        sums.append(Sums(np.concatenate([s.index for s in some]), np.concatenate([s.vector for s in some])))
    lists = [
        PlaneList.of(chosen, placed.item, plane.fixed)
        for chosen, placed, plane in zip(sums, placements, search.problem.planes, strict=True)
    ]
    if all(len(chosen) for chosen in sums):
        for joint in combine(lists, region):
            search.rate(joint, lists, sums, placements)
            yield search.state()
    return True


def _first_level(search: _Search, halves: list[Halves]) -> float:
    """Level whose ellipsoid should hold a few joint selections, from the density of sums at the continuous optimum."""
    bounds = search.bounds
    density = 0.0
    for half, u, plane in zip(halves, bounds.continuous, search.problem.planes, strict=True):
        density += math.log(max(_density(half, u - plane.fixed), 1e-9))
    low, high = bounds.floor, max(search.value, bounds.floor)
    for _ in range(24):
        middle = low + 0.5 * (high - low) if low > bounds.floor else bounds.floor + (high - bounds.floor) / 4.0
        region = ellipsoid(bounds, middle)
        if region is None or density + _log_volume(region) < math.log(EXPECTED):
            low = middle
        else:
            high = middle
        if low > bounds.floor and high - bounds.floor < 1.5 * (low - bounds.floor):
            break
    return high


def _density(half: Halves, centre: complex) -> float:
    """Estimate selections per g^2 near `centre`, the sums taken as normally distributed."""
    parts = [half.first.vector, half.second.vector]
    mean = sum(complex(v.mean()) for v in parts)
    spread = sum(float(v.real.var() + v.imag.var()) / 2.0 for v in parts) + 1e-6
    return half.selections / (2.0 * math.pi * spread) * math.exp(-min(abs(centre - mean) ** 2 / (2.0 * spread), 12.0))


def _log_volume(region: Ellipsoid) -> float:
    n = len(region.centre)
    return n / 2.0 * math.log(math.pi) - math.lgamma(n / 2.0 + 1.0) - 0.5 * float(np.linalg.slogdet(region.form)[1])


def _alike(problem: SelectionProblem, p: int, q: int) -> bool:
    """Whether two planes have the same positions and limits, so that they share their halves."""
    one, other = problem.planes[p], problem.planes[q]
    same: Sequence[bool] = [
        np.array_equal(one.angles, other.angles),
        np.array_equal(one.capacity, other.capacity),
        np.array_equal(one.capacity_g, other.capacity_g),
        one.max_pieces == other.max_pieces,
        one.max_mass_g == other.max_mass_g,
    ]
    return all(same)


def solve_exact(
    problem: SelectionProblem,
    *,
    start: Selection | None = None,
    most_pieces: int | None = None,
    uncertainty: float = 0.0,
    stop: Stop = lambda: False,
) -> SelectionResult:
    """Best selection with a proven lower bound; status says how it ended.

    `optimal`: proved. `within_uncertainty`: nothing can be better by more than `uncertainty` (objective's unit), which
    the measurement cannot tell. `limit_reached`: stopped by `stop()` or by memory; value and bound still hold.
    """
    state: ExactState | None = None
    for state in search_exact(problem, start=start, most_pieces=most_pieces):
        if state.proved or state.value - state.lower_bound <= uncertainty or stop():
            break
    if state is None:  # pragma: no cover - the search always yields
        raise AssertionError
    status, message = ending(state, uncertainty)
    return result_of(problem, state.selection, status, message, state.evaluations, state.lower_bound)


def ending(state: ExactState, uncertainty: float) -> tuple[Status, str]:
    """Status and message of a search that ended in `state`."""
    gap = state.value - state.lower_bound
    if state.proved or gap <= 0.0:
        return "optimal", "proved: no selection within the limits is better"
    if gap <= uncertainty:
        return "within_uncertainty", f"nothing can be better by more than {gap:.3g}, less than can be measured"
    how = "the search grew too large" if state.exhausted else "stopped before the proof"
    return "limit_reached", f"{how}: a better selection by up to {gap:.3g} is not excluded"
