"""A linkage document as an optimisation problem: masses that calm the frame, within limits."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from service.design.documents import patched
from service.design.linkage_case import LinkageCase
from service.design.linkage_design import StatedDesign
from service.design.mass_limits import CONVEX, Sector, sectors
from service.design.study import DesignProblem, Document, FrontProblem
from service.design.units import UNITS, unit_of
from service.mechanics.bodies import FloatArray
from service.mechanics.dynamics import Quantity
from service.optimize.problem import Continuous, MixedProblem
from service.optimize.smooth import Constraints, Objective, SmoothProblem


def linkage_problem(case: LinkageCase, design: StatedDesign, document: Document) -> DesignProblem:
    """The problem of a document that states what may change."""
    variation = design.variation
    lower = np.array([one.lower for one in variation.variables])
    upper = np.array([one.upper for one in variation.variables])
    start = np.clip(design.present, lower, upper)[None]
    regions = [_constraints(case, design, choice) for choice in _choices(case, design)]
    convex = variation.linear and all(limit.kind in CONVEX for limit in design.limits)

    def smooth(objective: Objective) -> tuple[SmoothProblem, ...]:
        return tuple(SmoothProblem(lower, upper, objective, region, start, convex) for region in regions)

    def through(of_p: Callable[[FloatArray], tuple[float, FloatArray]]) -> Objective:
        def objective(x: FloatArray) -> tuple[float, FloatArray]:
            value, slope = of_p(variation.numbers(x))
            return value, slope @ variation.slopes(x)

        return objective

    units = case.heading.units
    factors = [UNITS[name][unit_of(name, units)] for name in ("length", "mass", "inertia")]
    fronts: tuple[FrontProblem, ...] = ()
    if case.aim.front is not None:
        first, second = (through(_square(case, name)) for name in case.aim.front)
        fronts = tuple(FrontProblem(one, second, np.sqrt) for one in smooth(first))
    return DesignProblem(
        variables=variation.variables,
        objective_name="aim",
        maximise=False,
        alternatives=smooth(through(case.aimed_with_slope)),
        apply=lambda x: patched(document, variation.patch(x, *factors)),
        mixed=_mixed(case, design),
        front_names=None if case.aim.front is None else tuple(f"{n}_ratio" for n in case.aim.front),  # type: ignore[arg-type]
        fronts=fronts,
    )


def _square(case: LinkageCase, name: Quantity) -> Callable[[FloatArray], tuple[float, FloatArray]]:
    """Square of a quantity's ratio to the present, with slopes."""
    gram = case.features.gram[name] / (case.base_rms[name] or 1.0) ** 2

    def of_p(p: FloatArray) -> tuple[float, FloatArray]:
        along = gram @ p
        return max(float(p @ along), 0.0), 2.0 * along

    return of_p


def _choices(case: LinkageCase, design: StatedDesign) -> list[tuple[Sector, ...]]:
    """Each way of choosing one sector for every link that states a range of directions."""
    options = []
    for link, lower, upper in design.angles:
        if upper - lower < 2.0 * np.pi - 1e-9:
            body = case.stated.linkage.links[link].body
            options.append(sectors(link, lower, upper, max(abs(complex(body.moment_x, body.moment_y)), 1e-12)))
    return list(product(*options))


def _constraints(case: LinkageCase, design: StatedDesign, choice: tuple[Sector, ...]) -> Constraints:
    variation, limits = design.variation, design.limits
    flat = np.zeros((2 * len(choice), len(case.base)))
    for k, sector in enumerate(choice):
        flat[2 * k : 2 * k + 2, 4 * sector.link : 4 * sector.link + 4] = sector.slopes()

    def constraints(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        p = variation.numbers(x)
        bodies = p.reshape(-1, 4)
        g = np.array([float(limit.scaled(bodies[limit.link])) for limit in limits])
        slopes = np.zeros((len(limits), len(p)))
        for k, limit in enumerate(limits):
            slopes[k, 4 * limit.link : 4 * limit.link + 4] = limit.slope(bodies[limit.link])
        return np.concatenate([g, flat @ p]), np.concatenate([slopes, flat]) @ variation.slopes(x)

    return constraints


def _mixed(case: LinkageCase, design: StatedDesign) -> MixedProblem:
    """The same problem for searches that use values alone; populations (n, d)."""
    variation, limits = design.variation, design.limits
    turn = 2.0 * np.pi

    def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        p = variation.numbers(x)
        bodies = p.reshape(len(x), -1, 4)
        g = [limit.scaled(bodies[:, limit.link]) for limit in limits]
        for link, lower, upper in design.angles:
            angle = np.arctan2(bodies[:, link, 2], bodies[:, link, 1]) - (lower + upper) / 2.0
            away = np.abs(angle - turn * np.round(angle / turn))
            g.append(away - (upper - lower) / 2.0)
        return case.aimed(p), np.stack(g, axis=1) if g else np.zeros((len(x), 1))

    variables = tuple(Continuous(one.lower, one.upper) for one in variation.variables)
    return MixedProblem(variables, evaluate)
