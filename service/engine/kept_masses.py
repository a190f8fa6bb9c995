"""Limits that masses which stay on the rotor break by themselves."""

from __future__ import annotations

from collections import Counter, defaultdict

import numpy as np

from service.balancing.influence.trial_mass import centrifugal_force
from service.balancing.selection.problem import SelectionResult
from service.engine import mapping
from service.engine.selection_problem import PlanProblem
from service.engine.validation import hole_label, plane_index, position_index
from service.messages import Message, Quantity


def broken_limits(posed: PlanProblem) -> SelectionResult | None:
    """The infeasible result of a plan whose kept masses break a limit already; None where they keep all of them."""
    if posed.request.base != "present":
        return None
    reasons = [*_of_planes(posed), *_of_positions(posed)]
    if not reasons:
        return None
    planes, rows = len(posed.ground.machine.planes), len(posed.problem.objective.offset)
    return SelectionResult(
        status="infeasible",
        message=Message("kept_masses_break_limit.proved"),
        pieces=None,
        value=float("inf"),
        lower_bound=float("inf"),
        vectors=np.zeros(planes, dtype=complex),
        residual=np.full(rows, complex(np.nan, np.nan)),
        evaluations=0,
        reason=Message("kept_masses_break_limit", broken=reasons),
    )


def _of_planes(posed: PlanProblem) -> list[Message]:
    kept = posed.ground.inputs.present
    out = []
    for plane in posed.ground.machine.planes:
        masses = [m.mass_g for m in mapping.as_masses([p for p in kept if p.plane == plane.name])]
        most = min(plane.max_masses, posed.request.max_masses_per_plane or plane.max_masses)
        if len(masses) > most:
            out.append(Message("kept_masses_break_limit.plane_masses", plane=plane.name, masses=len(masses), most=most))
        if plane.max_total_mass_g is not None and sum(masses) > plane.max_total_mass_g:
            mass, limit = Quantity(sum(masses), "g"), Quantity(plane.max_total_mass_g, "g")
            out.append(Message("kept_masses_break_limit.plane_mass", plane=plane.name, mass=mass, most=limit))
    return out


def _of_positions(posed: PlanProblem) -> list[Message]:
    machine = posed.ground.machine
    blocked = {
        (p := plane_index(machine, b.plane, "blocked"), position_index(machine.planes[p], b.position_deg, "blocked"))
        for b in posed.request.blocked
    }
    pieces: Counter[tuple[int, int]] = Counter()
    grams: defaultdict[tuple[int, int], float] = defaultdict(float)
    for mass in mapping.as_masses(posed.ground.inputs.present):
        p = plane_index(machine, mass.plane, "plane")
        at = (p, position_index(machine.planes[p], mass.angle_deg, "position_deg"))
        pieces[at] += 1
        grams[at] += mass.mass_g
    out = []
    for (p, position), count in sorted(pieces.items()):
        plane = machine.planes[p]
        hole = {"hole": hole_label(plane, position), "plane": plane.name}
        if (p, position) in blocked:
            out.append(Message("kept_masses_break_limit.blocked", **hole))
        if count > plane.masses_per_position:
            most = plane.masses_per_position
            out.append(Message("kept_masses_break_limit.hole_masses", **hole, masses=count, most=most))
        force = centrifugal_force(grams[p, position], plane.radius_mm, machine.service_speed_rpm)
        if plane.max_force_n is not None and force > plane.max_force_n * (1.0 + 1e-9):
            limit_n = plane.max_force_n
            out.append(Message("kept_masses_break_limit.hole_force", **hole, force=round(force), most=limit_n))
    return out
