"""The shaft set study: correction masses for low total, low worst sensor and even spread, with stated importance."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from service.design.documents import patched
from service.design.findings import Finding, RefusedDesign, warning
from service.design.reading import Asked
from service.design.shaft_set.case import AIMS, ShaftCase, read_shaft
from service.design.study import DesignProblem, Document, LimitCheck, Scalar, Simulation, Variable, limit_check
from service.design.units import UNITS, unit_of
from service.mechanics.bodies import ComplexArray, FloatArray
from service.mechanics.shaft_set import ILL_CONDITIONED, aims
from service.messages import Message
from service.optimize.epsilon import TwoObjectives
from service.optimize.problem import Continuous, MixedProblem
from service.optimize.smooth import Constraints, Objective, SmoothProblem

LOWEST = -20.0
"""Bound of a membership variable; far below 0, so that every start is feasible for it."""
SPREAD_DOMINATES = 0.5


class ShaftSetStudy:
    """Several correction planes and many sensors, three aims."""

    name = "shaft_set"

    def check(self, document: Document) -> tuple[Finding, ...]:
        """Everything that is wrong with a document, and warnings."""
        case, problems = read_shaft(document)
        return tuple(problems.found) if case is None else (*problems.found, *_warnings(case))

    def asked(self, document: Document) -> Mapping[str, Asked]:
        """The fields of a document by path, with their quantities and choices."""
        return read_shaft(document)[1].asked

    def simulate(self, document: Document) -> Simulation:
        """Responses of the masses; raises RefusedDesign."""
        case = _read(document)
        x = case.shaft.residual(case.present)
        values = aims(x)
        memberships = case.goals.memberships(values)
        scalars = [Scalar("h", float(case.goals.h(values)))]
        scalars += [
            Scalar(name, float(value), quantity)
            for name, value, quantity in zip(AIMS, values, ("1", "vibration", "vibration"), strict=True)
        ]
        scalars += [Scalar(f"membership_{name}", float(mu)) for name, mu in zip(AIMS, memberships, strict=True)]
        scalars += [
            Scalar(f"residual.{name}", float(abs(one)), "vibration") for name, one in zip(case.sensors, x, strict=True)
        ]
        for name, one in zip(case.planes, case.present, strict=True):
            scalars.append(Scalar(f"mass.{name}", float(abs(one)), "trial_mass"))
            scalars.append(Scalar(f"angle.{name}", float(np.angle(one) % (2.0 * math.pi)), "angle"))
        return Simulation(tuple(scalars), (), _limits(case), _warnings(case), _drawing(case, x))

    def problem(self, document: Document) -> DesignProblem:
        """The document as an optimisation problem; raises RefusedDesign."""
        case = _read(document)
        planes = len(case.planes)
        names = [f"{plane}.{part}" for part in ("x", "y") for plane in case.planes]
        present = np.concatenate([case.present.real, case.present.imag])
        variables = tuple(
            Variable(name, -case.most, case.most, float(value), "trial_mass")
            for name, value in zip(names, present, strict=True)
        )
        mass = UNITS["trial_mass"][unit_of("trial_mass", case.heading.units)]
        angle = UNITS["angle"][unit_of("angle", case.heading.units)]

        def apply(x: FloatArray) -> Document:
            w = _masses(x, planes)
            stated = {
                "masses": (np.abs(w) / mass).tolist(),
                "angles": (np.angle(w) % (2.0 * math.pi) / angle).tolist(),
            }
            return patched(document, {"design": stated})

        smooth = _smooth(case)
        return DesignProblem(
            variables=variables,
            objective_name="h",
            maximise=True,
            alternatives=(smooth,),
            apply=apply,
            mixed=_mixed(case),
            front=TwoObjectives((_energy_alone(case, smooth),), _largest(case)),
            front_names=("energy", "largest"),
        )


def _read(document: Document) -> ShaftCase:
    case, problems = read_shaft(document)
    problems.raise_any()
    if case is None:
        raise RefusedDesign(problems.found)
    return case


def _masses(x: FloatArray, planes: int) -> ComplexArray:
    return np.asarray(x[:planes] + 1j * x[planes : 2 * planes])


def _smooth(case: ShaftCase) -> SmoothProblem:
    """Variables: real and imaginary masses, largest s, least q, memberships (3,), with s >= |x| >= q."""
    planes = len(case.planes)
    top = float(np.abs(case.shaft.initial).max() + (np.abs(case.shaft.influence) * case.most).sum(axis=1).max())
    lower = np.concatenate([np.full(2 * planes, -case.most), [0.0, 0.0], np.full(3, LOWEST)])
    upper = np.concatenate([np.full(2 * planes, case.most), [top, top], np.ones(3)])

    def objective(y: FloatArray) -> tuple[float, FloatArray]:
        slope = np.zeros(len(y))
        slope[-3:] = -case.goals.weights
        return float(slope @ y), slope

    starts = [_extended(case, w) for w in (case.shaft.least_squares, case.present)]
    # Without the spread, whose least vibration is not convex, the problem is convex and its bound is proved.
    convex = bool(case.goals.weights[2] * case.goals.gained[2] == 0.0)
    return SmoothProblem(lower, upper, objective, _constraints(case), np.array(starts), convex)


def _extended(case: ShaftCase, w: ComplexArray) -> FloatArray:
    w = w * np.minimum(1.0, case.most / np.maximum(np.abs(w), 1e-300))
    x = np.abs(case.shaft.residual(w))
    mu = np.clip(case.goals.memberships(aims(case.shaft.residual(w))), LOWEST, 1.0)
    return np.concatenate([w.real, w.imag, [x.max(), x.min()], mu])


def _constraints(case: ShaftCase) -> Constraints:
    planes, n = len(case.planes), len(case.sensors)
    scale = max(float(np.abs(case.shaft.initial).max()), 1e-300)
    a = case.shaft.influence
    turned = np.concatenate([a, 1j * a], axis=1)
    gained = case.goals.gained
    span = np.where(gained > 0.0, case.goals.worst - case.goals.best, 1.0)

    def constraints(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        w, (s, q), mu = _masses(y, planes), y[2 * planes : 2 * planes + 2], y[-3:]
        x = case.shaft.residual(w)
        square = np.abs(x) ** 2
        by_w = 2.0 * np.real(np.conj(x)[:, None] * turned)
        g = np.zeros(2 * n + 3 + planes)
        jacobian = np.zeros((len(g), len(y)))
        # |x| <= s is convex as (|x|^2 - s^2) is not: written as |x| - s, smooth away from 0.
        size = np.sqrt(square + (1e-12 * scale) ** 2)
        g[:n] = (size - s) / scale
        jacobian[:n, : 2 * planes] = by_w / (2.0 * size[:, None] * scale)
        jacobian[:n, 2 * planes] = -1.0 / scale
        g[n : 2 * n] = (q**2 - square) / scale**2
        jacobian[n : 2 * n, : 2 * planes] = -by_w / scale**2
        jacobian[n : 2 * n, 2 * planes + 1] = 2.0 * q / scale**2
        values = np.array([square.sum(), s, s - q])
        g[2 * n : 2 * n + 3] = np.where(gained > 0.0, mu - (case.goals.worst - values) / span, -1.0)
        rows = jacobian[2 * n : 2 * n + 3]
        rows[0, : 2 * planes] = by_w.sum(axis=0) / span[0]
        rows[1, 2 * planes] = 1.0 / span[1]
        rows[2, 2 * planes], rows[2, 2 * planes + 1] = 1.0 / span[2], -1.0 / span[2]
        rows[:, -3:] = np.eye(3)
        rows *= gained[:, None]
        g[2 * n + 3 :] = np.abs(w) ** 2 / case.most**2 - 1.0
        k = np.arange(planes)
        jacobian[2 * n + 3 + k, k] = 2.0 * w.real / case.most**2
        jacobian[2 * n + 3 + k, planes + k] = 2.0 * w.imag / case.most**2
        return g, jacobian

    return constraints


def _energy_alone(case: ShaftCase, smooth: SmoothProblem) -> SmoothProblem:
    """Least sum of squares, for the trade-off with the largest."""
    planes, a = len(case.planes), case.shaft.influence
    turned = np.concatenate([a, 1j * a], axis=1)

    def energy(y: FloatArray) -> tuple[float, FloatArray]:
        x = case.shaft.residual(_masses(y, planes))
        slope = np.zeros(len(y))
        slope[: 2 * planes] = (2.0 * np.real(np.conj(x)[:, None] * turned)).sum(axis=0)
        return float((np.abs(x) ** 2).sum()), slope

    return SmoothProblem(smooth.lower, smooth.upper, energy, smooth.constraints, smooth.starts)


def _largest(case: ShaftCase) -> Objective:
    place = 2 * len(case.planes)

    def largest(y: FloatArray) -> tuple[float, FloatArray]:
        slope = np.zeros(len(y))
        slope[place] = 1.0
        return float(y[place]), slope

    return largest


def _mixed(case: ShaftCase) -> MixedProblem:
    """The same problem for searches that use values alone; populations (members, 2 planes), Cartesian."""
    planes = len(case.planes)

    def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        w = x[:, :planes] + 1j * x[:, planes:]
        return -case.goals.h(aims(case.shaft.residual(w))), np.abs(w) / case.most - 1.0

    return MixedProblem((Continuous(-case.most, case.most),) * (2 * planes), evaluate)


def _limits(case: ShaftCase) -> tuple[LimitCheck, ...]:
    return tuple(
        limit_check("most_mass", float(abs(one)), case.most, "at_most", "trial_mass", name)
        for name, one in zip(case.planes, case.present, strict=True)
    )


def _warnings(case: ShaftCase) -> tuple[Finding, ...]:
    found = []
    if case.shaft.condition > ILL_CONDITIONED:
        found.append(
            warning(
                Message(
                    "shaft_ill_conditioned",
                    field="shaft_set.influence",
                    value=case.shaft.condition,
                    planes=case.shaft.alike,
                )
            )
        )
    for name, one in zip(case.sensors, case.shaft.initial, strict=True):
        if one == 0.0:
            found.append(warning(Message("shaft_silent_sensor", field="shaft_set.initial", value=name)))
    for name, gained in zip(AIMS, case.goals.gained, strict=True):
        if gained == 0.0:
            found.append(warning(Message("shaft_nothing_to_gain", field=f"aim.{name}", value=name)))
    if case.goals.weights[2] > SPREAD_DOMINATES:
        value = float(case.goals.weights[2])
        found.append(warning(Message("shaft_spread_dominates", field="aim.weights", value=value)))
    return tuple(found)


def _drawing(case: ShaftCase, x: ComplexArray) -> dict[str, object]:
    return {
        "kind": "shaft_set",
        "sensors": list(case.sensors),
        "planes": list(case.planes),
        "before": np.abs(case.shaft.initial).tolist(),
        "after": np.abs(x).tolist(),
        "masses": [[float(one.real), float(one.imag)] for one in case.present],
    }
