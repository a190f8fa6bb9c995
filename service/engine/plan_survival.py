"""Plans under the uncertainty of their coefficients: how surely one meets the limits, is the best, and which lasts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from service.balancing.influence.uncertainty import drawn_coefficients
from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.robust import RobustState, Uncertain, robust_aims, search_robust
from service.balancing.selection.batch.survival import Survival, survival
from service.balancing.selection.batch.tables import Shared, shared_rows
from service.balancing.selection.exact.subsets import many_of, placements_of
from service.balancing.selection.objectives import NEGLIGIBLE_REACTION
from service.balancing.selection.placements import result_of
from service.balancing.selection.problem import SelectionResult
from service.engine import balance_quality, mapping
from service.engine.plan_methods import Part, Solved
from service.engine.selection_problem import PlanProblem, base_objective
from service.errors import Conflict
from service.messages import Message
from service.model.plan import Robust, RobustAim

DRAWS = 2_000
"""Draws behind a stated probability: its own standard deviation is then at most one in a hundred."""
CHOOSING = 1_000
"""Draws that a robust plan is chosen by; they are not those that state its probabilities."""
MAX_ROWS = 250_000
"""Selections of one plane up to which the best of every draw is looked for."""


def plan_survival(
    posed: PlanProblem, candidates: Sequence[ComplexArray], *, draws: int = DRAWS, best: bool = True
) -> Survival | None:
    """Rate selections of a plan, vector sums (P,) in g each, over draws of the coefficients it rests on.

    The limits are those of the sensors; for an objective in unbalance, the balance quality of the machine in both
    bearing planes. best: look for the best selection of every draw too, where the planes can be listed. None where the
    scatter of the readings is unknown. The same plan gives the same figures: their seed is that of the request.
    """
    uncertain = drawn(posed, draws)
    if uncertain is None:
        return None
    return survival(
        uncertain.objectives,
        np.array(candidates, dtype=np.complex128),
        uncertain.limited,
        planes=posed.problem.planes,
        shared=listed(posed) if best else None,
    )


def drawn(posed: PlanProblem, draws: int) -> Uncertain | None:
    """The plan's objective and what has a limit, over draws; None where the coefficients' errors are unknown."""
    fitted = posed.fitted
    if fitted is None:
        return None
    found = drawn_coefficients(fitted.fit, draws, np.random.default_rng([posed.request.seed, draws]))
    if found is None:
        return None
    initial, influence = found
    machine, one = posed.ground.machine, posed.objective
    used = np.isfinite(fitted.fit.initial)
    rows = [row for row, use in zip(fitted.rows, used, strict=True) if use]
    limits = mapping.limits(machine, rows)
    if base_objective(posed.request) == "residual_vibration":
        return Uncertain(
            Objectives(influence, initial, one.weights, one.norm), Objectives(influence, initial, 1.0 / limits, "max")
        )
    weighted = posed.ground.correction.request.method in ("weighted", "minimax")
    needed = _needed(initial, influence, 1.0 / limits if weighted else np.ones(len(rows)))
    # The correction may be damped or limited: draws move it as they move the plain least squares.
    plain = _needed(
        fitted.fit.initial[used][None],
        fitted.fit.influence[used][None],
        1.0 / limits if weighted else np.ones(len(rows)),
    )
    return _unbalance(posed, posed.target + needed - plain)


def listed(posed: PlanProblem) -> Shared | None:
    """Rows of every plane, where there are at most `MAX_ROWS`; None elsewhere."""
    planes, stock = posed.problem.planes, posed.problem.stock
    placements = [placements_of(plane, stock) for plane in planes]
    if any(many_of(placed, None, placed.most) > MAX_ROWS for placed in placements if placed.none and placed.most):
        return None
    return shared_rows(planes, stock)


def run_robust(posed: PlanProblem, nominal: Solved, stop: Callable[[], bool]) -> Solved:
    """The selection of the problem as measured, `nominal`, made robust; its value is the aim over draws of its own.

    Of a share of draws the complement is taken, so that a smaller value is better. Raises Conflict where the errors of
    the coefficients, or the limits that the aim speaks of, are unknown.
    """
    robust = posed.request.robust or Robust()
    choosing, stating = drawn(posed, CHOOSING), drawn(posed, DRAWS)
    if choosing is None or stating is None:
        raise Conflict(Message("no_errors_of_coefficients"), field="objective", value="robust")
    if robust.aim == "probability_within_limits" and stating.limited is None:
        raise Conflict(Message("no_limits_to_keep"), field="robust.aim", value=robust.aim)
    result = nominal.result
    if result.pieces is None:
        return nominal
    starts = [result.pieces, *(other.pieces for other in nominal.others if other.pieces is not None)]
    keep = 1 + posed.request.alternatives
    states = search_robust(posed.problem, choosing, robust.aim, starts, shared=listed(posed), keep=keep)
    state = next(states)
    for following in states:
        state = following
        if stop():
            break
    found = sorted(_stated(posed, stating, robust.aim, state), key=lambda one: one.value)
    return Solved([Part(posed.request.method, found[0], 0.0)], tuple(found[1:]))


def _stated(posed: PlanProblem, stating: Uncertain, aim: RobustAim, state: RobustState) -> list[SelectionResult]:
    """Selections as results whose values are stated by draws that did not choose them."""
    message = Message("robust_search", evaluations=state.evaluations, draws=CHOOSING)
    results = [result_of(posed.problem, one, "heuristic", message, state.evaluations) for one in state.selections]
    aims = robust_aims(stating, aim, np.array([one.vectors for one in results]))[:, 0]
    return [replace(one, value=value, lower_bound=0.0) for one, value in zip(results, aims.tolist(), strict=True)]


def _needed(initial: ComplexArray, influence: ComplexArray, weights: FloatArray) -> ComplexArray:
    """Least-squares masses (D, P) in g of each draw."""
    inverse = np.linalg.pinv(weights[:, None] * influence)
    return np.asarray(-np.einsum("dps,ds->dp", inverse, weights * initial), dtype=np.complex128)


def _unbalance(posed: PlanProblem, needed: ComplexArray) -> Uncertain:
    """Objective in unbalance or reactions for each draw's needed masses (D, P), and the permissible unbalance."""
    machine, one = posed.ground.machine, posed.objective
    count = len(needed)
    radius = np.array([plane.radius_mm for plane in machine.planes])
    if base_objective(posed.request) == "components":
        objectives = Objectives(np.repeat(one.matrix[None], count, axis=0), -radius * needed, one.weights, one.norm)
    else:
        start = -np.einsum("sp,dp->ds", one.matrix, needed)
        size = np.abs(start)
        largest = size.max(axis=1, keepdims=True)
        weights = 0.5 / np.where(size < NEGLIGIBLE_REACTION * largest, largest, np.maximum(size, 1e-300))
        objectives = Objectives(one.matrix[None] * weights[:, :, None], start * weights, np.ones(2), one.norm)
    found = balance_quality.share_of_permissible(machine)
    if found is None:
        return Uncertain(objectives, None)
    share = found.astype(np.complex128)
    limited = Objectives(
        np.repeat(share[None], count, axis=0), -np.einsum("bp,dp->db", share, needed), np.ones(2), "max"
    )
    return Uncertain(objectives, limited)
