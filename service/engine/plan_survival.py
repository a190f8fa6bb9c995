"""Which plan survives the uncertainty of the coefficients: how surely each meets the limits, and is the best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from service.balancing.influence.uncertainty import drawn_coefficients
from service.balancing.rotor.phasors import ComplexArray
from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.survival import Survival, survival
from service.balancing.selection.batch.tables import shared_rows
from service.engine import mapping
from service.engine.selection_problem import PlanProblem

DRAWS = 2_000
"""Draws behind a probability: its own standard deviation is then about one in a hundred."""


def plan_survival(posed: PlanProblem, candidates: Sequence[ComplexArray], *, draws: int = DRAWS) -> Survival | None:
    """Rate selections of a plan, vector sums (P,) in g each, over draws of the coefficients it rests on.

    Within limits means every sensor at most its own limit. None where the objective is not the residual vibration, or
    the scatter of the readings is unknown. The same plan gives the same figures: its seed is that of the request.
    """
    fitted = posed.fitted
    if fitted is None or posed.request.objective != "residual_vibration":
        return None
    drawn = drawn_coefficients(fitted.fit, draws, np.random.default_rng([posed.request.seed, draws]))
    if drawn is None:
        return None
    initial, influence = drawn
    used = np.isfinite(fitted.fit.initial)
    rows = [row for row, use in zip(fitted.rows, used, strict=True) if use]
    one, problem = posed.objective, posed.problem
    return survival(
        Objectives(influence, initial, one.weights, one.norm),
        np.array(candidates, dtype=np.complex128),
        mapping.limits(posed.ground.machine, rows),
        planes=problem.planes,
        shared=shared_rows(problem.planes, problem.stock),
    )
