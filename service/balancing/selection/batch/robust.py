"""Selections that stay good under uncertainty: the smallest 95 % quantile, or the most probable within the limits.

The aim of a selection is a figure of many draws of the coefficients, no norm of one residual, so that the exact search
cannot prove it. What is rated is the best selection of the problem as measured, the best selections of many draws, and
those nearest to the continuous masses with the best aim; the best of them is then improved by single changes. The
draws that choose are not those that state (`robust_aims` with other draws): a selection is never praised for the luck
of its own draws.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Literal

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.solver import solve_batch
from service.balancing.selection.batch.survival import QUANTILE, values_of
from service.balancing.selection.batch.tables import Shared
from service.balancing.selection.exact.search import search_exact
from service.balancing.selection.placements import Selection, broken_limit, effective_g, vectors_of
from service.balancing.selection.problem import Objective, Piece, SelectionProblem
from service.errors import NumericsError
from service.messages import Message

Aim = Literal["quantile_95", "probability_within_limits"]

SOLVED_DRAWS = 200
"""Draws whose own best selections are candidates."""
NEAREST = 24
"""Selections nearest to the continuous optimum that are candidates."""
MAX_STEPS = 200
"""Steps of the search for them."""
DESCENT = 40
"""Steps of the continuous descent."""
SCREENED = 60
"""Single changes of a selection that are rated on all draws, chosen by a quarter of them."""
MAX_CHANGES = 30
"""Single changes one after the other at most; three are usual."""
BETTER = 1e-9
BANDWIDTH = 0.3
"""Width of the band of draws that count as lying at the aim, in standard deviations of their values."""


@dataclass(frozen=True)
class Uncertain:
    """Draws of one problem: its objective, and what has a limit (norm max, limit 1); None where nothing has one."""

    objectives: Objectives
    limited: Objectives | None


@dataclass(frozen=True)
class RobustState:
    """Best selections so far, best first, with their aims (smaller is better), and how many were rated."""

    selections: tuple[Selection, ...]
    aims: FloatArray
    evaluations: int


def robust_aims(uncertain: Uncertain, aim: Aim, candidates: ComplexArray) -> FloatArray:
    """Aims (C, 2) of vector sums (C, P) in g, ascending in the first, equals told apart by the second.

    quantile_95: of the objective, twice. probability_within_limits: share of the draws with a limit broken, and the
    95 % quantile of the worst share of a limit. Raises NumericsError for that aim without limits.
    """
    if aim == "quantile_95":
        quantile = np.quantile(values_of(uncertain.objectives, candidates), QUANTILE, axis=0)
        return np.stack([quantile, quantile], axis=1)
    if uncertain.limited is None:
        raise NumericsError(Message("numerics.robust_without_limits"), field="aim", value=aim)
    worst = values_of(uncertain.limited, candidates)
    return np.stack([(worst > 1.0).mean(axis=0), np.quantile(worst, QUANTILE, axis=0)], axis=1)


def search_robust(
    problem: SelectionProblem,
    uncertain: Uncertain,
    aim: Aim,
    starts: Sequence[Selection],
    *,
    shared: Shared | None = None,
    keep: int = 1,
) -> Iterator[RobustState]:
    """Yield ever better states; ends where no single change helps. Proves nothing.

    starts: at least one selection that is allowed. shared: rows of the planes, where they can be listed. keep: how many
    selections a state holds. A step takes some ten milliseconds, but for the first ones with `shared`.
    """
    pool = _Pool(problem, uncertain, aim, keep)
    pool.offer(starts)
    yield pool.state()
    if shared is not None:
        some = np.arange(min(SOLVED_DRAWS, len(uncertain.objectives)))
        solved = solve_batch(shared, problem.planes, _aimed(uncertain, aim).taken(some))
        pool.offer(dict.fromkeys(solved.selection(number) for number in some.tolist()))
        yield pool.state()
    surrogate = _nearest(uncertain, aim, vectors_of(problem, pool.best[0]))
    if surrogate is not None:
        nearest = SelectionProblem(surrogate, problem.planes, problem.stock)
        state = None
        for state in islice(search_exact(nearest, start=pool.best[0], keep=NEAREST), MAX_STEPS):
            yield pool.state()
            if state.proved:
                break
        pool.offer(() if state is None else state.selections)
        yield pool.state()
    for _ in range(MAX_CHANGES):
        if not (yield from pool.improve()):
            return


class _Pool:
    """Selections rated so far, best first."""

    def __init__(self, problem: SelectionProblem, uncertain: Uncertain, aim: Aim, keep: int) -> None:
        self._problem, self._uncertain, self._aim, self._keep = problem, uncertain, aim, keep
        self._few = Uncertain(
            _every_fourth(uncertain.objectives),
            None if uncertain.limited is None else _every_fourth(uncertain.limited),
        )
        self._seen: set[Selection] = set()
        self._rated: list[tuple[float, float, int, Selection]] = []
        self.evaluations = 0

    @property
    def best(self) -> tuple[Selection, ...]:
        """The best selections, best first."""
        return tuple(selection for *_, selection in self._rated)

    def state(self) -> RobustState:
        """What is known now."""
        return RobustState(self.best, np.array([one[0] for one in self._rated]), self.evaluations)

    def offer(self, selections: Sequence[Selection] | dict[Selection, None]) -> None:
        """Rate selections that are allowed; of equal ones that with fewer pieces leads."""
        new = [selection for selection in dict.fromkeys(selections) if selection not in self._seen]
        if not new:
            return
        self._seen.update(new)
        self.evaluations += len(new)
        vectors = np.array([vectors_of(self._problem, selection) for selection in new])
        aims = robust_aims(self._uncertain, self._aim, vectors)
        for (first, second), selection in zip(aims.tolist(), new, strict=True):
            self._rated.append((first, second, sum(map(len, selection)), selection))
        self._rated.sort()
        del self._rated[self._keep :]

    def improve(self) -> Generator[RobustState, None, bool]:
        """Offer the single changes of the best selection that look best; returns whether one of them is better."""
        first, second, _, selection = self._rated[0]
        changed = list(_changes(self._problem, selection))
        vectors = np.array([vector for vector, _ in changed])
        aims = np.empty((len(changed), 2))
        for cut in range(0, len(changed), SCREENED):
            aims[cut : cut + SCREENED] = robust_aims(self._few, self._aim, vectors[cut : cut + SCREENED])
            yield self.state()
        self.evaluations += len(changed)
        allowed: list[Selection] = []
        for at in np.lexsort((aims[:, 1], aims[:, 0])).tolist():
            if len(allowed) == SCREENED:
                break
            if broken_limit(self._problem, changed[at][1]) is None:
                allowed.append(changed[at][1])
        self.offer(allowed)
        yield self.state()
        now = self._rated[0]
        return (now[0], now[1]) < (first * (1.0 - BETTER), second * (1.0 - BETTER))


def _changes(problem: SelectionProblem, selection: Selection) -> Iterator[tuple[ComplexArray, Selection]]:
    """Vector sums and pieces of every selection that differs by one piece: taken off, added, or put in its place."""
    mass = effective_g(problem.stock)
    sums = vectors_of(problem, selection)
    for p, (plane, pieces) in enumerate(zip(problem.planes, selection, strict=True)):
        turn = np.exp(1j * plane.angles)
        every = [
            Piece(position, item)
            for position in np.flatnonzero(plane.capacity > 0).tolist()
            for item in range(len(mass))
            if plane.allowed is None or plane.allowed[position, item]
        ]
        for out in (None, *dict.fromkeys(pieces)):
            rest = list(pieces)
            base = sums.copy()
            if out is not None:
                rest.remove(out)
                base[p] -= mass[out.item] * turn[out.position]
                yield base, _with(selection, p, rest)
            if len(rest) >= plane.max_pieces:
                continue
            for piece in every:
                if piece == out:
                    continue
                vector = base.copy()
                vector[p] += mass[piece.item] * turn[piece.position]
                yield vector, _with(selection, p, [*rest, piece])


def _with(selection: Selection, p: int, pieces: Sequence[Piece]) -> Selection:
    return (*selection[:p], tuple(sorted(pieces)), *selection[p + 1 :])


def _every_fourth(objectives: Objectives) -> Objectives:
    return objectives.taken(np.arange(0, len(objectives), 4))


def _aimed(uncertain: Uncertain, aim: Aim) -> Objectives:
    """What the aim is a figure of."""
    if aim == "quantile_95" or uncertain.limited is None:
        return uncertain.objectives
    return uncertain.limited


def _nearest(uncertain: Uncertain, aim: Aim, start: ComplexArray) -> Objective | None:
    """Distance from the continuous masses with the best aim, in the metric of the draws that decide it.

    The derivative of a quantile is the mean derivative over the draws that lie at it, that of a probability likewise at
    the limit (L. J. Hong, Operations Research 57 (2009) 118-130). Each step solves the least squares of those draws,
    each residual over its own size as iterated reweighting has it. None where they do not tell the planes apart.
    """
    of = _aimed(uncertain, aim)
    u, best, value = start, start, np.inf
    form: ComplexArray | None = None
    for _ in range(DESCENT):
        r = of.offset + np.einsum("dsp,p->ds", of.matrix, u)
        size = of.weights * np.abs(r)
        values = of.values(np.arange(len(of)), np.repeat(u[None], len(of), axis=0))
        at = float(np.quantile(values, QUANTILE)) if aim == "quantile_95" else 1.0
        now = float(robust_aims(uncertain, aim, u[None])[0] @ (1.0, 1e-6))
        weight = _weights(of, size, values, at)
        square = np.einsum("ds,dsp,dsq->pq", weight, of.matrix.conj(), of.matrix)
        if not np.isfinite(square).all() or np.linalg.cond(square) > 1e12:
            break
        if now < value:
            best, value, form = u, now, square
        wanted = -np.linalg.solve(square, np.einsum("ds,dsp,ds->p", weight, of.matrix.conj(), of.offset))
        u = 0.5 * (u + wanted)
    if form is None:
        return None
    root = np.linalg.cholesky(form / np.abs(form).max()).conj().T
    return Objective(matrix=root, offset=-root @ best, weights=np.ones(len(best)), norm="rms")


def _weights(of: Objectives, size: FloatArray, values: FloatArray, at: float) -> FloatArray:
    """Weight (D, S) of each squared residual: its share in a norm, times how near its draw lies to the aim."""
    spread = max(float(values.std()), 1e-9 * abs(at), 1e-300)
    near = np.exp(-0.5 * np.minimum(np.abs(values - at) / (BANDWIDTH * spread), 6.0) ** 2)
    floor = 1e-3 * max(float(size.max()), 1e-300)
    each = np.broadcast_to(of.weights**2, size.shape)
    if of.norm in ("sum", "components"):
        each = each / np.maximum(size, floor)
    elif of.norm == "max":
        each = each * (size >= 0.98 * size.max(axis=1, keepdims=True))
    return np.asarray(near[:, None] * each, dtype=np.float64)
