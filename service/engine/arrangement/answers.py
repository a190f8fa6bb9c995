"""An answer as documents: parts in places, moves in order, residual with its interval, the maker's rule."""

from __future__ import annotations

import math

import numpy as np

from service.balancing.arrangement import EMPTY, opposite_pairs, values
from service.balancing.rotor.intervals import amplitude_interval
from service.balancing.rotor.phasors import FloatArray, IntArray, polar
from service.engine import mapping
from service.engine.arrangement import request_checks as checks
from service.engine.arrangement.frame import offset_covariance
from service.engine.arrangement.parts import Posed
from service.messages import Message
from service.model.arrangement import MakersRule, Mounted, Move, PlaneResidual


def mounted(posed: Posed, arrangement: IntArray) -> tuple[Mounted, ...]:
    """The part of every place."""
    return tuple(
        Mounted(place=place.label, part=None if part == EMPTY else posed.request.parts[part].id)
        for place, part in zip(posed.places, arrangement.tolist(), strict=True)
    )


def moves_in_order(posed: Posed, arrangement: IntArray) -> tuple[Move, ...]:
    """Parts that change their place, so that one part at most lies off the drum that is to go back on.

    Parts that leave the drum come off first; then each free place gets its part, which frees another place. Of a ring
    of places that exchange their parts one part is laid down: it comes last.
    """
    present = posed.problem.present
    goes = {int(part): place for place, part in enumerate(arrangement) if part != EMPTY}
    was = {int(part): place for place, part in enumerate(present) if part != EMPTY}
    off = [part for part in was if part not in goes]
    todo = {part for part in goes if was.get(part) != goes[part]}
    taken = {was[part] for part in todo if part in was}
    order: list[int] = []
    free = {goes[part] for part in todo} - taken
    while todo:
        ready = sorted(part for part in todo if goes[part] in free)
        if not ready:
            first = min((part for part in todo if part in was), key=lambda part: was[part])
            order += _ring(first, goes, was, todo)
            continue
        part = ready[0]
        order.append(part)
        todo.discard(part)
        free.discard(goes[part])
        if part in was:
            free.add(was[part])
    labels = [place.label for place in posed.places]

    def move(part: int, to: int | None) -> Move:
        leaves = None if part not in was else labels[was[part]]
        return Move(part=posed.request.parts[part].id, leaves=leaves, to=None if to is None else labels[to])

    return (*(move(part, None) for part in sorted(off)), *(move(part, goes[part]) for part in order))


def _ring(first: int, goes: dict[int, int], was: dict[int, int], todo: set[int]) -> list[int]:
    """Parts of a ring: `first` is laid down, its place filled and so on, and it is mounted last."""
    by_goal = {goes[part]: part for part in todo}
    order: list[int] = []
    part = by_goal[was[first]]
    while part != first:
        order.append(part)
        part = by_goal[was[part]]
    order.append(first)
    todo.difference_update(order)
    return order


def residual(posed: Posed, arrangement: IntArray, masses: FloatArray | None = None) -> tuple[PlaneResidual, ...]:
    """Unbalance left in the planes, with its interval from the scale and the measurement.

    masses: (L,) complex g.mm of stock masses besides.
    """
    left = posed.unbalance(arrangement)
    if masses is not None:
        left = left + masses
    spread, dof = _spread(posed, arrangement)
    low, high = amplitude_interval(left, spread, np.full(len(left), dof), mapping.CONFIDENCE)
    out = []
    for p, name in enumerate(posed.frame.planes):
        size, angle = polar(complex(left[p]), posed.frame.sense)
        span = mapping.interval(low[p], high[p]) if spread[p] > 0.0 else None
        out.append(PlaneResidual(plane=name, unbalance_g_mm=size, angle_deg=angle, interval=span))
    return tuple(out)


def _spread(posed: Posed, arrangement: IntArray) -> tuple[FloatArray, float]:
    """Standard deviation per real component (L,) of the residual, and its degrees of freedom (Welch, Satterthwaite)."""
    scale = np.diag(posed.scale_covariance(arrangement)).reshape(-1, 2).mean(axis=1)
    covariance, dof = offset_covariance(posed.request, posed.frame)
    measured = np.diag(covariance).reshape(-1, 2).mean(axis=1)
    if not np.isfinite(measured).all():
        return np.full(len(scale), np.nan), 0.0
    if dof == 0 or not measured.any():
        return np.sqrt(scale + measured), math.inf
    share = float((measured / (measured + scale)).max())
    return np.sqrt(scale + measured), dof / max(share, 1e-4) ** 2


def makers_rule(posed: Posed) -> tuple[MakersRule | None, Message | None]:
    """What the maker's rule would give, or why it gives nothing."""
    parts = [k for k, part in enumerate(posed.request.parts) if checks.may_of(part) != "gone"]
    count = len(posed.places)
    if count % 2:
        return None, Message("makers_rule.odd", places=count)
    kinds = {place.kind for place in posed.places} | {posed.request.parts[k].kind for k in parts}
    if len({place.kind for place in posed.places}) > 1 or len(kinds - {None}) > 1:
        return None, Message("makers_rule.kinds")
    if len(parts) < count:
        return None, Message("makers_rule.too_few", parts=len(parts), places=count)
    if any(not checks.masses_of(posed.request.parts[k]) and not posed.request.parts[k].moment_g_mm for k in parts):
        return None, Message("makers_rule.not_weighed")
    chosen = np.array(parts[:count], dtype=np.int64)
    if len(parts) > count:
        on_now = [int(k) for k in posed.problem.present if k != EMPTY]
        chosen = np.array((on_now + [k for k in parts if k not in on_now])[:count], dtype=np.int64)
    ranked = opposite_pairs(posed.problem.masses_g[chosen])
    arrangement = chosen if ranked is None else chosen[ranked]
    value = float(values(posed.problem, arrangement[None, :])[0])
    return MakersRule(objective_value=value, arrangement=mounted(posed, arrangement)), None
