"""What must hold of every answer to a small problem, judged by trying every selection.

The suite asks it of a few random problems; `python -m tests.balancing.campaign` of hundreds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from service.balancing.rotor.phasors import FloatArray, IntArray
from service.balancing.selection.alternatives import best_selections, front, prefer, solve_fewest
from service.balancing.selection.brute_force import _Choices, _choices
from service.balancing.selection.certified import solve_certified
from service.balancing.selection.exact import rungs
from service.balancing.selection.exact.search import search_exact, solve_exact
from service.balancing.selection.jaya import solve_jaya
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import broken_limit, effective_g, vectors_of
from service.balancing.selection.problem import SelectionProblem, SelectionResult

CLOSE = 1e-8
"""Part of the value without any piece by which two roundings of one value may differ."""
ROUNDING = 1e-13
"""Part of the greatest value below which two values are one."""
SHARES = (0.02, 0.5)
"""Limits and slacks that are asked for: parts of the way from the best to the value without any piece."""


@dataclass(frozen=True)
class Every:
    """Value, pieces and mass (n,) of every selection of a problem. close: what rounding may change of a value."""

    values: FloatArray
    pieces: IntArray
    grams: FloatArray
    close: float

    @classmethod
    def of(cls, problem: SelectionProblem) -> Every:
        """Try them all, as the exhaustive solver does, and keep what each is worth."""
        choices = [_choices(problem, p) for p in range(len(problem.planes))]
        usage, vectors = choices[0].usage, choices[0].vectors[:, None]
        for chosen in choices[1:]:
            usage, vectors = _joined(usage, vectors, chosen)
        kept = (usage <= problem.stock.counts).all(axis=1)
        values = evaluate(problem.objective, vectors[kept])
        pieces, grams = usage[kept].sum(axis=1), usage[kept] @ effective_g(problem.stock)
        close = max(CLOSE * float(values[pieces == 0].max()), ROUNDING * float(values.max()), 1e-300)
        return cls(values, pieces, grams, close)

    @property
    def best(self) -> float:
        """The least value there is."""
        return float(self.values.min())

    def best_of(self, pieces: int) -> float:
        """The least value of at most so many pieces."""
        return float(self.values[self.pieces <= pieces].min())

    def limits(self) -> list[float]:
        """Limits that some selection meets, not so near a value that rounding would decide."""
        empty = float(self.values[self.pieces == 0].min())
        asked = [self.best + share * (empty - self.best) + 10.0 * self.close for share in SHARES]
        return [limit for limit in asked if (np.abs(self.values - limit) > self.close).all()]


def _joined(usage: IntArray, vectors: np.ndarray[tuple[int, int], np.dtype[np.complex128]], chosen: _Choices):  # type: ignore[no-untyped-def]
    """Every pair of what is chosen so far and one more plane's choices."""
    i, j = np.divmod(np.arange(len(usage) * len(chosen.vectors)), len(chosen.vectors))
    return usage[i] + chosen.usage[j], np.concatenate([vectors[i], chosen.vectors[j][:, None]], axis=1)


def check_all(problem: SelectionProblem, seed: int) -> dict[str, int]:
    """Ask everything of one problem; AssertionError says what does not hold. Counts what was compared."""
    every = Every.of(problem)
    counted = {"selections": len(every.values), "states": check_states(problem, every)}
    was, rungs.AT_ONCE = rungs.AT_ONCE, 0.0  # small problems then go through levels, as large ones do
    try:
        counted["states"] += check_states(problem, every)
    finally:
        rungs.AT_ONCE = was
    check_certified(problem, every, seed)
    check_jaya(problem, every, seed)
    counted["alternatives"] = check_alternatives(problem, every, 6)
    counted["front"] = check_front(problem, every)
    counted["fewest"] = check_fewest(problem, every)
    counted["slacks"] = check_slack(problem, every)
    return counted


def check_states(problem: SelectionProblem, every: Every) -> int:
    """At each step a bound that holds and a selection that is allowed; at the end the optimum, proved."""
    steps = 0
    for state in search_exact(problem):
        steps += 1
        assert state.lower_bound <= every.best + every.close, f"bound {state.lower_bound} above {every.best}"
        assert state.value >= every.best - every.close, f"{state.value} is better than brute force, {every.best}"
        assert broken_limit(problem, state.selection) is None, broken_limit(problem, state.selection)
        again = float(evaluate(problem.objective, vectors_of(problem, state.selection)))
        assert abs(state.value - again) <= every.close, f"value {state.value} of a selection worth {again}"
    assert state.proved, "not proved"
    assert abs(state.value - every.best) <= every.close, f"{state.value} is not the optimum {every.best}"
    return steps


