"""Exact search with a certificate: levels of the objective, each searched completely before the next.

For a level z, everything better than z lies in an ellipsoid around the continuous optimum (`region`). Its shadow on
each plane is listed by meeting in the middle (`sums`), the lists are combined (`joint`), and what the box can supply
is rated. After that no selection is better than both z and the best found. Levels grow until they meet the best.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import TypeVar, cast

import numpy as np

from service.balancing.selection.exact.bounds import Bounds, bounding, bounds_of
from service.balancing.selection.exact.incumbents import TIE, Entry, Record
from service.balancing.selection.exact.initial_cutoff import first_level
from service.balancing.selection.exact.level_ellipsoid import Ellipsoid, ellipsoid
from service.balancing.selection.exact.local_search import descend
from service.balancing.selection.exact.meet_in_middle import Halves, Sums, halves_of, near, placements_of
from service.balancing.selection.exact.plane_join import PlaneList, combine, combine_up_to
from service.balancing.selection.exact.presolve import Opened, opened
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, effective_g, result_of, slots, vectors_of
from service.balancing.selection.problem import UNLIMITED, SelectionProblem, SelectionResult, Status
from service.balancing.selection.validation import validate

Stop = Callable[[], bool]
Made = TypeVar("Made")

LARGEST_HALF = 5_000_000
"""Halves that one plane may list: 200 MB."""
MOST_PAIRS = 300_000
"""Pairs of position and stock item of a plane that are listed; of a longer box only some items are searched."""
LARGEST_LIST = 1_000_000
"""Selections of one plane that one level may list; beyond that the search ends with what is proved."""
FEW = 4
"""Pieces a plane that are searched first where more are allowed: they take little time and are hard to beat."""
PATIENCE = 2
"""Levels without a proof before the best selection so far is improved by single changes."""
CAUTION = 0.125
"""Part of the way from the bound to the best so far that the first level goes where densities are hard to guess."""
LEAST_STEP = 1e-6
"""Least height of the second level over the bound, as a part of the greatest value there is."""
QUICK_LIST, QUICK_RATED = 100_000, 1_000_000
"""Selections of one plane, and of all, that a level may look at where it only looks for a better selection."""
RATED_CELLS = 600_000
"""Residuals that are computed between two stops."""
AT_ONCE = 1e5
"""Joint selections that are looked at in one level."""
STEP = 2.0
"""Growth of the level over the continuous bound from one level to the next."""


@dataclass(frozen=True)
class ExactState:
    """After one step: best selections so far, best first, their values, and a bound that no selection is below.

    proved: nothing better is left, for each of them. exhausted: the search ended without proof, for want of memory.
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


class _Search:
    """What the steps of one search share."""

    def __init__(
        self, whole: Opened, scale: float, start: Selection | None, most: int | None, keep: int, good_enough: float
    ) -> None:
        self.whole = whole
        self.problem = whole.problem
        self.most = most
        self.evaluations = 0
        empty: Selection = tuple(() for _ in self.problem.planes)
        self.record = Record(keep, max(scale, self._value(empty)), good_enough)
        self.values_count = good_enough <= 0.0
        self.offer(empty)
        if start is not None:
            self.offer(whole.narrow(start))
        self.floor = 0.0
        self._told: tuple[list[Entry], tuple[Selection, ...], tuple[float, ...]] = ([], (), ())

    def state(self, *, proved: bool = False, exhausted: bool = False) -> ExactState:
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
            exhausted=exhausted,
        )

    def _value(self, selection: Selection) -> float:
        return float(evaluate(self.problem.objective, vectors_of(self.problem, selection)))

    def offer(self, selection: Selection) -> None:
        """Rate one selection of the open planes."""
        mass = effective_g(self.problem.stock)
        items = [piece.item for pieces in selection for piece in pieces]
        scarcity = float((1.0 / self.problem.stock.counts[items]).sum())
        self.record.offer(selection, self._value(selection), len(items), float(mass[items].sum()), scarcity)


