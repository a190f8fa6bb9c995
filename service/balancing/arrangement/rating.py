"""Residual, value, moves and limits of many arrangements at once."""

from __future__ import annotations

import numpy as np

from service.balancing.arrangement.problem import EMPTY, ArrangementProblem
from service.balancing.rotor.phasors import ComplexArray, FloatArray, IntArray
from service.balancing.selection.objectives import norm_of
from service.balancing.selection.problem import BoolArray


def residuals(problem: ArrangementProblem, arrangements: IntArray) -> ComplexArray:
    """Residual (n, S) of arrangements (n, P)."""
    r = np.repeat(problem.objective.offset[None, :], len(arrangements), axis=0)
    for place in range(problem.places):
        part = arrangements[:, place]
        r += np.where((part != EMPTY)[:, None], problem.effects[part, place], 0.0)
    return r


def values(problem: ArrangementProblem, arrangements: IntArray) -> FloatArray:
    """Objective (n,) of arrangements (n, P)."""
    return norm_of(problem.objective, residuals(problem, arrangements))


def moves(problem: ArrangementProblem, arrangements: IntArray) -> IntArray:
    """Number (n,) of places whose part differs from the present one."""
    return np.asarray((arrangements != problem.present).sum(axis=1), dtype=np.int64)


def new_parts(problem: ArrangementProblem, arrangements: IntArray) -> IntArray:
    """Number (n,) of new parts mounted."""
    counted = np.append(problem.new, False)
    return np.asarray(counted[arrangements].sum(axis=1), dtype=np.int64)


def violations(problem: ArrangementProblem, arrangements: IntArray) -> FloatArray:
    """How far (n,) arrangements break the limits beyond `allowed`; 0 where all hold.

    Parts that a split set lacks or has too many, grams of too great a difference over the limit, moves and new parts
    over theirs: only whether it is 0, and its decrease in a search, mean something.
    """
    over = np.zeros(len(arrangements))
    for members in problem.sets:
        mounted = np.isin(arrangements, members).sum(axis=1)
        over += np.minimum(mounted, len(members) - mounted)
    for group in problem.groups:
        over += _excess(problem, arrangements[:, list(group.places)], group.max_difference_g)
    if problem.max_moves is not None:
        over += np.maximum(moves(problem, arrangements) - problem.max_moves, 0)
    if problem.max_new is not None:
        over += np.maximum(new_parts(problem, arrangements) - problem.max_new, 0)
    return over


def within_limits(problem: ArrangementProblem, arrangements: IntArray) -> BoolArray:
    """Which (n,) of the arrangements keep every limit; `allowed` and each part once are taken for granted."""
    if not problem.limited:
        return np.ones(len(arrangements), dtype=np.bool_)
    return violations(problem, arrangements) <= 0.0


def _excess(problem: ArrangementProblem, parts: IntArray, limit: float) -> FloatArray:
    """Grams (n,) by which the masses of the parts (n, places of a group) differ too much."""
    mass = problem.masses_g[parts]
    mounted = parts != EMPTY
    highest = np.where(mounted, mass, -np.inf).max(axis=1)
    lowest = np.where(mounted, mass, np.inf).min(axis=1)
    excess = highest - lowest - limit
    # Masses are read to a milligram at best: a difference of exactly the limit is within it.
    return np.where(mounted.any(axis=1) & (excess > 1e-9 * max(limit, 1.0)), excess, 0.0)
