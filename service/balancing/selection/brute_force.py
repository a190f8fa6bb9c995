"""Brute force: every selection of a small problem, the judge of the other solvers.

Kept plain on purpose. It knows no bound and no pruning; it refuses a problem that is too large to try.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import effective_g, result_of, slots, within_g
from service.balancing.selection.problem import Piece, SelectionProblem, SelectionResult
from service.balancing.selection.validation import validate
from service.errors import NumericsError
from service.messages import Message

MAX_COMBINATIONS = 500_000
"""Joint choices; a single plane of three hundred thousand takes about a second."""


def solve_exhaustive(
    problem: SelectionProblem, most: int = MAX_COMBINATIONS, most_pieces: int | None = None
) -> SelectionResult:
    """Try every selection and return the best one; the first in order of enumeration where several are equal.

    most_pieces: at most this many in all planes together. Raises NumericsError (code `too_many_combinations`,
    value: how many) above `most`, and for an invalid problem.
    """
    validate(problem)
    combinations = count_combinations(problem)
    if combinations > most:
        raise NumericsError(Message("too_many_combinations", combinations=combinations, most=most), value=combinations)
    choices = [_choices(problem, p) for p in range(len(problem.planes))]
    value, best, tried = _joint(problem, choices, most_pieces)
    selection = [chosen.pieces(i) for chosen, i in zip(choices, best, strict=True)]
    return result_of(
        problem, selection, "optimal", Message("selections_all_tried", tried=tried), tried, lower_bound=value
    )


def count_combinations(problem: SelectionProblem) -> int:
    """Bound the joint selections from above: multisets of (position, item) per plane, capacities and stock aside."""
    total = 1
    for plane in problem.planes:
        pairs = len(plane.angles) * len(problem.stock.masses_g)
        total *= sum(math.comb(pairs + k - 1, k) for k in range(min(slots(plane, problem.stock), 64) + 1))
    return total


@dataclass(frozen=True)
class _Choices:
    """What one plane may carry on its own: pairs (K,) of each choice, vector sums (K,), pieces used (K, I)."""

    pairs: tuple[tuple[int, ...], ...]
    vectors: ComplexArray
    usage: IntArray

    def pieces(self, choice: int) -> tuple[Piece, ...]:
        items = self.usage.shape[1]
        return tuple(Piece(*divmod(pair, items)) for pair in self.pairs[choice])


def _choices(problem: SelectionProblem, p: int) -> _Choices:
    """Every multiset of pairs (position, item) within the limits of plane p."""
    plane, mass = problem.planes[p], effective_g(problem.stock)
    holes, items = len(plane.angles), len(mass)
    vector = (np.exp(1j * plane.angles)[:, None] * mass).ravel()
    pairs, vectors, usage = [], [], []
    for k in range(slots(plane, problem.stock) + 1):
        chosen = list(combinations_with_replacement(range(holes * items), k))
        index = np.array(chosen, dtype=np.int64).reshape(len(chosen), k)
        at = (index[:, :, None] // items == np.arange(holes)).sum(axis=1)
        used = (index[:, :, None] % items == np.arange(items)).sum(axis=1)
        grams = ((index[:, :, None] // items == np.arange(holes)) * mass[index % items][:, :, None]).sum(axis=1)
        fits = (at <= plane.capacity).all(axis=1) & within_g(grams, plane.capacity_g).all(axis=1)
        fits &= within_g(used @ mass, plane.max_mass_g) & (used <= problem.stock.counts).all(axis=1)
        if plane.allowed is not None:
            fits &= plane.allowed.ravel()[index].all(axis=1)
        pairs += [chosen[i] for i in np.flatnonzero(fits)]
        vectors.append(plane.fixed + vector[index[fits]].sum(axis=1))
        usage.append(used[fits])
    return _Choices(tuple(pairs), np.concatenate(vectors), np.concatenate(usage))


def _joint(
    problem: SelectionProblem, choices: list[_Choices], most_pieces: int | None
) -> tuple[float, tuple[int, ...], int]:
    """Try every joint choice: all but the last plane one by one, the last plane as an array."""
    *heads, last = choices
    best: tuple[float, tuple[int, ...]] = (math.inf, ())
    tried = 0
    u = np.empty((len(last.vectors), len(choices)), dtype=np.complex128)
    u[:, -1] = last.vectors
    for head in np.ndindex(*(len(chosen.vectors) for chosen in heads)):
        left = problem.stock.counts - sum(chosen.usage[i] for chosen, i in zip(heads, head, strict=True))
        fits = (last.usage <= left).all(axis=1)
        if most_pieces is not None:
            already = sum(int(chosen.usage[i].sum()) for chosen, i in zip(heads, head, strict=True))
            fits &= last.usage.sum(axis=1) <= most_pieces - already
        if not fits.any():
            continue
        u[:, :-1] = [chosen.vectors[i] for chosen, i in zip(heads, head, strict=True)]
        values = np.where(fits, evaluate(problem.objective, u), math.inf)
        tried += int(fits.sum())
        tail = int(values.argmin())
        if values[tail] < best[0]:
            best = (float(values[tail]), (*head, tail))
    return best[0], best[1], tried