def search_exact(
    problem: SelectionProblem,
    *,
    start: Selection | None = None,
    most_pieces: int | None = None,
    keep: int = 1,
    good_enough: float = 0.0,
    bounds: Bounds | None = None,
) -> Iterator[ExactState]:
    """Return an iterator of states, ending when the optimum is proved or the search is `exhausted`: too much memory.

    start: a selection known to be allowed. most_pieces: at most so many in all planes together. keep: how many best
    selections. good_enough: values up to it are equal, and fewest pieces, least mass, commonest stock decide; without
    it they decide among values equal to nine digits. bounds: from `bounds_for`, where several searches of one problem
    follow each other. A step takes some ten milliseconds; the caller stops by leaving.
    Raises NumericsError for an invalid problem.
    """
    validate(problem)
    whole = opened(problem)
    if not whole.problem.planes or most_pieces == 0:
        yield _Search(whole, 0.0, None, most_pieces, keep, good_enough).state(proved=True)
        return
    if bounds is None:
        known = partial(_Search, whole, 0.0, start, most_pieces, keep, good_enough)
        bounds = yield from _meanwhile(lambda: known().state(), bounding(whole.problem))
    whole = whole.thinned(MOST_PAIRS, start)
    search = _Search(whole, bounds.unit, start, most_pieces, keep, good_enough)
    search.floor = bounds.floor
    yield search.state()
    if bounds.dual is not None:
        yield from _descend(search)
    most = max(min(slots(p, search.problem.stock), most_pieces or UNLIMITED) for p in search.problem.planes)
    quick = most > FEW and (yield from _levels(search, bounds, FEW))
    if (yield from _levels(search, bounds, None)):
        return
    for fewer in range(min(most, FEW) - 1, 0, -1):
        if quick or (yield from _levels(search, bounds, fewer)):
            break
    yield search.state(exhausted=True)


def bounds_for(problem: SelectionProblem) -> Bounds | None:
    """What every search of a valid problem begins with; None where no plane takes a mass."""
    whole = opened(problem).problem
    return bounds_of(whole) if whole.planes else None


def _levels(search: _Search, bounds: Bounds, rung: int | None) -> Generator[ExactState, None, bool]:
    """Search at most `rung` pieces a plane, level by level; True where it could be finished.

    Only the search of everything (None) proves, and only where its halves are complete.
    """
    halves = yield from _halves(search, rung)
    complete = rung is None and search.whole.items is None and all(h.complete for h in halves)
    ceiling = bounds.unit
    highest = min(search.record.cap, ceiling)
    if math.prod(half.selections for half in halves) <= AT_ONCE:
        level = highest
    else:
        level = yield from _meanwhile(search.state, first_level(bounds, halves, highest))
        if bounds.dual is not None:
            level = min(level, bounds.floor + CAUTION * (highest - bounds.floor))
    for number in count():
        if number == PATIENCE and bounds.dual is None:
            yield from _descend(search)
        level = min(level, search.record.cap * (1.0 + 2.0 * TIE), ceiling)
        region = ellipsoid(bounds, level)
        if region is not None and not (yield from _search_level(search, halves, region, quick=rung is not None)):
            return False
        reached = search.record.cap <= level or level >= ceiling
        if complete and search.values_count:
            search.floor = max(search.floor, min(level, search.record.entries[0].value))
        yield search.state(proved=complete and reached)
        if reached:
            return complete or rung is not None
        level = bounds.floor + max(STEP * (level - bounds.floor), LEAST_STEP * (ceiling - bounds.floor))
    return False  # pragma: no cover - the levels end by themselves


def _descend(search: _Search) -> Iterator[ExactState]:
    """Improve the best selection by single changes: a level that meets it ends the search."""
    placements = [placements_of(plane, search.problem.stock, search.most) for plane in search.problem.planes]
    for better in descend(search.problem, placements, search.record.entries[0].selection, search.most):
        if better is not None:
            search.offer(better)
        yield search.state()


def _halves(search: _Search, rung: int | None) -> Generator[ExactState, None, list[Halves]]:
    """Halves of every plane; planes with the same positions and limits share theirs."""
    problem = search.problem
    limits = [m for m in (rung, search.most) if m is not None]
    halves: list[Halves] = []
    for p, plane in enumerate(problem.planes):
        same = next((q for q in range(p) if search.whole.alike(p, q)), None)
        if same is not None:
            halves.append(halves[same])
            continue
        building = halves_of(placements_of(plane, problem.stock, min(limits, default=None)), LARGEST_HALF)
        halves.append((yield from _meanwhile(search.state, building)))
    return halves


