"""One rung of the exact search: all selections of at most this many pieces a plane, level by level.

For a level z, everything better than z lies in an ellipsoid around the continuous optimum (`level_ellipsoid`). The
selections of each plane in its shadow are listed (`meet_in_middle`), the lists are combined (`plane_join`), and what
the box can supply is rated. After that no selection of the rung is better than both z and the best found. Levels grow
until they meet the best.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from itertools import count
from typing import TypeVar, cast

import numpy as np

from service.balancing.selection.exact.bounds import Bounds
from service.balancing.selection.exact.incumbents import TIE, Entry, Incumbents
from service.balancing.selection.exact.initial_cutoff import first_level
from service.balancing.selection.exact.level_ellipsoid import Ellipsoid, ellipsoid
from service.balancing.selection.exact.local_search import descend
from service.balancing.selection.exact.meet_in_middle import Split, near, split_of
from service.balancing.selection.exact.plane_join import Ceiling, Joint, PlaneList, combine, combine_up_to
from service.balancing.selection.exact.plane_table import Ellipse, Table
from service.balancing.selection.exact.presolve import Reduced
from service.balancing.selection.exact.subsets import Sums, placements_of
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, effective_g, vectors_of

Made = TypeVar("Made")

LARGEST_LIST = 1_000_000
"""Selections of one plane that one level may list."""
PATIENCE = 2
"""Levels without a proof before the best selection so far is improved by single changes."""
CAUTION = 0.125
"""Part of the way from the bound to the best so far that the first level goes where densities are hard to guess."""
MIN_STEP = 1e-6
"""Least height of the second level over the bound, as a part of the greatest value there is."""
QUICK_LIST, QUICK_RATED = 100_000, 1_000_000
"""Selections of one plane, and of all, that a level may look at where it only looks for a better selection."""
QUICK_LOOKS = 700
"""Chunks that such a level may look through for each plane."""
RATED_CELLS = 600_000
"""Residuals that are computed between two stops."""
AT_ONCE = 1e5
"""Joint selections that are looked at in one level."""
STEP = 2.0
"""Growth of the level over the continuous bound from one level to the next."""


@dataclass(frozen=True)
class ExactState:
    """After one step: best selections so far, best first, their values, and a bound that no selection is below.

    proved: nothing better is left, for each of them. exhausted: the search cannot be completed within memory, and what
    it tries instead has not found anything better for a while.
    """

    selections: tuple[Selection, ...]
    values: tuple[float, ...]
    lower_bound: float
    evaluations: int
    proved: bool = False
    exhausted: bool = False

    @property
    def selection(self) -> Selection:
        """The best selection."""
        return self.selections[0]

    @property
    def value(self) -> float:
        """The best value."""
        return self.values[0]


class Search:
    """What the steps of one search share."""

    def __init__(
        self, whole: Reduced, scale: float, start: Selection | None, most: int | None, keep: int, good_enough: float
    ) -> None:
        self.whole = whole
        self.problem = whole.problem
        self.most = most
        self.keep = keep
        self.good_enough = good_enough
        self.evaluations = 0
        empty: Selection = tuple(() for _ in self.problem.planes)
        self.record = Incumbents(keep, max(scale, self._value(empty)), good_enough)
        self.values_count = good_enough <= 0.0
        self.offer(empty)
        if start is not None:
            self.offer(whole.narrow(start))
        self.floor = 0.0
        self.exhausted = False
        self.tables: dict[int, Table] = {}
        self._told: tuple[list[Entry], tuple[Selection, ...], tuple[float, ...]] = ([], (), ())

    def state(self, *, proved: bool = False) -> ExactState:
        """Snapshot."""
        found = self.record.entries
        if found is not self._told[0]:
            selections = tuple(self.whole.widen(entry.selection) for entry in found)
            self._told = found, selections, tuple(entry.value for entry in found)
        return ExactState(
            selections=self._told[1],
            values=self._told[2],
            lower_bound=found[0].value if proved and self.values_count else min(self.floor, found[0].value),
            evaluations=self.evaluations,
            proved=proved,
            exhausted=self.exhausted and not proved,
        )

    @property
    def best(self) -> Selection:
        """The best selection of the open planes."""
        return self.record.entries[0].selection

    def _value(self, selection: Selection) -> float:
        return float(evaluate(self.problem.objective, vectors_of(self.problem, selection)))

    def offer(self, selection: Selection) -> None:
        """Rate one selection of the open planes."""
        mass = effective_g(self.problem.stock)
        items = [piece.item for pieces in selection for piece in pieces]
        scarcity = float((1.0 / self.problem.stock.counts[items]).sum())
        self.record.offer(selection, self._value(selection), len(items), float(mass[items].sum()), scarcity)

    def raise_floor(self, bound: float) -> None:
        """Take a lower bound of every selection."""
        if self.values_count:
            self.floor = max(self.floor, min(bound, self.record.entries[0].value))


def levels(search: Search, bounds: Bounds, rung: int, *, last: bool) -> Generator[ExactState, None, bool]:
    """Search at most `rung` pieces a plane, level by level; True where it could be finished.

    last: no plane carries more, so that a finished search proves its best; the others only look for a better one.
    """
    splits = yield from _splits(search, rung)
    if splits is None:
        return False
    proves = last and search.whole.items is None
    ceiling = bounds.unit
    highest = min(search.record.cap, ceiling)
    if math.prod(split.selections for split in splits) <= AT_ONCE:
        level = highest
    else:
        level = yield from meanwhile(search.state, first_level(bounds, splits, highest))
        if bounds.dual is not None:
            level = min(level, bounds.floor + CAUTION * (highest - bounds.floor))
    for number in count():
        if number == PATIENCE and bounds.dual is None:
            yield from improve(search)
        level = min(level, search.record.cap * (1.0 + 2.0 * TIE), ceiling)
        region = ellipsoid(bounds, level)
        if region is not None:
            told = level if proves and bounds.dual is None else 0.0
            if not (
                yield from _search_level(search, splits, region, Ceiling.of(bounds, level), quick=not last, told=told)
            ):
                return False
        reached = search.record.cap <= level or level >= ceiling
        if proves:
            search.raise_floor(level)
        yield search.state(proved=proves and reached)
        if reached:
            return True
        level = bounds.floor + max(STEP * (level - bounds.floor), MIN_STEP * (ceiling - bounds.floor))
    return False  # pragma: no cover - the levels end by themselves


def improve(search: Search) -> Iterator[ExactState]:
    """Improve the best selection by single changes: a level that meets it ends the search."""
    placements = [placements_of(plane, search.problem.stock, search.most) for plane in search.problem.planes]
    for better in descend(search.problem, placements, search.best, search.most):
        if better is not None:
            search.offer(better)
        yield search.state()


def meanwhile(state: Callable[[], ExactState], steps: Generator[None, None, Made]) -> Generator[ExactState, None, Made]:
    """Result of `steps` that find no selection: the state stays as it is between them."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return cast(Made, done.value)
        yield state()


