"""The searches: the least objective, the fewest moves within a limit, and the front between the two.

A small problem is enumerated; few moves are searched completely; what two halves can list is proved by meeting in the
middle; of the rest the local search gives an answer, whose bound is that of the relaxed problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from service.balancing.arrangement.exact import halves
from service.balancing.arrangement.exact.bounds import Bound, relaxed_bound
from service.balancing.arrangement.exact.enumeration import MAX_ENUMERATED, count_bound, every_arrangement
from service.balancing.arrangement.exact.few_moves import (
    MAX_FEW,
    MAX_LISTED,
    OpenChanges,
    few_changes,
    listed_changes,
    open_changes,
)
from service.balancing.arrangement.exact.region import axes_of
from service.balancing.arrangement.exact.slots import Slots, slots_of
from service.balancing.arrangement.local_search import LocalSearch
from service.balancing.arrangement.problem import ArrangementProblem, ArrangementState
from service.balancing.arrangement.rating import moves
from service.balancing.arrangement.record import TIE, Record
from service.balancing.arrangement.validation import validate
from service.balancing.rotor.phasors import IntArray

MAX_BITS = 62
"""Parts that an enumeration tells apart."""
MAX_ORDERS = 4e8
"""Orders of halves up to which a search by halves is begun: some minutes."""
QUICK_ORDERS = 4e6
"""Orders of halves whose proof is waited for, even where the scale cannot tell the difference: about a second."""
QUICK_STEPS = 24
"""Steps of local search before a search by halves."""
FRONT_STEPS = 60
"""Steps of local search for a number of moves that cannot be searched completely."""


def search_best(
    problem: ArrangementProblem, rng: np.random.Generator, start: IntArray | None = None
) -> Iterator[ArrangementState]:
    """Return an iterator of states towards the least objective, ending with the proof.

    Of a problem too large to prove it does not end: the caller leaves. start: (P,), an arrangement known to be allowed.
    A step takes some ten milliseconds. Raises NumericsError for an invalid problem.
    """
    validate(problem)
    record = Record(problem)
    if start is not None:
        record.offer(start[None, :])
    if _enumerable(problem):
        for some in every_arrangement(problem):
            record.offer(some)
            yield record.state()
        yield record.state(proved=True)
        return
    slots = slots_of(problem)
    if slots is None:
        yield record.state(proved=True)
        return
    bound = relaxed_bound(slots)
    record.lower_bound = bound.value
    yield from _search_large(slots, record, bound, rng)


def search_fewest(problem: ArrangementProblem, limit: float, rng: np.random.Generator) -> Iterator[ArrangementState]:
    """Return an iterator of states towards the fewest moves with an objective of at most `limit`.

    Its states hold an arrangement only once one meets the limit; then the fewest new parts and the least objective
    count. `moves_bound` of a state: no fewer moves meet the limit. Ends with the proof, or not at all as `search_best`.
    """
    validate(problem)
    record = Record(problem, limit)
    if _enumerable(problem):
        for some in every_arrangement(problem):
            record.offer(some)
            yield record.state()
        yield _proved_fewest(record)
        return
    slots = slots_of(problem)
    bound = None if slots is None else relaxed_bound(slots)
    if slots is None or bound is None or bound.value > limit:
        yield record.state(proved=True)
        return
    record.lower_bound = bound.value
    for changed, _ in _few_by_few(slots, record, bound):
        if changed is not None:
            record.moves_bound = changed + 1 if record.arrangement is None else record.moves_bound
        if changed is not None and record.arrangement is not None:
            yield _proved_fewest(record)
            return
        yield record.state()
    most = _most_moves(slots)
    if record.moves_bound > most:
        yield record.state(proved=True)
        return
    if _by_halves_possible(slots):
        for _ in _by_halves(slots, record, bound):
            yield record.state(open_ended=record.arrangement is not None)
        yield _proved_fewest(record)
        return
    yield from _fewest_by_local_search(slots, record, bound, rng, most)


def search_front(problem: ArrangementProblem, rng: np.random.Generator) -> Iterator[dict[int, ArrangementState]]:
    """Return an iterator of fronts: the best arrangement for each number of moves, as far as more moves make it better.

    Each front is keyed by the greatest number of moves; a state that is `proved` is the best with at most as many. It
    ends once every number up to `MAX_FEW`, or of a small problem every number, is proved, and then the least objective
    whatever moves has been searched for a while.
    """
    validate(problem)
    if _enumerable(problem):
        yield from _enumerated_front(problem)
        return
    slots = slots_of(problem)
    if slots is None:
        yield {}
        return
    bound = relaxed_bound(slots)
    record = Record(problem, lower_bound=bound.value)
    front: dict[int, ArrangementState] = {}
    for changed, _ in _few_by_few(slots, record, bound):
        if changed is not None:
            _extend(front, changed, record.state(proved=True))
        yield dict(front)
    most = _most_moves(slots)
    for limit in range(max(front, default=0) + 1, most + 1):
        if front and front[max(front)].value <= bound.value * (1.0 + TIE):
            break
        tight = replace(slots, problem=problem.with_max_moves(limit))
        tried = Record(tight.problem, lower_bound=bound.value)
        for _, _ in zip(range(FRONT_STEPS), _local(tight, tried, bound, rng), strict=False):
            yield dict(front)
        _extend(front, limit, tried.state())
        yield dict(front)


def _extend(front: dict[int, ArrangementState], moves_limit: int, state: ArrangementState) -> None:
    """Add what more moves come to, where it is better than what fewer do."""
    least = min((s.value for s in front.values()), default=np.inf)
    if state.arrangement is not None and state.value < least * (1.0 - TIE):
        front[moves_limit] = state


def _enumerated_front(problem: ArrangementProblem) -> Iterator[dict[int, ArrangementState]]:
    records = [Record(problem) for _ in range(problem.places + 1)]
    for some in every_arrangement(problem):
        changed = moves(problem, some)
        for number in np.unique(changed):
            records[int(number)].offer(some[changed == number])
        yield {}
    front: dict[int, ArrangementState] = {}
    for number, record in enumerate(records):
        _extend(front, number, record.state(proved=True))
    yield front


def _proved_fewest(record: Record) -> ArrangementState:
    if record.arrangement is not None:
        record.moves_bound = int(moves(record.problem, record.arrangement[None, :])[0])
    return record.state(proved=True)


def _enumerable(problem: ArrangementProblem) -> bool:
    return problem.parts <= MAX_BITS and count_bound(problem) <= MAX_ENUMERATED


def _by_halves_possible(slots: Slots) -> bool:
    return halves.choice_count(slots) <= halves.MAX_CHOICES and halves.order_count(slots) <= MAX_ORDERS


def _search_large(slots: Slots, record: Record, bound: Bound, rng: np.random.Generator) -> Iterator[ArrangementState]:
    yield record.state()
    if not slots.size:
        record.offer(slots.fixed[None, :])
        yield record.state(proved=True)
        return
    local = _local(slots, record, bound, rng)
    for _ in range(QUICK_STEPS):
        next(local)
        if record.value <= bound.value * (1.0 + TIE):
            yield record.state(proved=True)
            return
        yield record.state()
    if _few_moves_limit(slots) is not None:
        for _ in _few_by_few(slots, record, bound):
            yield record.state()
        yield record.state(proved=True)
        return
    if _by_halves_possible(slots):
        slow = halves.order_count(slots) > QUICK_ORDERS
        for number, _ in enumerate(_by_halves(slots, record, bound)):
            if slow and number % 2:
                next(local)
            yield record.state(open_ended=slow)
        yield record.state(proved=True)
        return
    for _ in local:
        yield record.state(open_ended=True)


def _local(slots: Slots, record: Record, bound: Bound, rng: np.random.Generator) -> Iterator[None]:
    """Local search that offers what it finds to the record; it does not end."""
    level = record.level if np.isfinite(record.level) else 0.0
    search = LocalSearch(slots, axes_of(slots, bound.support, level), rng)
    starts = [slots.base[None, :], *(m[None, :] for m in bound.matchings[-2:] if _fits(slots, m))]
    if record.arrangement is not None:
        starts.insert(0, slots.slotted(record.arrangement)[None, :])
    told, before = None, 0
    for _ in search.run(np.concatenate(starts)):
        record.evaluations += search.evaluations - before
        before = search.evaluations
        if search.best is not told and search.best is not None and search.best.violation <= 0.0:
            told = search.best
            record.offer(slots.arrangements(told.slotted[None, :]))
        yield


def _fits(slots: Slots, slotted: IntArray) -> bool:
    return bool(slots.allowed[slotted, np.arange(slots.size)].all())


def _most_moves(slots: Slots) -> int:
    """Moves that an arrangement can have."""
    limit = slots.problem.max_moves
    return slots.problem.places if limit is None else min(limit, slots.problem.places)


def _few_moves_limit(slots: Slots) -> int | None:
    """Slots to change at most where that is few enough to search completely, else None."""
    limit = slots.problem.max_moves
    if limit is None:
        return None
    few = min(limit + open_changes(slots).again, slots.open_places)
    return few if few <= MAX_FEW and listed_changes(slots, few) <= MAX_LISTED else None


def _few_by_few(slots: Slots, record: Record, bound: Bound) -> Iterator[tuple[int | None, None]]:
    """Search all arrangements with 0, 1, 2 .. moves; yields the number of moves once it is done with it, else None.

    It ends where a number of moves cannot be searched completely, or is more than allowed.
    """
    base = open_changes(slots)
    least = base.fixed + base.always
    most = _most_moves(slots)
    for allowed_moves in range(least, most + 1):
        few = min(allowed_moves - base.fixed + base.again, slots.open_places)
        if few > MAX_FEW or listed_changes(slots, few) > MAX_LISTED:
            return
        for changed in range(few if base == OpenChanges(0, 0, 0) else 0, few + 1):
            level = [_level(record, slots)]
            axes = axes_of(slots, bound.support, level[0])
            for found in few_changes(slots, axes, changed, level):
                rows = slots.arrangements(found)
                record.offer(rows[moves(slots.problem, rows) <= allowed_moves])
                level[0] = min(level[0], _level(record, slots))
                yield None, None
        yield allowed_moves, None


def _by_halves(slots: Slots, record: Record, bound: Bound) -> Iterator[None]:
    level = [_level(record, slots)]
    axes = axes_of(slots, bound.support, level[0])
    for found in halves.better_arrangements(slots, axes, level):
        if len(found):
            record.offer(slots.arrangements(found))
            level[0] = min(level[0], _level(record, slots))
        yield


def _fewest_by_local_search(
    slots: Slots, record: Record, bound: Bound, rng: np.random.Generator, most: int
) -> Iterator[ArrangementState]:
    """Allow one move more at a time; what is found is not proved."""
    for limit in range(max(record.moves_bound, 1), most + 1):
        tight = replace(slots, problem=slots.problem.with_max_moves(limit))
        tried = Record(tight.problem, lower_bound=bound.value)
        for _, _ in zip(range(FRONT_STEPS), _local(tight, tried, bound, rng), strict=False):
            if tried.value <= (record.limit or 0.0):
                break
            yield record.state(open_ended=True)
        if tried.arrangement is not None:
            record.offer(tried.arrangement[None, :])
        if record.arrangement is not None:
            break
    while True:
        yield record.state(open_ended=True)
        if record.arrangement is not None:
            return


def _level(record: Record, slots: Slots) -> float:
    """What an arrangement must not exceed to be of interest."""
    if np.isfinite(record.level):
        return record.level
    reach = float(np.abs(slots.effects).max(axis=(0, 1), initial=0.0).sum()) * slots.size
    return reach + float(np.abs(slots.offset).sum()) + 1.0
