"""Why no selection meets a limit: how near one comes, which constraint is in the way, what would make it possible."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from service.balancing.exact import Stop, last_state, search_exact, solve_exact
from service.balancing.phasors import ComplexArray
from service.balancing.placements import effective_g
from service.balancing.region import bounds_of
from service.balancing.selection import UNLIMITED, SelectionPlane, SelectionProblem, SelectionResult, Stock

SAME = 1e-9


def explain_limit(
    problem: SelectionProblem, limit: float, evaluations: int, stop: Stop = lambda: False
) -> SelectionResult:
    """Result of status `infeasible` for a limit that no selection meets.

    details: `nearest`, the best value there is; `missing`, by how much it is above the limit; `continuous`, what masses
    of any size at any angle would leave. reason: the same in words, with every single change that would help.
    """
    nearest = solve_exact(problem, stop=stop)
    continuous = _any_masses(problem)
    reason = f"the best selection leaves {nearest.value:.4g}, the limit is {limit:.4g}"
    if continuous > limit * (1.0 + SAME):
        reason += (
            f"; masses of any size at any angle in these planes would leave {continuous:.4g}: "
            "raise the limit, add a plane, or look for another cause than unbalance"
        )
    else:
        helping = [words for words, easier in _easier(problem) if not stop() and _meets(easier, limit, stop)]
        reason += f"; it can be met with {', or with '.join(helping)}" if helping else "; no single change is enough"
    return SelectionResult(
        status="infeasible",
        message="proved: no selection within the limits meets the limit",
        pieces=None,
        value=math.inf,
        lower_bound=nearest.lower_bound,
        vectors=np.array([plane.fixed for plane in problem.planes]),
        residual=_nothing(nearest.residual),
        evaluations=evaluations + nearest.evaluations,
        reason=reason,
        details={"nearest": nearest.value, "missing": nearest.value - limit, "limit": limit, "continuous": continuous},
    )


def _nothing(residual: ComplexArray) -> ComplexArray:
    return np.full(residual.shape, complex(math.nan, math.nan))


def _meets(problem: SelectionProblem, limit: float, stop: Stop) -> bool:
    """Whether some selection meets the limit, as far as can be told before `stop()`."""
    allowed = limit * (1.0 + SAME)
    state = last_state(search_exact(problem), lambda now: now.value <= allowed or now.lower_bound > allowed or stop())
    return state.value <= allowed


def _easier(problem: SelectionProblem) -> Iterator[tuple[str, SelectionProblem]]:
    """Every single change of the limits that a technician might make, in words."""
    planes, stock = problem.planes, problem.stock

    def changed(change: dict[str, object]) -> SelectionProblem:
        return replace(problem, planes=tuple(replace(plane, **change) for plane in planes))  # type: ignore[arg-type]

    yield (
        "one more piece in each plane",
        replace(problem, planes=tuple(replace(p, max_pieces=_one_more(p.max_pieces)) for p in planes)),
    )
    if any(math.isfinite(plane.max_mass_g) for plane in planes):
        yield "no limit on the mass of a plane", changed({"max_mass_g": math.inf})
    yield (
        "one more piece in each position that is free",
        replace(problem, planes=tuple(replace(p, capacity=_room(p)) for p in planes)),
    )
    if any(np.isfinite(plane.capacity_g).any() for plane in planes):
        free = tuple(replace(p, capacity_g=np.where(p.capacity_g > 0.0, np.inf, 0.0)) for p in planes)
        yield "no limit on the mass in a position", replace(problem, planes=free)
    if any((plane.capacity <= 0).any() for plane in planes):
        opened = tuple(replace(p, capacity=np.maximum(p.capacity, 1)) for p in planes)
        yield "the blocked positions", replace(problem, planes=opened)
    if (stock.counts < UNLIMITED).any():
        for i in np.flatnonzero(stock.counts < UNLIMITED):
            counts = stock.counts.copy()
            counts[i] += 1
            yield f"one more {stock.masses_g[i]:g} g piece", replace(problem, stock=replace(stock, counts=counts))
        yield "more pieces of every mass", replace(problem, stock=_unlimited(stock))


def _one_more(pieces: int) -> int:
    return pieces + 1 if pieces < UNLIMITED else pieces


def _room(plane: SelectionPlane) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    more = (plane.capacity > 0) & (plane.capacity < UNLIMITED)
    return np.asarray(plane.capacity + more, dtype=np.int64)


def _unlimited(stock: Stock) -> Stock:
    return replace(stock, counts=np.full(stock.counts.shape, UNLIMITED))


def _any_masses(problem: SelectionProblem) -> float:
    """Lower bound of the objective for masses of any size at any angle."""
    angles = np.linspace(0.0, 2.0 * math.pi, 24, endpoint=False, dtype=np.float64)
    open_plane = SelectionPlane(angles, np.full(24, UNLIMITED), np.full(24, math.inf), max_pieces=1000)
    heavy = 1e3 * (effective_g(problem.stock).max() + 1.0)
    anything = Stock(np.array([heavy]), np.array([UNLIMITED]), np.zeros(1))
    planes = tuple(replace(open_plane, fixed=plane.fixed) for plane in problem.planes)
    return bounds_of(replace(problem, planes=planes, stock=anything)).floor
