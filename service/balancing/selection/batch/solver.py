"""The best selection of each of many problems over the same planes and box, proved.

For a level, an ellipsoid holds everything better (`regions`). The rows of each plane in its shadow are read off the
table, every pair (triple, ..) of them is rated, and what the box cannot supply is left out. A problem whose best is
below its level is proved; the others go on with a higher level. What does not fit this way is left to the exact search.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.batch.regions import Ellipsoids, Objectives, Systems, ellipsoids, systems_of
from service.balancing.selection.batch.tables import PlaneRows, Shared
from service.balancing.selection.compiled import NORMS, loops
from service.balancing.selection.exact.incumbents import TIE
from service.balancing.selection.exact.plane_table import Reading
from service.balancing.selection.exact.search import Stop, never, solve_exact
from service.balancing.selection.placements import Selection
from service.balancing.selection.problem import BoolArray, Objective, SelectionPlane, SelectionProblem

TOGETHER = 2_000
"""Problems solved together: what they list fits a processor's cache."""
FIRST_STEP, STEP = 1.3, 1.7
"""First level over the values of the problems before, and growth of the level of those that are not proved."""
QUANTILE = 0.7
"""Part of the problems whose first level should be high enough."""
MAX_ROUNDS = 12
MAX_LISTED = 4_000_000
"""Rows and joint selections listed at a time."""
MAX_LOOKED_AT = 50_000
"""Rows of one plane that are looked at for one problem."""
MAX_EACH = 200_000
"""Joint selections of one problem; the exact search is better at more."""


@dataclass(frozen=True)
class Answers:
    """Best selection of each problem: value (D,), vectors (D, P) in g, proved (D,), and its pieces."""

    value: FloatArray
    vectors: ComplexArray
    proved: BoolArray
    rows: IntArray
    others: dict[int, Selection]
    shared: Shared

    def selection(self, number: int) -> Selection:
        """Pieces of one problem's best selection."""
        return self.others[number] if number in self.others else self.shared.selection(self.rows[number])

    def key(self, number: int) -> tuple[int, ...] | Selection:
        """What two problems with the same selection share."""
        return self.others.get(number) or tuple(self.rows[number].tolist())


def solve_batch(
    shared: Shared,
    planes: tuple[SelectionPlane, ...],
    objectives: Objectives,
    *,
    stop: Stop = never,
) -> Answers:
    """Solve every problem; those whose rows tell too little apart go through the exact search one by one."""
    found = _Found(shared, planes, objectives)
    guess: float | None = None
    for cut in range(0, len(objectives), TOGETHER):
        which = np.arange(cut, min(cut + TOGETHER, len(objectives)))
        guess = found.solve(which, guess, stop)
    return Answers(found.value, found.vectors, found.proved, found.rows, found.others, shared)


