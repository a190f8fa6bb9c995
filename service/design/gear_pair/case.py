"""A gear pair's document, read: duty, present pair, what may be chosen, and the weight of mass against distance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from service.design.findings import of_error
from service.design.heading import Heading, begin
from service.design.reading import Problems, Table, refused
from service.design.study import Document
from service.errors import NumericsError
from service.mechanics.bodies import FloatArray
from service.mechanics.gears import CUTS, SLENDER, Cut, GearDuty
from service.messages import Message

Model = Literal["sound", "as_printed"]
MILLIMETRE = 1e-3
NEWTON_MM2 = 1e6
MAX_TEETH = 200


@dataclass(frozen=True)
class GearCase:
    """A document that was read without a refusal. Modules and widths in mm, as gear cutters have them.

    modules: rising list, or (least, greatest) of the printed model, where any between may be taken. teeth: bounds.
    """

    heading: Heading
    duty: GearDuty
    model: Model
    module: float
    width: float
    teeth: int
    modules: FloatArray
    widths: tuple[float, float]
    teeth_bounds: tuple[int, int]
    weight: float

    @property
    def teeth_choices(self) -> FloatArray:
        """Whole numbers of teeth within the bounds."""
        return np.arange(self.teeth_bounds[0], self.teeth_bounds[1] + 1, dtype=np.float64)


def read_gear(document: Document) -> tuple[GearCase | None, Problems]:
    """The case of a document, or None, and what was noted while it was read."""
    root, problems, heading = begin(document)
    gear, design, aim = root.table("gear"), root.table("design"), root.table("aim", optional=True)
    weight = 0.5
    if aim is not None:
        weight = aim.number("mass_weight", default=0.5, least=0.0, most=1.0)
        aim.close()
    root.close()
    if gear is None or design is None:
        return None, problems
    model: Model = "sound" if gear.text("model", default="sound", choices=get_args(Model)) == "sound" else "as_printed"
    data = _duty_values(gear)
    cut: Cut = next(one for one in CUTS if one == gear.text("cut", choices=CUTS))
    gear.close()
    module = design.number("module", "length", above=0.0) / MILLIMETRE
    width = design.number("width", "length", above=0.0) / MILLIMETRE
    teeth = design.whole("teeth", least=5, most=MAX_TEETH)
    modules = np.array(design.numbers("modules", "length")) / MILLIMETRE
    low, high = (value / MILLIMETRE for value in design.bounds("width_bounds", "length"))
    fewest, most = design.numbers("teeth_bounds", count=2)
    design.close()
    _choices(problems, modules, (low, high), (fewest, most), model)
    if refused(problems):
        return None, problems
    try:
        duty = GearDuty(**data, cut=cut)
    except NumericsError as error:
        problems.found.append(of_error(error, "gear"))
        return None, problems
    bounds = (int(fewest), int(most))
    return GearCase(heading, duty, model, module, width, teeth, modules, (low, high), bounds, weight), problems


def _duty_values(table: Table) -> dict[str, float]:
    """Numbers of `GearDuty`."""
    found = {
        "power": table.number("power", "power", above=0.0),
        "speed": table.number("speed", "speed", above=0.0),
        "ratio": table.number("ratio", least=1.0),
        "hardness": table.number("hardness", "stress", above=0.0) / NEWTON_MM2,
        "strength": table.number("strength", "stress", above=0.0) / NEWTON_MM2,
        "helix": table.number("helix", "angle", default=0.0, least=0.0),
    }
    defaults = {
        "working_factor": 1.25,
        "overlap_ratio": 1.6,
        "stress_concentration": 1.5,
        "material_factor": 271.11,
        "flank_factor": 1.76,
        "overlap_factor": 0.79,
    }
    return found | {name: table.number(name, default=value, above=0.0) for name, value in defaults.items()}


def _choices(
    problems: Problems, modules: FloatArray, widths: tuple[float, float], teeth: tuple[float, float], model: Model
) -> None:
    """Rules between what may be chosen."""
    if len(modules) == 0 or not (np.diff(modules) > 0.0).all() or not (modules > 0.0).all():
        problems.add(
            Message("design_not_rising", field="design.modules", value=float(np.diff(modules).min(initial=0.0)))
        )
        return
    if model == "as_printed" and len(modules) != 2:
        problems.add(Message("design_not_a_list", field="design.modules", value=f"{len(modules)} numbers", count=2))
    fewest, most = teeth
    if not (fewest.is_integer() and most.is_integer() and 5 <= fewest <= most <= MAX_TEETH):
        problems.add(
            Message(
                "design_teeth_bounds",
                field="design.teeth_bounds",
                value=f"{fewest:g}, {most:g}",
                least=5,
                most=MAX_TEETH,
            )
        )
    if not widths[0] > 0.0:
        problems.add(Message("design_out_of_range.above", field="design.width_bounds", value=widths[0], bound=0.0))
    elif model == "sound" and widths[1] < SLENDER * float(modules[0]):
        problems.add(
            Message(
                "design_infeasible_bounds.width",
                field="design.width_bounds",
                value=widths[1],
                least=SLENDER * float(modules[0]),
            )
        )
