"""When the best plan is none: the drum is within its limits already, or the correction is lost in the scatter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from service.balancing.influence.fit import predict
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.problem import SelectionResult
from service.engine import balance_quality, mapping
from service.engine.influence_fits import FittedModel
from service.engine.selection_problem import PlanProblem
from service.messages import Message
from service.model.diagnostic import Diagnostic
from service.model.machine import Machine


def no_pieces(posed: PlanProblem) -> SelectionResult | None:
    """The selection of no pieces where none are needed; None where some are, or were asked for in any case.

    Only of a rotor that carries no plan: what is mounted is judged by its check run.
    """
    request, inputs = posed.request, posed.ground.inputs
    asked = request.mode != "best" or request.even_if_within or request.objective == "robust"
    movable = any(piece.may != "stay" for piece in posed.ground.as_found)
    if asked or movable or inputs.present or inputs.present_off or request.base == "present":
        return None
    why = _why(posed)
    if why is None:
        return None
    planes = posed.problem.planes
    vectors = np.array([plane.fixed for plane in planes], dtype=np.complex128)
    residual = posed.objective.offset + posed.objective.matrix @ vectors
    return SelectionResult(
        status="within_uncertainty" if why.key.endswith("noise") else "optimal",
        message=why,
        pieces=tuple(() for _ in planes),
        value=float(evaluate(posed.objective, vectors)),
        lower_bound=0.0,
        vectors=vectors,
        residual=residual,
        evaluations=1,
    )


def _why(posed: PlanProblem) -> Message | None:
    found: Sequence[Diagnostic] = posed.ground.correction.diagnostics
    if any(one.code == "correction_in_noise" for one in found):
        return Message("nothing_to_do.noise")
    machine, fitted = posed.ground.machine, posed.fitted
    if fitted is None or not as_found_within(machine, fitted):
        return None
    if machine.balance_grade_mm_s is not None:
        unknown = np.full((2 * len(posed.target),) * 2, np.nan)
        grade = balance_quality.tolerance_of(machine, posed.target, unknown, 0)
        if grade is None or not grade.within:
            return None
    return Message("nothing_to_do.within_limits")


def as_found_within(machine: Machine, fitted: FittedModel) -> bool:
    """Whether the rotor as found keeps the limit of every sensor at every speed, its interval too where it is known."""
    rows = fitted.rows
    if any(mapping.limit_of(machine, row) is None for row in rows) or not np.isfinite(fitted.fit.initial).all():
        return False
    true = predict(fitted.fit, np.zeros(len(machine.planes), dtype=complex))
    seen = mapping.sensor_vectors(machine, rows, true)
    return all((one.interval.high if one.interval else one.amplitude) <= (one.limit or 0.0) for one in seen)
