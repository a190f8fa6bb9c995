"""Exact search with a certificate: rungs of ever more pieces a plane, the last of them complete.

Each rung (`rungs`) begins with the best selection of those before it, so that more pieces, more time and, as far as a
box can be searched at all, more masses never make the answer worse. Where no rung can be completed, parts of the
problem around the best selection (`neighbourhood`) are searched as long as the caller has time.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np

from service.balancing.selection.exact.bounds import Bounds, bounding, bounds_of
from service.balancing.selection.exact.meet_in_middle import cost_of
from service.balancing.selection.exact.neighbourhood import Neighbourhood, neighbourhood, thinned
from service.balancing.selection.exact.presolve import opened
from service.balancing.selection.exact.rungs import ExactState, Search, improve, levels, meanwhile
from service.balancing.selection.exact.subsets import placements_of
from service.balancing.selection.placements import Selection, broken_limit, effective_g, result_of, slots
from service.balancing.selection.problem import UNLIMITED, SelectionProblem, SelectionResult, Status
from service.balancing.selection.validation import validate
from service.messages import Message

__all__ = ["ExactState", "Stop", "bounds_for", "exact_result", "last_state", "never", "search_exact", "solve_exact"]

Stop = Callable[[], bool]


def never() -> bool:
    """Stop that never comes: a search then ends where it is proved or exhausted."""
    return False


MAX_PAIRS = 300_000
"""Pairs of position and stock item of a plane that are listed; of a longer box only some items are searched."""
FEW = 4
"""Pieces a plane that are searched first where more are allowed: they take little time and are hard to beat."""
MAX_ASKED = 2e7
"""Rests that a rung which proves nothing may ask for: a few seconds."""
MAX_ASKED_LAST = 2e9
"""Rests that the last rung may ask for: ten minutes."""
LONG = 250
"""Steps of the last rung before parts of the problem are searched in between: shorter searches need no help."""
EVERY = 16
"""Steps of the last rung for each step of a search in between."""
STEPS_A_PART = 150
"""Steps of the search of one part of the problem."""
STEPS_A_BOX = 1000
"""Steps of the search of a thinner box."""
FAR = 3.0
"""Masses heavier than this many times the greatest continuous correction are left out of the parts."""
IDLE = 20
"""Parts searched without finding anything better before they may carry one more piece a plane."""
STALLED = 40
"""Parts searched without finding anything better before the search calls itself exhausted."""


def search_exact(
    problem: SelectionProblem,
    *,
    start: Selection | None = None,
    most_pieces: int | None = None,
    keep: int = 1,
    good_enough: float = 0.0,
    bounds: Bounds | None = None,
) -> Iterator[ExactState]:
    """Return an iterator of states, ending when the optimum is proved; where it cannot be, it goes on improving.

    start: a selection known to be allowed. most_pieces: at most this many in all planes together. keep: how many best
    selections. good_enough: values up to it are equal, and fewest pieces, least mass, commonest stock decide; without
    it they decide among values equal to nine digits. bounds: from `bounds_for`, where several searches of one problem
    follow each other. A step takes some ten milliseconds; the caller stops by leaving, at the latest when a state is
    `exhausted` and there is no deadline to use up. Raises NumericsError for an invalid problem.
    """
    validate(problem)
    return _searched(problem, start, most_pieces, keep, good_enough, bounds, alone=True)


def _searched(
    problem: SelectionProblem,
    start: Selection | None,
    most_pieces: int | None,
    keep: int,
    good_enough: float,
    bounds: Bounds | None,
    *,
    alone: bool,
) -> Iterator[ExactState]:
    """States of one search; not `alone`: it is a part of another, and ends where it cannot be completed."""
    whole = opened(problem)
    if not whole.problem.planes or most_pieces == 0:
        yield Search(whole, 0.0, None, most_pieces, keep, good_enough).state(proved=True)
        return
    if bounds is None:
        known = partial(Search, whole, 0.0, start, most_pieces, keep, good_enough)
        bounds = yield from meanwhile(lambda: known().state(), bounding(whole.problem))
    whole = whole.thinned(MAX_PAIRS, start)
    search = Search(whole, bounds.unit, start, most_pieces, keep, good_enough)
    search.floor = bounds.floor
    yield search.state()
    if bounds.dual is not None:
        yield from improve(search)
    most = max(min(slots(p, search.problem.stock), most_pieces or UNLIMITED) for p in search.problem.planes)
    rungs = _rungs(search, most)
    wanted = np.abs(bounds.continuous - np.array([plane.fixed for plane in search.problem.planes]))
    heaviest = max(FAR * float(wanted.max()), float(effective_g(search.problem.stock).min()))
    parts = _parts(search, heaviest, 1 + max(rungs, default=1)) if alone else iter(())
    lighter = thinned(search.problem, search.best, heaviest, 1) if alone and most > FEW else None
    if lighter is not None:
        yield from _part(search, lighter, STEPS_A_BOX)
    for rung in rungs:
        climbing = levels(search, bounds, rung, last=rung == most)
        finished = yield from _between(climbing, parts if rung == most else iter(()))
        if finished and rung == most and whole.items is None:
            return
        if not finished:
            break
    yield from improve(search)
    yield from parts


def _rungs(search: Search, most: int) -> list[int]:
    """Pieces a plane, one rung after the other, as far as each can be searched."""
    whole, stock = search.whole, search.problem.stock
    planes = enumerate(search.problem.planes)
    unlike = [plane for p, plane in planes if not any(whole.alike(p, q) for q in range(p))]
    placements = [placements_of(plane, stock, search.most) for plane in unlike]

    def asked(rung: int) -> float:
        return max(cost_of(placed, min(rung, placed.most)) for placed in placements)

    few = min(most, FEW)
    steps = [next((rung for rung in range(few, 0, -1) if asked(rung) <= MAX_ASKED), 0)]
    if steps[0] < few:
        return [rung for rung in steps if rung]
    for rung in range(FEW + 1, most + 1):
        if asked(rung) > (MAX_ASKED_LAST if rung == most else MAX_ASKED):
            break
        steps.append(rung)
    return steps


def _between(
    climbing: Generator[ExactState, None, bool], parts: Iterator[ExactState]
) -> Generator[ExactState, None, bool]:
    """States of a rung, and now and then one of the parts that are searched in between; whether it was finished."""
    number = 0
    while True:
        try:
            state = next(climbing)
        except StopIteration as done:
            return bool(done.value)
        yield state
        number += 1
        if number > LONG and number % EVERY == 0 and not state.proved:
            yield from (state for state in [next(parts, None)] if state is not None)


def _parts(search: Search, heaviest: float, pieces: int) -> Iterator[ExactState]:
    """Search thinner boxes, then parts around the best selection, without end: any of them may improve it.

    pieces: a plane, that the parts carry at first.
    """
    stride = 1
    while thinned(search.problem, search.best, heaviest, 2 * stride) is not None:
        stride *= 2
    while stride > 1:
        part = thinned(search.problem, search.best, heaviest, stride)
        if part is not None:
            yield from _part(search, part, STEPS_A_BOX)
        stride //= 2
    rng = np.random.default_rng(1)
    idle = 0
    while True:
        before = search.record.entries[0].value
        # The same parts whatever the limit is, until they bring nothing: a higher limit is then never worse.
        carried = tuple(replace(plane, max_pieces=min(plane.max_pieces, pieces)) for plane in search.problem.planes)
        around = neighbourhood(replace(search.problem, planes=carried), search.best, heaviest, rng)
        yield from _part(search, around, STEPS_A_PART)
        idle = 0 if search.record.entries[0].value < before else idle + 1
        pieces += idle > 0 and idle % IDLE == 0
        search.exhausted = idle >= STALLED
        yield search.state()


def _part(search: Search, part: Neighbourhood, steps: int) -> Iterator[ExactState]:
    """Search one part of the problem, and take what it finds."""
    kept = sum(map(len, part.kept))
    most = None if search.most is None else search.most - kept
    states = _searched(part.problem, part.start, most, search.keep, search.good_enough, None, alone=False)
    found: ExactState | None = None
    for state in islice(states, steps):
        found = state
        yield search.state()
    for selection in found.selections if found is not None else ():
        wide = part.widen(selection)
        if broken_limit(search.problem, wide) is None:
            search.offer(wide)


def bounds_for(problem: SelectionProblem) -> Bounds | None:
    """What every search of a valid problem begins with; None where no plane takes a mass."""
    whole = opened(problem).problem
    return bounds_of(whole) if whole.planes else None


def solve_exact(
    problem: SelectionProblem,
    *,
    start: Selection | None = None,
    most_pieces: int | None = None,
    uncertainty: float = 0.0,
    stop: Stop = never,
) -> SelectionResult:
    """Best selection with a proven lower bound; status says how it ended.

    `optimal`: proved. `within_uncertainty`: nothing can be better by more than `uncertainty` (objective's unit), which
    the measurement cannot tell. `limit_reached`: stopped by `stop()` or by memory; value and bound still hold.
    """
    states = search_exact(problem, start=start, most_pieces=most_pieces)
    state = last_state(
        states, lambda now: now.value - now.lower_bound <= uncertainty or stop(), patient=stop is not never
    )
    return exact_result(problem, state, uncertainty, limited=most_pieces is not None)


def last_state(
    states: Iterator[ExactState], enough: Callable[[ExactState], bool], *, patient: bool = False
) -> ExactState:
    """Advance a search until it ends or a state is `enough`, and return that state.

    patient: an exhausted search goes on trying until `enough`, which then has to come by a deadline.
    """
    state = next(states)
    while not enough(state) and (patient or not state.exhausted):
        following = next(states, None)
        if following is None:
            break
        state = following
    return state


def exact_result(
    problem: SelectionProblem, state: ExactState, uncertainty: float = 0.0, *, limited: bool = False
) -> SelectionResult:
    """Result of a search that ended in `state`; limited: it looked at selections of at most this many pieces only."""
    status, message = _ending(state, uncertainty, limited=limited)
    return result_of(problem, state.selection, status, message, state.evaluations, state.lower_bound)


def _ending(state: ExactState, uncertainty: float, *, limited: bool) -> tuple[Status, Message]:
    """Status and message; limited: selections of at most this many pieces were looked at only."""
    gap = state.value - state.lower_bound
    if state.proved or gap <= 0.0:
        return "optimal", Message("selection_proved.fewest" if limited else "selection_proved")
    if gap <= uncertainty:
        key = Message("selection_within_uncertainty.fewest" if limited else "selection_within_uncertainty", gap=gap)
        return "within_uncertainty", key
    if state.exhausted:
        return "limit_reached", Message("selection_too_large.fewest" if limited else "selection_too_large", gap=gap)
    return "limit_reached", Message("selection_stopped.fewest" if limited else "selection_stopped", gap=gap)
