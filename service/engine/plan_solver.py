"""Solve a plan: from a correction and a box of stock masses to placements, without storage."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from service.balancing.rotor.phasors import ComplexArray
from service.balancing.rotor.reactions import bearing_reactions
from service.balancing.rotor.units import angular_speed
from service.balancing.selection.mounted_pieces import placement_uncertainty
from service.balancing.selection.objectives import evaluate
from service.balancing.selection.problem import SelectionResult
from service.engine import mapping
from service.engine.correction_solver import predicted_with
from service.engine.kept_masses import broken_limits
from service.engine.nothing_to_do import no_pieces
from service.engine.plan_methods import Part, Solved, run_method
from service.engine.plan_survival import plan_survival, run_robust
from service.engine.rotor_state import Mounted, changes, pieces_of
from service.engine.selection_problem import PlanContext, PlanProblem, pose
from service.errors import Conflict, InvalidInput
from service.messages import Message, render
from service.model.correction import SensorVector
from service.model.machine import Machine
from service.model.message import message_data
from service.model.plan import BearingForces, Change, MethodResult, Offer, Placement, Plan, PlanRequest

NOMINAL = 8
"""Selections of the problem as measured that a robust plan begins with, besides the best."""
NOMINAL_SHARE = 0.4
"""Share of a robust plan's time limit that they may take."""
UNIT = {"components": "g.mm", "residual_vibration": "1", "bearing_force": "1", "robust": "1"}


def solve_plan(
    ground: PlanContext,
    request: PlanRequest,
    *,
    number: int,
    key: str,
    session_id: str,
    at: datetime,
    monotonic: Callable[[], float],
) -> Plan:
    """Choose stock masses and positions. An infeasible problem is an answer; a request that cannot be meant raises.

    Deterministic but for `seconds`, as long as the time limit is not reached.
    """
    posed = pose(ground, request)
    solved = solve(posed, monotonic)
    result = solved.result
    offer = offer_of(posed, result)
    chosen = result.pieces is not None
    robust = request.objective == "robust"
    within, best = probabilities(posed, result.vectors, best=robust) if chosen else (None, None)
    return Plan(
        id=key,
        number=number,
        session_id=session_id,
        correction_id=ground.correction.id,
        request=request,
        inputs=ground.inputs,
        **vars(offer),
        changes=changes_of(ground, offer.placements, offer.taken_off) if chosen else (),
        objective_unit=UNIT[request.objective],
        objective_scatter=None if robust else posed.uncertainty or None,
        probability_within=within,
        probability_best=best,
        predicted=_predicted(posed, result.vectors, offer.placements) if chosen else (),
        bearing_forces_n=forces(ground.machine, posed.target, result.vectors) if chosen else None,
        placement_spread=_placement_spread(posed, result),
        per_method=_per_method(solved),
        alternatives=_distinct(offer, [offer_of(posed, other) for other in solved.others]),
        evaluations=sum(part.result.evaluations for part in solved.parts),
        seconds=solved.seconds,
        seed=request.seed,
        created_at=at,
    )


def solve(posed: PlanProblem, monotonic: Callable[[], float]) -> Solved:
    """Run the plan's solvers, unless the masses that are to stay break a limit by themselves."""
    broken = broken_limits(posed)
    needless = no_pieces(posed) if broken is None else broken
    if needless is not None:
        return Solved([Part(posed.request.method, needless, 0.0)])
    request = posed.request
    now = _objective_now(posed) if request.mode == "combine" else None
    if request.objective != "robust":
        return run_method(posed.problem, request, posed.uncertainty, monotonic, now)
    _require_plain(request)
    begun = monotonic()
    as_measured = replace(request, time_limit_s=NOMINAL_SHARE * request.time_limit_s, alternatives=NOMINAL)
    nominal = run_method(posed.problem, as_measured, posed.uncertainty, monotonic)
    solved = run_robust(posed, nominal, lambda: monotonic() - begun >= request.time_limit_s)
    solved.seconds = monotonic() - begun
    solved.parts[-1] = replace(solved.parts[-1], seconds=solved.seconds)
    return solved


def probabilities(posed: PlanProblem, vectors: ComplexArray, *, best: bool) -> tuple[float | None, float | None]:
    """How probable it is that vector sums (P,) in g keep every limit, and that they are the best; None: not known."""
    found = plan_survival(posed, [vectors], best=best)
    if found is None:
        return None, None
    within = None if found.within is None else float(found.within[0])
    return within, None if found.best is None else float(found.best[0])


def _require_plain(request: PlanRequest) -> None:
    """Raise InvalidInput for what a robust plan would pass over in silence."""
    for name, value, meant in (
        ("mode", request.mode, "best"),
        ("method", request.method, "certified"),
        ("slack", request.slack, 0.0),
    ):
        if value != meant:
            raise InvalidInput(
                Message("invalid_input.not_of_a_robust_plan", name=name, value=value, needed=meant),
                field=name,
                value=value,
            )


