"""Explain why no selection meets a limit: how near one comes, which constraint binds, what would help."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from service.balancing.rotor.phasors import ComplexArray
from service.balancing.selection.exact.bounds import bounds_of
from service.balancing.selection.exact.search import Stop, last_state, search_exact, solve_exact
from service.balancing.selection.placements import effective_g, slots
from service.balancing.selection.problem import UNLIMITED, SelectionPlane, SelectionProblem, SelectionResult, Stock
from service.messages import Message, Quantity

SAME = 1e-9
MAX_BOUGHT = 100
"""Pieces a plane that more of every mass would add at most."""
MAX_TOLD = 12
"""Changes that a reason lists."""


def explain_limit(
    problem: SelectionProblem, limit: float, evaluations: int, stop: Stop = lambda: False
) -> SelectionResult:
    """Result of status `infeasible` for a limit that no selection meets.

    details: `nearest`, the best value there is; `missing`, by how much it is above the limit; `continuous`, what masses
    of any size at any angle would leave. reason: the same, with every single change that would help.
    """
    nearest = solve_exact(problem, stop=stop)
    continuous = _any_masses(problem)
    reason = Message(
        "selection_limit_not_met" if nearest.status == "optimal" else "selection_limit_not_met.found_in_time",
        nearest=nearest.value,
        limit=limit,
        remedy=Message("selection_limit_not_met.any_masses", continuous=continuous)
        if continuous > limit * (1.0 + SAME)
        else _what_helps(problem, limit, stop),
    )
    return SelectionResult(
        status="infeasible",
        message=Message("selection_limit_not_met.proved"),
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


def _what_helps(problem: SelectionProblem, limit: float, stop: Stop) -> Message:
    """Every single change that makes the limit possible; what there was no time to try is said."""
    met = [(change, _meets(easier, limit, stop)) for change, easier in _easier(problem)]
    bought, all_tried = _bought(problem, limit, stop)
    helping = [change for change, enough in met if enough] + bought
    whole = all_tried and all(enough is not None for _, enough in met)
    if not helping:
        return Message("limit_helped.by_no_single_change" if whole else "limit_helped.no_time")
    told, more = helping[:MAX_TOLD], len(helping) - MAX_TOLD
    if more > 0:
        return Message("limit_helped.by_many" if whole else "limit_helped.by_many_so_far", changes=told, more=more)
    return Message("limit_helped" if whole else "limit_helped.so_far", changes=told)


def _meets(problem: SelectionProblem, limit: float, stop: Stop) -> bool | None:
    """Whether some selection meets the limit; None where it is not known by `stop()` or for want of memory."""
    if stop():
        return None
    allowed = limit * (1.0 + SAME)
    state = last_state(search_exact(problem), lambda now: now.value <= allowed or now.lower_bound > allowed or stop())
    if state.value <= allowed:
        return True
    return False if state.proved or state.lower_bound > allowed else None


def _bought(problem: SelectionProblem, limit: float, stop: Stop) -> tuple[list[Message], bool]:
    """Single pieces more in the box that are enough, else more of every mass if that is; and whether all were tried.

    More of every mass first: where that does not help, no single piece of a long box does.
    """
    stock = problem.stock
    now = 1 + sum(min(slots(plane, stock), MAX_BOUGHT) for plane in problem.planes)
    ample = replace(problem, stock=replace(stock, counts=np.minimum(stock.counts, UNLIMITED - now) + now))
    scarce = np.flatnonzero(stock.counts < sum(slots(plane, ample.stock) for plane in problem.planes))
    enough = _meets(ample, limit, stop) if scarce.size else False
    if not enough:
        return [], enough is not None
    single = []
    for i in scarce:
        if stop():
            break
        counts = stock.counts.copy()
        counts[i] += 1
        if _meets(replace(problem, stock=replace(stock, counts=counts)), limit, stop):
            single.append(Message("limit_change.piece", mass=Quantity(stock.masses_g[i], "g")))
    return single or [Message("limit_change.every_mass")], not stop()


def _easier(problem: SelectionProblem) -> Iterator[tuple[Message, SelectionProblem]]:
    """Every single change of machine and limits that a technician might make."""
    planes = problem.planes

    def changed(change: dict[str, object]) -> SelectionProblem:
        return replace(problem, planes=tuple(replace(plane, **change) for plane in planes))  # type: ignore[arg-type]

    yield (
        Message("limit_change.plane_pieces"),
        replace(problem, planes=tuple(replace(p, max_pieces=_one_more(p.max_pieces)) for p in planes)),
    )
    if any(math.isfinite(plane.max_mass_g) for plane in planes):
        yield Message("limit_change.plane_mass"), changed({"max_mass_g": math.inf})
    yield (
        Message("limit_change.position_pieces"),
        replace(problem, planes=tuple(replace(p, capacity=_room(p)) for p in planes)),
    )
    if any(np.isfinite(plane.capacity_g).any() for plane in planes):
        free = tuple(replace(p, capacity_g=np.where(p.capacity_g > 0.0, np.inf, 0.0)) for p in planes)
        yield Message("limit_change.position_mass"), replace(problem, planes=free)
    if any((plane.capacity <= 0).any() for plane in planes):
        opened = tuple(replace(p, capacity=np.maximum(p.capacity, 1)) for p in planes)
        yield Message("limit_change.blocked"), replace(problem, planes=opened)


def _one_more(pieces: int) -> int:
    return pieces + 1 if pieces < UNLIMITED else pieces


def _room(plane: SelectionPlane) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    more = (plane.capacity > 0) & (plane.capacity < UNLIMITED)
    return np.asarray(plane.capacity + more, dtype=np.int64)


def _any_masses(problem: SelectionProblem) -> float:
    """Lower bound of the objective for masses of any size at any angle."""
    angles = np.linspace(0.0, 2.0 * math.pi, 24, endpoint=False, dtype=np.float64)
    open_plane = SelectionPlane(angles, np.full(24, UNLIMITED), np.full(24, math.inf), max_pieces=1000)
    heavy = 1e3 * (effective_g(problem.stock).max() + 1.0)
    anything = Stock(np.array([heavy]), np.array([UNLIMITED]), np.zeros(1))
    planes = tuple(replace(open_plane, fixed=plane.fixed) for plane in problem.planes)
    return bounds_of(replace(problem, planes=planes, stock=anything)).floor