class _Found:
    """Answers as they come."""

    def __init__(self, shared: Shared, planes: tuple[SelectionPlane, ...], objectives: Objectives) -> None:
        count = len(objectives)
        self.shared, self.planes, self.objectives = shared, planes, objectives
        self.value = np.full(count, np.inf)
        self.vectors = np.zeros((count, len(planes)), dtype=np.complex128)
        self.proved = np.zeros(count, dtype=np.bool_)
        self.rows = np.zeros((count, len(planes)), dtype=np.int64)
        self.others: dict[int, Selection] = {}

    def solve(self, which: IntArray, guess: float | None, stop: Stop) -> float:
        """Solve some of the problems; what the next first level may be."""
        objectives = self.objectives.taken(which)
        systems = systems_of(objectives)
        if guess is None:
            self._alone(int(which[0]), stop)
            guess = self.value[which[0]] - float(systems.floor[0])
        above = np.full(len(which), max(FIRST_STEP * guess, 1e-12))
        self._compiled(which, objectives, systems, float(above[0]))
        left = np.flatnonzero(systems.solvable & ~self.proved[which])
        for _ in range(MAX_ROUNDS):
            if not len(left) or stop():
                break
            some = systems.taken(left)
            level = np.minimum(some.floor + above[left], self.value[which[left]] * (1.0 + 2.0 * TIE))
            region = ellipsoids(some, level)
            too_many = self._round(which[left], objectives.taken(left), region)
            done = self.value[which[left]] <= level
            self.proved[which[left[done]]] = True
            above[left] *= STEP
            left = left[~done & ~too_many]
        for number in which[~self.proved[which]].tolist():
            self._alone(number, stop)
        return float(np.quantile(self.value[which] - systems.floor, QUANTILE)) / FIRST_STEP + 1e-300

    def _compiled(self, which: IntArray, objectives: Objectives, systems: Systems, level: float) -> None:
        """Solve square problems of two planes by the compiled loop, where it is loaded."""
        compiled, square = loops(), systems.dual is None
        if compiled is None or not square or len(self.planes) != 2 or not systems.solvable.all():
            return
        region = ellipsoids(systems, np.ones(len(which)))
        spread = np.linalg.inv(region.form)
        grids, planes = [], []
        for plane in self.shared.planes:
            table = plane.table
            grids.append((table.vector, table.start, table.low, table.width, table.columns, table.rows))
            planes.append((table.vector, complex(plane.fixed), plane.items, plane.order))
        fixed = np.array([plane.fixed for plane in self.shared.planes])
        value, rows, proved = compiled.pairs(
            objectives.matrix,
            objectives.offset,
            objectives.weights,
            NORMS[objectives.norm],
            region.centre[:, 0::2] + 1j * region.centre[:, 1::2] - fixed,
            np.sqrt(np.stack([spread[:, 2 * p, 2 * p] for p in range(2)], axis=1)),
            level,
            STEP,
            MAX_ROUNDS,
            grids[0],
            planes[0],
            grids[1],
            planes[1],
            np.append(self.shared.stock.counts, np.iinfo(np.int64).max),
            self.shared.stock_binds,
        )
        done = which[proved]
        self.value[done], self.rows[done], self.proved[done] = value[proved], rows[proved], True
        self.vectors[done] = np.stack([p.sums[rows[proved, i]] for i, p in enumerate(self.shared.planes)], axis=1)
        for number in set(done.tolist()) & set(self.others):
            self.others.pop(number)

    def _alone(self, number: int, stop: Stop) -> None:
        """Solve one problem by the exact search."""
        one = self.objectives
        objective = Objective(one.matrix[number], one.offset[number], one.weights, one.norm)
        result = solve_exact(SelectionProblem(objective, self.planes, self.shared.stock), stop=stop)
        self.value[number], self.vectors[number] = result.value, result.vectors
        self.others[number] = result.pieces or tuple(() for _ in self.planes)
        self.proved[number] = result.status == "optimal"

    def _round(self, numbers: IntArray, objectives: Objectives, region: Ellipsoids) -> BoolArray:
        """Rate everything in the regions, and keep the best; (n,) which problems have too much in theirs."""
        lists = [_listed(plane, region, p) for p, plane in enumerate(self.shared.planes)]
        many = np.prod([listed.counts.astype(np.float64) for listed in lists], axis=0)
        too_many = np.asarray((many > MAX_EACH) | np.any([listed.too_many for listed in lists], axis=0))
        many[too_many | ~region.some] = 0.0
        ends = np.cumsum(many)
        start = 0
        while start < len(many):
            done = ends[start - 1] if start else 0.0
            stop = max(int(np.searchsorted(ends, done + MAX_LISTED, side="right")), start + 1)
            self._rate(numbers, objectives, lists, start + np.flatnonzero(many[start:stop]))
            start = stop
        return too_many

    def _rate(self, numbers: IntArray, objectives: Objectives, lists: list[_Listed], chosen: IntArray) -> None:
        """Rate every joint selection of the chosen problems, and keep the best that the box can supply."""
        whose, rows = _joined(lists, chosen)
        if not len(whose):
            return
        planes = self.shared.planes
        u = np.stack([plane.sums[rows[:, p]] for p, plane in enumerate(planes)], axis=1)
        values = objectives.values(whose, u)
        good = np.flatnonzero(values <= self.value[numbers[whose]] * (1.0 + 2.0 * TIE))
        if self.shared.stock_binds:
            good = good[_in_the_box(self.shared, rows[good])]
        if not len(good):
            return
        whose, rows, u, values = whose[good], rows[good], u[good], values[good]
        best = np.full(len(numbers), np.inf)
        np.minimum.at(best, whose, values)
        level = np.flatnonzero(values <= best[whose] * (1.0 + TIE))
        order = level[np.lexsort((*_preference(planes, rows[level]), whose[level]))]
        first = order[np.flatnonzero(np.diff(whose[order], prepend=-1))]
        found = numbers[whose[first]]
        self.value[found], self.vectors[found], self.rows[found] = values[first], u[first], rows[first]
        for number in found.tolist():
            self.others.pop(number, None)


@dataclass(frozen=True)
class _Listed:
    """Rows of one plane within each problem's region: counts (D,), and where they begin (D,) in rows.

    away: (n, 2) of each row from the centre. form: (D, 2 p + 2, 2 p + 2) of the region's shadow on the planes so far.
    """

    rows: IntArray
    away: FloatArray
    counts: IntArray
    begins: IntArray
    too_many: BoolArray
    form: FloatArray


