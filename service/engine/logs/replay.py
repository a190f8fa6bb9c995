"""Solve a session log again, without storage."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

from service.engine.correction_solver import solve_correction
from service.engine.influence_fits import FittedModel, fit_again
from service.engine.logs.answer_diff import differences
from service.engine.logs.rules import checked, not_a_log
from service.engine.plan_solver import refitted, solve_plan
from service.engine.selection_problem import PlanContext, PlanProblem, pose
from service.errors import InvalidInput
from service.messages import Message
from service.model.base import document, read_json
from service.model.correction import Correction, CorrectionRequest
from service.model.machine import CatalogueItem
from service.model.plan import Plan, PlanInputs, PlanRequest
from service.model.session import SessionLog
from service.version import __version__

SAME = 1e-9
"""Answers this near, relative to the greatest of their kind, are the same: rounding of another machine's arithmetic."""


@document
class Resolved:
    """Answers computed from a log, beside those it holds."""

    corrections: tuple[Correction, ...]
    """The corrections, computed again."""
    plans: tuple[Plan, ...]
    """The plans, computed again."""
    changed: tuple[str, ...]
    """Answers that are not those of the log: which, and how."""


def read_log(text: str | bytes) -> SessionLog:
    """A session log; in one written by hand, id, number, time and speed of the runs may be left out.

    Raises InvalidInput for text that is no log, an unknown sensor or plane, or a broken rule.
    """
    try:
        log = read_json(SessionLog, json.dumps(_completed(json.loads(text)), allow_nan=True))
    except (ValueError, RecursionError) as wrong:
        raise not_a_log(wrong) from None
    return checked(log)


def resolve(log: SessionLog, monotonic: Callable[[], float] = time.monotonic, *, tolerance: float = SAME) -> Resolved:
    """Every correction and plan of a log, computed again; a log with none gets one of each.

    tolerance: how near answers are the same, relative to the greatest of their kind in the answer.

    Raises what the use cases raise for a request or runs that do not allow an answer.
    """
    asked = log.corrections or (_first_correction(),)
    corrections = tuple(_correction(log, given) for given in asked)
    wanted = log.plans or _first_plan(log, corrections[-1])
    plans = tuple(_plan(log, corrections, given, monotonic) for given in wanted)
    changed = differences((log.corrections, log.plans), (corrections, plans), tolerance)
    return Resolved(corrections=corrections, plans=plans, changed=changed)


@dataclass(frozen=True)
class _Wanted:
    """A plan to make: what a logged plan says of it."""

    id: str
    number: int
    request: PlanRequest
    inputs: PlanInputs
    created_at: datetime


def _correction(log: SessionLog, given: Correction) -> Correction:
    if given.runs and given.request.source == "saved_influence":
        # Whether saved coefficients hold is told by all runs until then.
        runs = tuple(run for run in log.runs if run.number <= max(given.runs) and not run.excluded)
    elif given.runs:
        runs = tuple(run for run in log.runs if run.number in given.runs)
    else:
        runs = tuple(run for run in log.runs if not run.excluded)
    again = solve_correction(
        log.machine,
        runs,
        log.run_out,
        given.request,
        number=given.number,
        key=given.id,
        saved=given.saved_influence,
        earlier=given.earlier_runs,
        on_rotor=given.on_rotor,
    )
    return replace(again, stale=given.stale, trim=given.trim or again.trim)


def last_problem(log: SessionLog) -> tuple[FittedModel | None, PlanProblem | None]:
    """Fit of a log's last correction, computed again, and the problem of its last plan, where there is one.

    Raises as `resolve` does.
    """
    corrections = tuple(_correction(log, given) for given in log.corrections or (_first_correction(),))
    wanted = log.plans or _first_plan(log, corrections[-1])
    posed = pose(_ground(log, corrections, wanted[-1]), wanted[-1].request) if wanted else None
    return fit_again(log.machine, log.runs, log.run_out, corrections[-1]), posed


def _ground(log: SessionLog, corrections: tuple[Correction, ...], given: Plan | _Wanted) -> PlanContext:
    """What a plan of a log is made on. Raises InvalidInput where the log does not hold it."""
    correction = next((c for c in corrections if c.id == given.request.correction_id), None)
    items = _items(log, given.inputs)
    if correction is None or items is None:
        raise InvalidInput(
            Message("invalid_input.log_plan", number=given.number), field="plans", value=given.request.correction_id
        )
    return PlanContext(
        machine=log.machine,
        items=items,
        runs=log.runs,
        run_out=log.run_out,
        as_found=log.on_rotor,
        correction=correction,
        inputs=given.inputs,
    )


def _plan(
    log: SessionLog, corrections: tuple[Correction, ...], given: Plan | _Wanted, monotonic: Callable[[], float]
) -> Plan:
    ground = _ground(log, corrections, given)
    plan = solve_plan(
        ground,
        given.request,
        number=given.number,
        key=given.id,
        session_id=log.session_id or "",
        at=given.created_at,
        monotonic=monotonic,
    )
    if isinstance(given, Plan) and given.fitted is not None:
        # What was fitted may differ from what was proposed, and the predictions are of that.
        return refitted(ground, plan, given.fitted)
    return plan


def _items(log: SessionLog, inputs: PlanInputs) -> tuple[CatalogueItem, ...] | None:
    """The kinds of stock mass that a plan was made from: those of its own box, as many as it has counts of."""
    earlier = {box.catalogue_id: box.catalogue for box in log.earlier_boxes}
    box = earlier.get(inputs.catalogue_id or "", log.catalogue)
    return None if box is None else box.items[: len(inputs.counts)]


def _first_correction() -> Correction:
    return Correction(
        id="correction-1",
        number=1,
        request=CorrectionRequest(source="fit"),
        runs=(),
        influence=(),
        initial=(),
        corrections=(),
        trim=(),
        predicted=(),
        quality=None,
        static_couple=None,
        tolerance=None,
        alternatives=(),
        saved_influence=None,
        earlier_runs=(),
        diagnostics=(),
    )


def _first_plan(log: SessionLog, correction: Correction) -> tuple[_Wanted, ...]:
    if log.catalogue is None:
        return ()
    objective = "residual_vibration" if correction.request.source == "fit" else "components"
    inputs = PlanInputs(counts=tuple(item.count for item in log.catalogue.items), present=(), version=__version__)
    request = PlanRequest(correction_id=correction.id, objective=objective)  # type: ignore[arg-type]
    return (_Wanted("plan-1", 1, request, inputs, datetime.fromtimestamp(0, UTC)),)


def _completed(log: Any) -> Any:
    """The log with what may be left out of runs put in."""
    if not isinstance(log, dict):
        return log
    if not isinstance(log.get("runs"), list):
        return {"version": __version__, **log}
    speed = log.get("machine", {}).get("service_speed_rpm") if isinstance(log.get("machine"), dict) else None
    runs = []
    for index, run in enumerate(log["runs"]):
        if isinstance(run, dict):
            given: dict[str, Any] = {
                "id": f"run-{index + 1}",
                "number": index + 1,
                "masses": [],
                "nominal_speed_rpm": speed,
                "taken_at": "1970-01-01T00:00:00Z",
            }
            run = {**given, **run}
        runs.append(run)
    return {"version": __version__, **log, "runs": runs}
