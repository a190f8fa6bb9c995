"""Other answers to a plan's problem: the front over the number of masses, and what-if."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from service.balancing.selection.alternatives import front
from service.engine.kept_masses import broken_limits
from service.engine.plan_solver import UNIT, offer_of, solve
from service.engine.selection_problem import PlanContext, pose
from service.engine.validation import item_of
from service.errors import InvalidInput
from service.messages import Message, Quantity
from service.model.machine import CatalogueItem
from service.model.plan import FrontPoint, Plan, PlanRequest, StockChange, WhatIf, WhatIfRequest


def front_of(
    ground: PlanContext, request: PlanRequest, other_box: str | None, monotonic: Callable[[], float]
) -> tuple[FrontPoint, ...]:
    """The best selection of at most 0, 1, 2 ... masses in all, as far as one more makes it better; each proved.

    With base present it begins with the masses that are kept. other_box: name of the box that `ground` has, where it
    is not the session's any more.
    """
    posed = pose(ground, request)
    if broken_limits(posed) is not None:
        return ()
    begun = monotonic()
    points = front(posed.problem, stop=lambda: monotonic() - begun >= request.time_limit_s)
    kept = len(ground.inputs.present) if request.base == "present" else 0
    return tuple(
        FrontPoint(pieces=kept + point.pieces, offer=offer_of(posed, point.result), other_box=other_box)
        for point in points
    )


def what_if(
    ground: PlanContext, plan: Plan, asked: WhatIfRequest, other_box: str | None, monotonic: Callable[[], float]
) -> WhatIf:
    """The plan's own problem with pieces missing or bought, or positions blocked; `other_box` as in `front_of`.

    Raises InvalidInput for a mass that is not in the box, more missing than there are, or an angle that is no position.
    """
    counts = _changed(ground.items, ground.inputs.counts, asked.missing, -1, "missing")
    counts = _changed(ground.items, counts, asked.bought, +1, "bought")
    changed = replace(ground, inputs=replace(ground.inputs, counts=counts))
    request = replace(plan.request, blocked=(*plan.request.blocked, *asked.blocked), alternatives=0)
    posed = pose(changed, request)
    offer = offer_of(posed, solve(posed, monotonic).result)
    known = plan.objective_value is not None and offer.objective_value is not None
    return WhatIf(
        offer=offer,
        objective_value=plan.objective_value,
        objective_unit=UNIT[request.objective],
        worse_by=(offer.objective_value or 0.0) - (plan.objective_value or 0.0) if known else None,
        other_box=other_box,
    )


def _changed(
    items: Sequence[CatalogueItem], counts: Sequence[int | None], pieces: Sequence[StockChange], sign: int, field: str
) -> tuple[int | None, ...]:
    out = list(counts)
    for index, change in enumerate(pieces):
        item = item_of(items, change.mass_g, f"{field}[{index}].mass_g")
        have = out[item]
        if have is None:
            continue
        if have + sign * change.pieces < 0:
            raise InvalidInput(
                Message(
                    "invalid_input.pieces_missing",
                    pieces=change.pieces,
                    mass=Quantity(change.mass_g, "g"),
                    available=have,
                ),
                field=f"{field}[{index}].pieces",
                value=change.pieces,
            )
        out[item] = have + sign * change.pieces
    return tuple(out)