def _joined(lists: list[_Listed], chosen: IntArray) -> tuple[IntArray, IntArray]:
    """Problem (n,) and rows (n, P) of every joint selection within the regions of the chosen problems."""
    whose, rows = chosen, np.empty((len(chosen), 0), dtype=np.int64)
    away = np.empty((len(chosen), 0))
    for listed in lists:
        counts = listed.counts[whose]
        at = np.repeat(np.arange(len(whose)), counts)
        step = np.arange(len(at)) - np.repeat(np.cumsum(counts) - counts, counts)
        entry = listed.begins[whose[at]] + step
        form = listed.form[whose]
        mine, cross = form[:, -2:, -2:], 2.0 * np.einsum("nij,nj->ni", form[:, -2:, :-2], away)
        own = np.einsum("ni,nij,nj->n", away, form[:, :-2, :-2], away)
        x, y = listed.away[entry, 0], listed.away[entry, 1]
        size = own[at] + cross[at, 0] * x + cross[at, 1] * y
        size += mine[at, 0, 0] * x * x + 2.0 * mine[at, 0, 1] * x * y + mine[at, 1, 1] * y * y
        inside = np.flatnonzero(size <= 1.0 + TIE)
        at, entry = at[inside], entry[inside]
        whose, rows = whose[at], np.concatenate([rows[at], listed.rows[entry][:, None]], axis=1)
        away = np.concatenate([away[at], listed.away[entry]], axis=1)
    return whose, rows


def _listed(plane: PlaneRows, region: Ellipsoids, p: int) -> _Listed:
    own = slice(2 * p, 2 * p + 2)
    whole = np.linalg.inv(region.form)
    spread = whole[:, own, own] * (1.0 + TIE)
    form = np.linalg.inv(spread)
    table = plane.table
    wanted = region.centre[:, 2 * p] + 1j * region.centre[:, 2 * p + 1] - plane.fixed
    reading = Reading(
        half_x=np.sqrt(spread[:, 0, 0]) * (1.0 + 1e-9) + table.margin,
        slope=spread[:, 0, 1] / spread[:, 0, 0],
        half_y=1.0 / np.sqrt(form[:, 1, 1]) * (1.0 + 1e-9) + table.margin,
    )
    whose, begin, end = table.windows(wanted, reading)
    looked_at = np.bincount(whose, weights=end - begin, minlength=len(wanted))
    too_many = looked_at > MAX_LOOKED_AT
    kept = ~too_many[whose]
    whose, begin, many = whose[kept], begin[kept], (end - begin)[kept]
    at = np.repeat(np.arange(len(whose)), many)
    row = begin[at] + np.arange(len(at)) - np.repeat(np.cumsum(many) - many, many)
    problem = whose[at]
    away = table.vector[row] - wanted[problem]
    f = form[problem]
    inside = f[:, 0, 0] * away.real**2 + 2.0 * f[:, 0, 1] * away.real * away.imag + f[:, 1, 1] * away.imag**2 <= 1.0
    counts = np.bincount(problem[inside], minlength=len(wanted))
    kept_away = np.stack([away.real[inside], away.imag[inside]], axis=1)
    shadow = np.linalg.inv(whole[:, : 2 * p + 2, : 2 * p + 2])
    return _Listed(row[inside], kept_away, counts, np.cumsum(counts) - counts, np.asarray(too_many), shadow)


def _in_the_box(shared: Shared, rows: IntArray) -> BoolArray:
    """Which joint selections (n, P) the box can supply."""
    items = np.concatenate([plane.items[rows[:, p]] for p, plane in enumerate(shared.planes)], axis=1)
    limits = np.append(shared.stock.counts, np.iinfo(np.int64).max)
    fits = np.ones(len(items), dtype=bool)
    for j in range(items.shape[1]):
        fits &= (items == items[:, j : j + 1]).sum(axis=1) <= limits[items[:, j]]
    return fits


def _preference(planes: tuple[PlaneRows, ...], rows: IntArray) -> list[FloatArray | IntArray]:
    """Keys of `np.lexsort`, least important first: the pieces themselves, scarcity, mass, pieces."""
    total = [
        np.sum([getattr(plane, name)[rows[:, p]] for p, plane in enumerate(planes)], axis=0)
        for name in ("scarcity", "mass_g", "pieces")
    ]
    ranks = [plane.rank[rows[:, p]] for p, plane in enumerate(planes)]
    return [*reversed(ranks), np.round(total[0], 12), np.round(total[1], 9), total[2]]
