"""Local search: change, add or take off one piece at a time, the best change first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from service.balancing.rotor.phasors import FloatArray, IntArray
from service.balancing.selection.exact.subsets import Placements
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import Selection, vectors_of
from service.balancing.selection.problem import Piece, SelectionProblem

ROUNDS = 60
"""Changes at most; ten are usual."""
SLOTS = 40
"""Pieces a plane that are looked at, where it takes more."""
CELLS = 600_000
"""Residuals and slots that are looked at between two stops."""
BETTER = 1e-9


def descend(
    problem: SelectionProblem, placements: list[Placements], selection: Selection, most: int | None
) -> Iterator[Selection | None]:
    """Yield ever better selections of at most `most` pieces in all, until no single change helps; None between."""
    longest = max(SLOTS, *map(len, selection))
    placements = [replace(placed, most=min(placed.most, longest)) for placed in placements]
    rows = [_row(placed, pieces) for placed, pieces in zip(placements, selection, strict=True)]
    value = float(evaluate(problem.objective, vectors_of(problem, selection)))
    for _ in range(ROUNDS):
        best: tuple[float, int, IntArray] | None = None
        for p, placed in enumerate(placements):
            chunk = CELLS // (len(problem.objective.offset) + 4 * placed.most)
            for slot in range(placed.most):
                if slot and (rows[p][slot - 1 : slot + 1] == placed.none).all():
                    break  # further empty slots are all alike
                for cut in range(0, placed.none + 1, chunk):
                    tried = np.arange(cut, min(cut + chunk, placed.none + 1))
                    index = np.repeat(rows[p][None, :], len(tried), axis=0)
                    index[:, slot] = tried
                    values = _values(problem, placements, rows, p, index, most)
                    pick = int(values.argmin())
                    if values[pick] < (value if best is None else best[0]) * (1.0 - BETTER):
                        best = (float(values[pick]), p, np.sort(index[pick]))
                    yield None
        if best is None:
            return
        value, p, row = best
        rows[p] = row
        yield tuple(placed.pieces(r) for placed, r in zip(placements, rows, strict=True))


def _row(placed: Placements, pieces: tuple[Piece, ...]) -> IntArray:
    """Indices of pieces, ascending, filled up with "no piece"."""
    found = [
        int(np.flatnonzero((placed.position == piece.position) & (placed.item == piece.item))[0]) for piece in pieces
    ]
    return np.array(sorted(found) + [placed.none] * (placed.most - len(found)), dtype=np.int64)


def _values(
    problem: SelectionProblem,
    placements: list[Placements],
    rows: list[IntArray],
    p: int,
    index: IntArray,
    most: int | None,
) -> FloatArray:
    """Objective (n,) where plane p carries each row of index (n, k) instead of its own; infinite where not allowed."""
    placed = placements[p]
    rest = [(q, row) for i, (q, row) in enumerate(zip(placements, rows, strict=True)) if i != p]
    candidates = np.empty((len(index), len(rows)), dtype=np.complex128)
    for i, (plane, q, row) in enumerate(zip(problem.planes, placements, rows, strict=True)):
        candidates[:, i] = plane.fixed + q.vector[row].sum()
    candidates[:, p] = problem.planes[p].fixed + placed.vector[index].sum(axis=1)
    fits = placed.allowed(index)
    others = [q.item[row] for q, row in rest]
    taken = np.bincount(np.concatenate([np.empty(0, np.int64), *others]), minlength=len(placed.counts))
    item = placed.item[index]
    for j in range(index.shape[1]):
        same = (item == item[:, j : j + 1]).sum(axis=1) + taken[item[:, j]]
        fits &= (same <= placed.counts[item[:, j]]) | (index[:, j] == placed.none)
    if most is not None:
        elsewhere = sum(int((row != q.none).sum()) for q, row in rest)
        fits &= (index != placed.none).sum(axis=1) + elsewhere <= most
    return np.where(fits, evaluate(problem.objective, candidates), np.inf)
