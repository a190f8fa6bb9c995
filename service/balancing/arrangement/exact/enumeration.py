"""Every arrangement of a small problem, built place by place."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from service.balancing.arrangement.problem import EMPTY, ArrangementProblem
from service.balancing.arrangement.rating import within_limits
from service.balancing.rotor.phasors import IntArray

MAX_ENUMERATED = 400_000
"""Arrangements that are listed one by one: some tenths of a second."""
AT_ONCE = 50_000
"""Arrangements that are rated in one step."""


def count_bound(problem: ArrangementProblem) -> float:
    """At least the number of arrangements, limits other than `allowed` left aside."""
    choices = problem.allowed.sum(axis=0) + problem.may_be_empty
    movable = int(problem.allowed.any(axis=1).sum())
    total, placed = 1.0, 0
    for choice, empty in zip(np.sort(choices), problem.may_be_empty[np.argsort(choices, kind="stable")], strict=True):
        left = movable - placed + int(empty)
        total *= max(min(int(choice), left), 0)
        placed += 0 if choice == 1 or problem.may_be_empty.any() else 1
    return total


def every_arrangement(problem: ArrangementProblem) -> Iterator[IntArray]:
    """Yield the arrangements (n, P) that keep all limits, some thousand at once; each is yielded once.

    For problems of up to 62 parts.
    """
    order = np.argsort(problem.allowed.sum(axis=0) + problem.may_be_empty, kind="stable")
    rows = np.full((1, problem.places), EMPTY, dtype=np.int64)
    used = np.zeros(1, dtype=np.int64)
    for place in order:
        rows, used = _extended(problem, int(place), rows, used)
    for begin in range(0, len(rows), AT_ONCE):
        part = rows[begin : begin + AT_ONCE]
        yield part[within_limits(problem, part)]


def _extended(problem: ArrangementProblem, place: int, rows: IntArray, used: IntArray) -> tuple[IntArray, IntArray]:
    """Rows (n, P) with one more place filled, and the parts they use as bits (n,)."""
    grown, bits = [], []
    for part in np.flatnonzero(problem.allowed[:, place]):
        bit = np.int64(1) << np.int64(part)
        free = (used & bit) == 0
        row = rows[free]
        row[:, place] = part
        grown.append(row)
        bits.append(used[free] | bit)
    if problem.may_be_empty[place]:
        grown.append(rows)
        bits.append(used)
    if not grown:
        return rows[:0], used[:0]
    return np.concatenate(grown), np.concatenate(bits)