def _meanwhile(
    state: Callable[[], ExactState], steps: Generator[None, None, Made]
) -> Generator[ExactState, None, Made]:
    """Result of `steps` that find no selection: the state stays as it is between them."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return cast(Made, done.value)
        yield state()


def _search_level(
    search: _Search, halves: list[Halves], region: Ellipsoid, *, quick: bool
) -> Generator[ExactState, None, bool]:
    """Search one ellipsoid completely; False where its lists grow too long, or `quick` takes too long."""
    longest, rated = (QUICK_LIST, QUICK_RATED) if quick else (LARGEST_LIST, math.inf)
    spent = 0
    lists: list[PlaneList] = []
    for p, (half, plane) in enumerate(zip(halves, search.problem.planes, strict=True)):
        centre, shape = _shadow(region, p)
        found: list[Sums] = []
        total = 0
        for part in near(half, centre - plane.fixed, shape, 1.0 + TIE):
            found += [part] if len(part) else []
            total += len(part)
            if total > longest:
                return False
            yield search.state()
        if not found:
            return True
        sums = Sums(np.concatenate([s.index for s in found]), np.concatenate([s.vector for s in found]))
        yield search.state()
        lists.append(PlaneList.of(sums, half.placements, plane.fixed))
    joints = combine(lists, region) if search.most is None else combine_up_to(lists, region, search.most)
    for joint in joints:
        values = np.empty(len(joint))
        chunk = RATED_CELLS // len(search.problem.objective.offset)
        for cut in range(0, len(joint), chunk):
            values[cut : cut + chunk] = evaluate(search.problem.objective, joint.vectors[cut : cut + chunk])
            if cut + chunk < len(joint):
                yield search.state()
        search.evaluations += len(values)
        spent += len(values)
        if spent > rated:
            return False
        search.record.rate(joint, values, search.problem.stock.counts)
        yield search.state()
    return True


def _shadow(region: Ellipsoid, p: int) -> tuple[complex, tuple[complex, complex]]:
    """Shadow of the ellipsoid on plane p: its centre, and the map T(z) = a z + b conj(z) that makes it a unit disc."""
    own = slice(2 * p, 2 * p + 2)
    turn = np.linalg.cholesky(np.linalg.inv(np.linalg.inv(region.form)[own, own])).T
    x, y = complex(turn[0, 0], turn[1, 0]), complex(turn[0, 1], turn[1, 1])
    return complex(*region.centre[own]), ((x - 1j * y) / 2.0, (x + 1j * y) / 2.0)


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
    states = search_exact(problem, start=start, most_pieces=most_pieces)
    state = last_state(states, lambda now: now.value - now.lower_bound <= uncertainty or stop())
    return exact_result(problem, state, uncertainty, limited=most_pieces is not None)


def last_state(states: Iterator[ExactState], enough: Callable[[ExactState], bool]) -> ExactState:
    """Advance a search until it ends or a state is `enough`, and return that state."""
    state = next(states)
    while not enough(state):
        following = next(states, None)
        if following is None:
            break
        state = following
    return state


def exact_result(
    problem: SelectionProblem, state: ExactState, uncertainty: float = 0.0, *, limited: bool = False
) -> SelectionResult:
    """Result of a search that ended in `state`; limited: it looked at selections of at most so many pieces only."""
    status, message = _ending(state, uncertainty, "of as few pieces" if limited else "within the limits")
    return result_of(problem, state.selection, status, message, state.evaluations, state.lower_bound)


def _ending(state: ExactState, uncertainty: float, among: str) -> tuple[Status, str]:
    """Status and sentence; `among` says which selections were looked at."""
    gap = state.value - state.lower_bound
    if state.proved or gap <= 0.0:
        return "optimal", f"proved: no selection {among} is better"
    if gap <= uncertainty:
        told = f"no selection {among} can be better by more than {gap:.3g}, less than can be measured"
        return "within_uncertainty", told
    how = "the search grew too large" if state.exhausted else "stopped before the proof"
    return "limit_reached", f"{how}: a selection {among} that is better by up to {gap:.3g} is not excluded"
