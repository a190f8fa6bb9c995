"""A linkage document as an optimisation problem: masses that calm the frame, within limits."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from service.design.documents import patched
from service.design.linkage.case import LinkageCase
from service.design.linkage.mass_designs import MassDesign
from service.design.linkage.mass_limits import CONVEX, LimitSet, Sector, sectors
from service.design.linkage.stated_design import StatedDesign
from service.design.study import DesignProblem, Document
from service.design.units import UNITS, unit_of
from service.mechanics.bodies import FloatArray
from service.mechanics.dynamics import Quantity
from service.optimize.epsilon import TwoObjectives
from service.optimize.problem import Continuous, MixedProblem
from service.optimize.smooth import Constraints, Objective, SmoothProblem, unconstrained


def linkage_problem(case: LinkageCase, design: StatedDesign, document: Document) -> DesignProblem:
    """The problem of a document that states what may change."""
    variation = design.variation
    lower = np.array([one.lower for one in variation.variables])
    upper = np.array([one.upper for one in variation.variables])
    start = np.clip(design.present, lower, upper)[None]
    masses = _Masses(variation)
    regions = [_constraints(case, design, choice, masses) for choice in _choices(case, design)]
    convex = variation.linear and all(limit.kind in CONVEX for limit in design.limits)

    def smooth(objective: Objective) -> tuple[SmoothProblem, ...]:
        return tuple(SmoothProblem(lower, upper, objective, region, start, convex) for region in regions)

    def through(of_p: Callable[[FloatArray], tuple[float, FloatArray]]) -> Objective:
        def objective(x: FloatArray) -> tuple[float, FloatArray]:
            p, slopes = masses.at(x)
            value, slope = of_p(p)
            return value, slope @ slopes

        return objective

    units = case.heading.units
    factors = [UNITS[name][unit_of(name, units)] for name in ("length", "mass", "inertia")]
    front, names = None, None
    if case.aim.front is not None:
        first, second = (through(_square(case, name)) for name in case.aim.front)
        front = TwoObjectives(smooth(first), second, power=2)
        names = (f"{case.aim.front[0]}_ratio", f"{case.aim.front[1]}_ratio")
    return DesignProblem(
        variables=variation.variables,
        objective_name="aim",
        maximise=False,
        alternatives=smooth(through(case.aimed_with_slope)),
        apply=lambda x: patched(document, variation.patch(x, *factors)),
        mixed=_mixed(case, design),
        front_names=names,
        front=front,
    )


class _Masses:
    """Mass numbers and their slopes at the last point asked for: objectives and limits ask one after the other."""

    def __init__(self, variation: MassDesign) -> None:
        self._variation = variation
        self._last: tuple[bytes, tuple[FloatArray, FloatArray]] | None = None

    def at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = (key, (self._variation.numbers(x), self._variation.slopes(x)))
        return self._last[1]


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


def _constraints(case: LinkageCase, design: StatedDesign, choice: tuple[Sector, ...], masses: _Masses) -> Constraints:
    limits = design.limits
    if not limits and not choice:
        return unconstrained
    flat = np.zeros((2 * len(choice), len(case.base)))
    for k, sector in enumerate(choice):
        flat[2 * k : 2 * k + 2, 4 * sector.link : 4 * sector.link + 4] = sector.slopes()

    limit_set = LimitSet.of(limits)

    def constraints(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        p, by_x = masses.at(x)
        g, slopes = limit_set.at(p.reshape(-1, 4))
        return np.concatenate([g, flat @ p]), np.concatenate([slopes, flat]) @ by_x

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
