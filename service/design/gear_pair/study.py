"""The gear pair study: module, face width and teeth that carry the load with least mass and centre distance."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from service.design.documents import patched
from service.design.findings import Finding, RefusedDesign, warning
from service.design.gear_pair.case import MILLIMETRE, GearCase, read_gear
from service.design.gear_pair.search import aimed, best_printed, best_sound
from service.design.reading import Asked
from service.design.study import DesignProblem, Document, LimitCheck, Scalar, Simulation, Variable, limit_check
from service.design.units import UNITS, unit_of
from service.mechanics.bodies import FloatArray
from service.mechanics.gears import SLENDER, STOUT, as_printed, pair
from service.messages import Message
from service.optimize.problem import Continuous, Discrete, Integer, MixedProblem
from service.optimize.problem import Variable as SearchVariable

STANDARD_MODULES = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0)
"""mm; ISO 54, first series with common ones of the second."""
SPUR_UNDERCUT = 17.0
FASTEST = 25.0
SOFT = 600.0
"""A hardness in N/mm2 below which Brinell units were most likely stated."""


class GearPairStudy:
    """A helical gear pair."""

    name = "gear_pair"

    def check(self, document: Document) -> tuple[Finding, ...]:
        """Everything that is wrong with a document, and warnings."""
        case, problems = read_gear(document)
        return tuple(problems.found) if case is None else (*problems.found, *_warnings(case))

    def asked(self, document: Document) -> Mapping[str, Asked]:
        """The fields of a document by path, with their quantities and choices."""
        return read_gear(document)[1].asked

    def simulate(self, document: Document) -> Simulation:
        """Responses of the pair; raises RefusedDesign."""
        case = _read(document)
        module, width, teeth = (np.array(float(value)) for value in (case.module, case.width, case.teeth))
        one = pair(case.duty, module, width, teeth)
        printed = as_printed(case.duty, module, width, teeth, case.weight)
        other = round(case.duty.ratio * case.teeth)
        aim = float(aimed(case, module, width, teeth)) if case.model == "sound" else float(printed.value)
        scalars = (
            Scalar("aim", aim),
            Scalar("mass", float(one.mass), "mass"),
            Scalar("distance", float(one.distance) * MILLIMETRE, "length"),
            Scalar("pinion_diameter", float(one.diameter) * MILLIMETRE, "length"),
            Scalar("velocity", float(one.velocity), "velocity"),
            Scalar("tangential_force", float(one.tangential), "force"),
            Scalar("dynamic_factor", float(one.dynamic)),
            Scalar("form_factor", float(one.form)),
            Scalar("bending_used", float(one.bending)),
            Scalar("contact_used", float(one.contact)),
            Scalar("wheel_teeth", float(other)),
            Scalar("printed_objective", float(printed.value)),
            Scalar("printed_weight", float(2.2023e-3 * module**2 * width * teeth**2)),
            Scalar("printed_distance", float(3.5 * module * teeth)),
        )
        return Simulation(scalars, (), _limits(case), _warnings(case), _drawing(case, float(one.diameter)))

    def problem(self, document: Document) -> DesignProblem:
        """The document as an optimisation problem; raises RefusedDesign."""
        case = _read(document)
        low, high = case.widths
        variables = (
            Variable("module", float(case.modules[0]), float(case.modules[-1]), case.module),
            Variable("width", low, high, case.width),
            Variable("teeth", float(case.teeth_bounds[0]), float(case.teeth_bounds[1]), float(case.teeth)),
        )
        length = MILLIMETRE / UNITS["length"][unit_of("length", case.heading.units)]

        def apply(x: FloatArray) -> Document:
            design = {"module": float(x[0]) * length, "width": float(x[1]) * length, "teeth": round(float(x[2]))}
            return patched(document, {"design": design})

        return DesignProblem(
            variables=variables,
            objective_name="aim",
            maximise=False,
            alternatives=(),
            apply=apply,
            mixed=_mixed(case),
            exact=(lambda: best_sound(case)) if case.model == "sound" else (lambda: best_printed(case)),
            proved=case.model == "sound",
        )


def _read(document: Document) -> GearCase:
    case, problems = read_gear(document)
    problems.raise_any()
    if case is None:
        raise RefusedDesign(problems.found)
    return case


def _mixed(case: GearCase) -> MixedProblem:
    """The same problem for searches that use values alone; populations (members, 3)."""
    module: SearchVariable = Discrete(tuple(case.modules.tolist()))
    if case.model == "as_printed":
        module = Continuous(float(case.modules[0]), float(case.modules[-1]))
    variables = (module, Continuous(*case.widths), Integer(*case.teeth_bounds))

    def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        if case.model == "as_printed":
            return as_printed(case.duty, x[:, 0], x[:, 1], x[:, 2], case.weight).value, np.zeros((len(x), 1))
        one = pair(case.duty, *x.T)
        ratio = x[:, 1] / x[:, 0]
        g = [one.bending - 1.0, one.contact - 1.0, 1.0 - ratio / SLENDER, ratio / STOUT - 1.0]
        return aimed(case, *x.T), np.stack(g, axis=1)

    return MixedProblem(variables, evaluate)


def _limits(case: GearCase) -> tuple[LimitCheck, ...]:
    """The sound limits, of whichever model: the printed one hides them in penalties."""
    one = pair(case.duty, np.array(case.module), np.array(case.width), np.array(float(case.teeth)))
    found = [
        limit_check("bending", float(one.bending), 1.0, "at_most"),
        limit_check("contact", float(one.contact), 1.0, "at_most"),
        limit_check("slender", case.width, SLENDER * case.module, "at_least", "width"),
        limit_check("stout", case.width, STOUT * case.module, "at_most", "width"),
        limit_check("lower_bound", case.width, case.widths[0], "at_least", "width", "width"),
        limit_check("upper_bound", case.width, case.widths[1], "at_most", "width", "width"),
        limit_check("lower_bound", case.teeth, case.teeth_bounds[0], "at_least", "1", "teeth"),
        limit_check("upper_bound", case.teeth, case.teeth_bounds[1], "at_most", "1", "teeth"),
    ]
    if case.model == "as_printed":
        printed = as_printed(
            case.duty, np.array(case.module), np.array(case.width), np.array(float(case.teeth)), case.weight
        )
        found += [
            limit_check("printed_bending", float(printed.bending), 0.0, "at_most"),
            limit_check("printed_contact", float(printed.contact), 0.0, "at_most"),
        ]
    return tuple(found)


def _warnings(case: GearCase) -> tuple[Finding, ...]:
    one = pair(case.duty, np.array(case.module), np.array(case.width), np.array(float(case.teeth)))
    other = round(case.duty.ratio * case.teeth)
    ratio = other / case.teeth
    undercut = SPUR_UNDERCUT * math.cos(case.duty.helix) ** 3
    duty, module, teeth, velocity = case.duty, case.module, case.teeth, float(one.velocity)
    standard = case.model != "sound" or module in STANDARD_MODULES
    stated = [
        (duty.hardness < SOFT, Message("gear_hardness_unit", field="gear.hardness", value=duty.hardness)),
        (
            not standard,
            Message("gear_module_not_standard", field="design.module", value=module, known=STANDARD_MODULES),
        ),
        (teeth < undercut, Message("gear_undercut", field="design.teeth", value=teeth, least=undercut)),
        (velocity > FASTEST, Message("gear_fast", field="design.module", value=velocity, most=FASTEST)),
        (
            abs(ratio - duty.ratio) > 1e-9,
            Message("gear_teeth_ratio", field="design.teeth", value=ratio, teeth=teeth, other=other, ratio=duty.ratio),
        ),
        (case.model == "as_printed", Message("gear_printed_model", field="gear.model")),
    ]
    return tuple(warning(message) for holds, message in stated if holds)


def _drawing(case: GearCase, diameter: float) -> dict[str, object]:
    return {
        "kind": "gear_pair",
        "diameters": [diameter, diameter * case.duty.ratio],
        "width": case.width,
        "teeth": [case.teeth, round(case.duty.ratio * case.teeth)],
    }