def check_certified(problem: SelectionProblem, every: Every, seed: int) -> None:
    """The default method: the optimum with its certificate, never worse than its own first answer."""
    both = solve_certified(problem, seed)
    _is_allowed(problem, every, both.first)
    _is_allowed(problem, every, both.result)
    assert both.result.status == "optimal"
    assert abs(both.result.value - every.best) <= every.close, f"certified {both.result.value}, best {every.best}"
    assert both.result.value <= both.first.value + every.close
    assert both.result.lower_bound <= every.best + every.close


def check_jaya(problem: SelectionProblem, every: Every, seed: int) -> None:
    """Both rules, two runs together: allowed, proved nothing."""
    for as_published in (False, True):
        found = solve_jaya(problem, seed, members=8, generations=8, runs=2, as_published=as_published)
        _is_allowed(problem, every, found)
        assert (found.status, found.lower_bound) == ("heuristic", 0.0)


def check_alternatives(problem: SelectionProblem, every: Every, many: int) -> int:
    """The k best in order, none twice; planes whose masses move nothing are left empty in all of them."""
    acts = np.abs(problem.objective.matrix).max(axis=0) > 0.0
    planes = [plane if act else replace(plane, max_pieces=0) for act, plane in zip(acts, problem.planes, strict=True)]
    ranked = np.sort(Every.of(replace(problem, planes=tuple(planes))).values)[:many]
    found = best_selections(problem, many)
    assert len(found) == len(ranked), f"{len(found)} alternatives of {len(ranked)}"
    assert len({result.pieces for result in found}) == len(found), "a selection stands twice"
    for result, value in zip(found, ranked, strict=True):
        _is_allowed(problem, every, result)
        assert result.status == "optimal"
        assert abs(result.value - value) <= every.close, f"{[r.value for r in found]} are not {ranked}"
    return len(found)


def check_front(problem: SelectionProblem, every: Every) -> int:
    """For each number of pieces the best of as few, up to the optimum."""
    points = list(front(problem))
    for point in points:
        _is_allowed(problem, every, point.result)
        assert point.result.status == "optimal"
        assert _pieces(point.result) <= point.pieces
        assert abs(point.result.value - every.best_of(point.pieces)) <= every.close, f"front at {point.pieces}"
    assert abs(points[-1].result.value - every.best) <= every.close, "the front ends before the optimum"
    return len(points)


def check_fewest(problem: SelectionProblem, every: Every) -> int:
    """The fewest pieces that meet a limit, the best of them; below the optimum none, with a reason."""
    limits = every.limits()
    for limit in limits:
        needed = int(every.pieces[every.values <= limit].min())
        found = solve_fewest(problem, limit)
        _is_allowed(problem, every, found)
        assert (found.status, found.details["at_least"], _pieces(found)) == ("optimal", needed, needed), limit
        assert abs(found.value - every.best_of(needed)) <= every.close
    if every.best > 1e3 * every.close:
        refused = solve_fewest(problem, 0.9 * every.best)
        assert (refused.status, refused.pieces) == ("infeasible", None)
        assert refused.reason is not None
        assert abs(refused.details["nearest"] - every.best) <= every.close
        assert refused.details["continuous"] <= every.best + every.close
    return len(limits)


def check_slack(problem: SelectionProblem, every: Every) -> int:
    """Within a slack of the optimum the fewest pieces, then the least mass; the bound stays the problem's."""
    best = solve_exact(problem)
    limits = every.limits()
    for limit in limits:
        found = prefer(problem, best, max(limit - best.value, 0.0))
        _is_allowed(problem, every, found)
        within = every.values <= limit
        fewest = int(every.pieces[within].min())
        lightest = float(every.grams[within & (every.pieces == fewest)].min())
        assert found.pieces is not None
        mass = effective_g(problem.stock)
        grams = sum(float(mass[piece.item]) for pieces in found.pieces for piece in pieces)
        assert (found.details["slack_proved"], _pieces(found)) == (1.0, fewest), limit
        assert math.isclose(grams, lightest, rel_tol=1e-9, abs_tol=1e-9), f"{grams} g, {lightest} g are enough"
        assert found.lower_bound <= every.best + every.close
    return len(limits)


def _is_allowed(problem: SelectionProblem, every: Every, result: SelectionResult) -> None:
    assert result.pieces is not None, "no selection"
    assert broken_limit(problem, result.pieces) is None, broken_limit(problem, result.pieces)
    assert result.value >= every.best - every.close, f"{result.value} is better than brute force, {every.best}"
    assert result.lower_bound <= result.value


def _pieces(result: SelectionResult) -> int:
    return sum(len(pieces) for pieces in result.pieces or ())