def _objective_now(posed: PlanProblem) -> float:
    """What the masses that are fitted come to, by the catalogue. Raises Conflict or InvalidInput where there are none.

    Weighed masses are left out of it: the same pieces in the same holes must always do as well as themselves.
    """
    inputs = posed.ground.inputs
    if not inputs.present:
        raise Conflict(Message("nothing_fitted"), field="mode", value="combine")
    if posed.request.base == "present":
        raise InvalidInput(Message("invalid_input.masses_that_stay"), field="base", value="present")
    by_catalogue = [replace(piece, weighed_g=None) for piece in inputs.present]
    machine = posed.ground.machine
    vectors = mapping.placement_vectors(machine, by_catalogue)
    vectors -= mapping.placement_vectors(machine, inputs.present_off)
    return float(evaluate(posed.objective, vectors))


def offer_of(posed: PlanProblem, result: SelectionResult) -> Offer:
    """A result as placements with what is proved of them."""
    placements, off = posed.placements(result.pieces) if result.pieces is not None else ((), ())
    slack_proved = result.details.get("slack_proved")
    message = _counting(posed, result.message)
    return Offer(
        status=result.status,
        message=render(message),
        message_data=message_data(message),
        reason=None if result.reason is None else render(result.reason),
        reason_data=message_data(result.reason),
        placements=placements,
        taken_off=off,
        objective_value=mapping.known(result.value) if result.pieces is not None else None,
        lower_bound=_proved(result, result.lower_bound),
        gap=_proved(result, result.gap),
        slack_proved=None if slack_proved is None else bool(slack_proved),
    )


def _counting(posed: PlanProblem, message: Message) -> Message:
    """A message of mode fewest counts the pieces that are chosen: say which are not among them."""
    kept = len(posed.ground.inputs.present) if posed.request.base == "present" else 0
    if posed.request.mode == "best" or not kept:
        return message
    return Message("pieces_besides", message=message, count=kept)


def _distinct(first: Offer, others: Sequence[Offer]) -> tuple[Offer, ...]:
    """Without those that come to the same rotor: which of two like pieces sits in a hole makes no selection."""
    seen = {(first.placements, first.taken_off)}
    out = []
    for offer in others:
        if (offer.placements, offer.taken_off) not in seen:
            seen.add((offer.placements, offer.taken_off))
            out.append(offer)
    return tuple(out)


def refitted(ground: PlanContext, plan: Plan, actual: tuple[Placement, ...]) -> Plan:
    """The plan with predictions for what was really fitted."""
    machine, posed = ground.machine, pose(ground, plan.request)
    vectors = mapping.placement_vectors(machine, actual) - mapping.placement_vectors(machine, plan.taken_off)
    within, best = probabilities(posed, vectors, best=plan.probability_best is not None)
    return replace(
        plan,
        fitted=actual,
        probability_within=within,
        probability_best=best,
        predicted=_predicted(posed, vectors, actual),
        bearing_forces_n=forces(machine, posed.target, vectors),
    )


def changes_of(ground: PlanContext, wanted: Sequence[Placement], off: Sequence[Placement]) -> tuple[Change, ...]:
    """What to remove, keep and add to get from the rotor as it was when the plan was made to the one wanted."""
    inputs = ground.inputs
    if inputs.on_rotor is None:
        present = Mounted(inputs.present, inputs.present_off)
    else:
        known = (*inputs.present, *inputs.present_off)
        present = pieces_of(ground.machine, ground.as_found, inputs.on_rotor, known)
    return changes(ground.machine, ground.as_found, present, wanted, off)


def forces(machine: Machine, target: ComplexArray, vectors: ComplexArray) -> BearingForces | None:
    """Reactions at service speed before and after, the as-found unbalance taken as -t; None without the geometry."""
    bearings, places = mapping.bearing_places(machine), mapping.plane_places(machine)
    if bearings is None or places is None:
        return None
    names, at = bearings
    radius = np.array([plane.radius_mm for plane in machine.planes])
    omega = angular_speed(machine.service_speed_rpm)
    before = np.abs(bearing_reactions(-target * radius, places, at, omega))
    after = np.abs(bearing_reactions((vectors - target) * radius, places, at, omega))
    return BearingForces(bearings=names, before=tuple(before.tolist()), after=tuple(after.tolist()))


def _predicted(posed: PlanProblem, vectors: ComplexArray, pieces: Sequence[Placement]) -> tuple[SensorVector, ...]:
    request = posed.request
    return predicted_with(
        posed.ground.machine,
        posed.fitted,
        vectors,
        pieces,
        request.angle_tolerance_deg,
        request.mass_tolerance_g,
    )


def _placement_spread(posed: PlanProblem, result: SelectionResult) -> float | None:
    tolerance = posed.request.angle_tolerance_deg
    if tolerance is None or result.pieces is None:
        return None
    return placement_uncertainty(posed.problem, result.pieces, math.radians(tolerance))


def _per_method(solved: Solved) -> tuple[MethodResult, ...]:
    return tuple(
        MethodResult(
            method=part.method,
            status=part.result.status,
            objective_value=mapping.known(part.result.value) if part.result.pieces is not None else None,
            lower_bound=_proved(part.result, part.result.lower_bound),
            evaluations=part.result.evaluations,
            seconds=part.seconds,
        )
        for part in solved.parts
    )


def _proved(result: SelectionResult, value: float) -> float | None:
    """A bound or gap, where the method proved one."""
    return None if result.pieces is None or result.status == "heuristic" else mapping.known(value)
