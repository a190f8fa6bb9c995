"""A flywheel document, read: disc, thickness, limits and goal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from service.design.findings import of_error
from service.design.heading import Heading, begin
from service.design.reading import Problems, Table, refused
from service.design.study import Document
from service.design.units import unit_of
from service.errors import NumericsError
from service.mechanics.bodies import FloatArray
from service.mechanics.rotating_disc import Criterion, Disc, Solution, solve
from service.mechanics.spline import FEWEST
from service.messages import Message

Goal = Literal["most_energy", "least_mass", "least_stress"]
MAX_CONTROLS = 30


@dataclass(frozen=True)
class FlywheelLimits:
    """Limits in SI, None where there is none. criterion: the stress that is limited; overspeed: at which it is."""

    mass: float | None
    energy: float | None
    stress: float | None
    criterion: Criterion
    overspeed: float


@dataclass(frozen=True)
class FlywheelCase:
    """A document that was read without a refusal. thickness, lower, upper: of the control points (n,), m."""

    heading: Heading
    disc: Disc
    thickness: FloatArray
    lower: FloatArray
    upper: FloatArray
    limits: FlywheelLimits
    goal: Goal

    def solved(self, thickness: FloatArray) -> Solution:
        """Stresses of a thickness, at the overspeed."""
        return solve(self.disc, thickness, overspeed=self.limits.overspeed, criterion=self.limits.criterion)

    @cached_property
    def present(self) -> Solution:
        """Stresses of the document's own thickness."""
        return self.solved(self.thickness)


def read_flywheel(document: Document) -> tuple[FlywheelCase | None, Problems]:
    """The case of a document, or None, and what was noted while it was read."""
    root, problems, heading = begin(document)
    disc_table, design = root.table("disc"), root.table("design")
    limits = _limits(root)
    aim = root.table("aim", optional=True)
    goal: Goal = "most_energy"
    if aim is not None:
        chosen = aim.text("goal", default=goal, choices=get_args(Goal))
        goal = next(one for one in get_args(Goal) if one == chosen)
        aim.close()
    root.close()
    if disc_table is None or design is None:
        return None, problems
    thickness = np.array(design.numbers("thickness", "length", most=MAX_CONTROLS))
    lower, upper = design.bounds("thickness_bounds", "length")
    design.close()
    radii = _radii(disc_table, len(thickness))
    speed = disc_table.number("speed", "speed")
    if speed == 0.0:
        problems.add(Message("design_speed_zero", field=disc_table.at("speed")))
    density = disc_table.number("density", "density", above=0.0)
    poisson = disc_table.number("poisson", least=0.0, below=0.5)
    inner = disc_table.number("inner_load", "stress", default=0.0)
    outer = disc_table.number("outer_load", "stress", default=0.0)
    disc_table.close()
    if lower <= 0.0:
        problems.add(Message("design_out_of_range.above", field="design.thickness_bounds", value=lower, bound=0.0))
    if len(thickness) < FEWEST:
        problems.add(
            Message(
                "design_count_out_of_range",
                field="design.thickness",
                value=len(thickness),
                least=FEWEST,
                most=MAX_CONTROLS,
            )
        )
    if refused(problems):
        return None, problems
    try:
        disc = Disc(radii, speed, density, poisson, inner, outer)
        n = len(thickness)
        case = FlywheelCase(heading, disc, thickness, np.full(n, lower), np.full(n, upper), limits, goal)
        _ = case.present
    except NumericsError as error:
        problems.found.append(of_error(error, "disc"))
        return None, problems
    _reachable(case, problems)
    return (None if refused(problems) else case), problems


def _radii(table: Table, count: int) -> FloatArray:
    """Control radii: stated, or evenly spread between the edges."""
    if "radii" in table:
        radii = np.array(table.numbers("radii", "length", most=MAX_CONTROLS))
        if len(radii) != count:
            table.problems.add(
                Message("design_count_out_of_range", field=table.at("radii"), value=len(radii), least=count, most=count)
            )
        elif (np.diff(radii) <= 0.0).any():
            step = float(np.diff(radii).min())
            table.problems.add(Message("design_not_rising", field=table.at("radii"), value=step))
        return radii
    inner = table.number("inner_radius", "length", above=0.0)
    outer = table.number("outer_radius", "length", above=0.0)
    if inner >= outer:
        table.problems.add(
            Message("design_out_of_range.above", field=table.at("outer_radius"), value=outer, bound=inner)
        )
    return np.linspace(inner, outer, max(count, 2))


def _limits(root: Table) -> FlywheelLimits:
    table = root.table("limits", optional=True)
    if table is None:
        return FlywheelLimits(None, None, None, "von_mises", 1.0)
    mass = table.number("mass", "mass", above=0.0) if "mass" in table else None
    energy = table.number("energy", "energy", above=0.0) if "energy" in table else None
    stress = table.number("stress", "stress", above=0.0) if "stress" in table else None
    chosen = table.text("criterion", default="von_mises", choices=get_args(Criterion))
    criterion: Criterion = "von_mises" if chosen == "von_mises" else "largest_principal"
    overspeed = table.number("overspeed_factor", default=1.0, least=1.0, most=3.0)
    table.close()
    return FlywheelLimits(mass, energy, stress, criterion, overspeed)


def _reachable(case: FlywheelCase, problems: Problems) -> None:
    """Refuse limits that no thickness within the bounds can meet: both are linear in it."""
    least = float(case.disc.mass_weights @ case.lower)
    if case.limits.mass is not None and case.limits.mass < least:
        unit = unit_of("mass", case.heading.units)
        problems.add(
            Message(
                "design_infeasible_bounds.mass", field="limits.mass", value=case.limits.mass, least=least, unit=unit
            )
        )
    most = float(case.disc.energy_weights @ case.upper)
    if case.limits.energy is not None and case.limits.energy > most:
        unit = unit_of("energy", case.heading.units)
        problems.add(
            Message("design_energy_unreachable", field="limits.energy", value=case.limits.energy, most=most, unit=unit)
        )
