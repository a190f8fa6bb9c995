"""Fronts of designs that no other dominates: sorting, crowding, hypervolume. All objectives are minimised."""

from __future__ import annotations

import numpy as np

from service.errors import NumericsError
from service.messages import Message
from service.optimize.problem import FloatArray, IntArray


def front_ranks(objectives: FloatArray, violation: FloatArray | None = None) -> IntArray:
    """Rank (n,) of each row of objectives (n, k): 0 where no other dominates it, 1 where only rank 0 does, ...

    violation: (n,) sums of violated constraints; a feasible design dominates an infeasible one, and of two infeasible
    ones the lesser violation dominates.
    """
    n = len(objectives)
    over = np.zeros(n) if violation is None else violation
    at_most = (objectives[:, None] <= objectives[None]).all(axis=2)
    below = (objectives[:, None] < objectives[None]).any(axis=2)
    both = (over[:, None] <= 0.0) & (over[None] <= 0.0)
    dominates = np.where(both, at_most & below, over[:, None] < over[None])
    ranks, left, rank = np.full(n, -1, dtype=np.int64), np.ones(n, dtype=bool), 0
    counts = dominates.sum(axis=0)
    while left.any():
        level = left & (counts == 0)
        ranks[level] = rank
        counts = counts - dominates[level].sum(axis=0)
        left &= ~level
        rank += 1
    return ranks


def crowding(objectives: FloatArray) -> FloatArray:
    """Crowding distance (n,) within one front (n, k): gap between neighbours, summed; infinite at the ends."""
    n, k = objectives.shape
    distance = np.zeros(n)
    for j in range(k):
        order = np.argsort(objectives[:, j], kind="stable")
        values = objectives[order, j]
        width = values[-1] - values[0]
        distance[order[[0, -1]]] = np.inf
        if width > 0.0:
            distance[order[1:-1]] += (values[2:] - values[:-2]) / width
    return distance


def hypervolume(points: FloatArray, reference: tuple[float, float]) -> float:
    """Area that points (n, 2) dominate below the reference point; 0 where none is below it.

    Raises NumericsError for values that are not numbers.
    """
    if points.ndim != 2 or points.shape[1] != 2 or np.isnan(points).any():
        raise NumericsError(Message("front_shape", shape=points.shape), field="points")
    inside = points[(points < np.array(reference)).all(axis=1)]
    inside = inside[np.lexsort((inside[:, 1], inside[:, 0]))]
    area, height = 0.0, reference[1]
    for first, second in inside:
        if second < height:
            area += (reference[0] - first) * (height - second)
            height = second
    return float(area)


def undominated(points: FloatArray) -> IntArray:
    """Indices of the points (n, 2) that no other dominates, by rising first objective; equals are kept once."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    kept, height = [], np.inf
    for i in order:
        if points[i, 1] < height:
            kept.append(int(i))
            height = points[i, 1]
    return np.array(kept, dtype=np.int64)