def _splits(search: Search, rung: int) -> Generator[ExactState, None, list[Split] | None]:
    """Splits of every plane; planes with the same positions and limits share theirs. None where one grows too long."""
    problem = search.problem
    most = rung if search.most is None else min(rung, search.most)
    splits: list[Split] = []
    for p, plane in enumerate(problem.planes):
        same = next((q for q in range(p) if search.whole.alike(p, q)), None)
        if same is not None:
            splits.append(splits[same])
            continue
        placements = placements_of(plane, problem.stock, most)
        known = search.tables.get(p)
        split = yield from meanwhile(search.state, split_of(placements, placements.most, known))
        if split is None:
            return None
        search.tables[p] = split.table
        splits.append(split)
    return splits


def _search_level(
    search: Search, splits: list[Split], region: Ellipsoid, ceiling: Ceiling, *, quick: bool, told: float
) -> Generator[ExactState, None, bool]:
    """Search one ellipsoid completely; False where its lists grow too long, or `quick` takes too long.

    told: level of the ellipsoid where distances from its centre are values: then the nearest selection of one plane
    bounds all of them before the others are listed.
    """
    lists: list[PlaneList] = []
    for p, (split, plane) in enumerate(zip(splits, search.problem.planes, strict=True)):
        ellipse = _shadow(region, p, plane.fixed)
        sums = yield from _listed(search, split, ellipse, quick=quick)
        if sums is None:
            return False
        if told > 0.0:
            nearest = float(ellipse.distance(sums.vector).min(initial=1.0))
            search.raise_floor(told * (1.0 - TIE) * nearest)
        yield search.state()
        if not len(sums):
            return True
        lists.append(PlaneList.of(sums, split.placements, plane.fixed))
    if search.most is None:
        joints = combine(lists, region, ceiling)
    else:
        joints = combine_up_to(lists, region, ceiling, search.most)
    most = search.evaluations + (QUICK_RATED if quick else math.inf)
    for joint in joints:
        yield from _rate(search, joint)
        if search.evaluations > most:
            return False
    return True


def _listed(search: Search, split: Split, ellipse: Ellipse, *, quick: bool) -> Generator[ExactState, None, Sums | None]:
    """Selections of one plane within the ellipse; None where they are too many."""
    longest, looks = (QUICK_LIST, QUICK_LOOKS) if quick else (LARGEST_LIST, math.inf)
    found = [Sums(np.empty((0, split.width), split.table.index.dtype), np.empty(0, np.complex128))]
    total = 0
    for look, part in enumerate(near(split, ellipse)):
        found += [part] if len(part) else []
        total += len(part)
        if total > longest or look > looks:
            return None
        yield search.state()
    return Sums(np.concatenate([s.index for s in found]), np.concatenate([s.vector for s in found]))


def _rate(search: Search, joint: Joint) -> Iterator[ExactState]:
    """Compute the values of some joint selections, and keep the best."""
    values = np.empty(len(joint))
    chunk = RATED_CELLS // len(search.problem.objective.offset)
    for cut in range(0, len(joint), chunk):
        values[cut : cut + chunk] = evaluate(search.problem.objective, joint.vectors[cut : cut + chunk])
        if cut + chunk < len(joint):
            yield search.state()
    search.evaluations += len(values)
    search.record.rate(joint, values, search.problem.stock.counts)
    yield search.state()


def _shadow(region: Ellipsoid, p: int, fixed: complex) -> Ellipse:
    """Shadow of the ellipsoid on plane p, of what is added to `fixed`."""
    own = slice(2 * p, 2 * p + 2)
    turn = np.linalg.cholesky(np.linalg.inv(np.linalg.inv(region.form)[own, own])).T
    return Ellipse(complex(*region.centre[own]) - fixed, np.asarray(turn, dtype=np.float64), 1.0 + TIE)
