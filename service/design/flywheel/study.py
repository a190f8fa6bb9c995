"""The flywheel study: the thickness profile that stores the most energy within mass and stress limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from service.design.documents import patched
from service.design.findings import Finding, RefusedDesign, warning
from service.design.flywheel.case import FlywheelCase, Goal, read_flywheel
from service.design.reading import Asked
from service.design.study import (
    Curve,
    DesignProblem,
    Document,
    LimitCheck,
    Scalar,
    Simulation,
    Variable,
    limit_check,
)
from service.design.units import UNITS, unit_of
from service.mechanics.bodies import FloatArray
from service.mechanics.rotating_disc import Solution
from service.mechanics.spline import basis, segments
from service.messages import Message
from service.optimize.epsilon import TwoObjectives
from service.optimize.problem import Continuous, MixedProblem
from service.optimize.smooth import Constraints, Objective, SmoothProblem

SHOWN_POINTS = 201
STEEP = 1.0
"""A slope of the thickness over the radius above which plane stress is doubtful."""
IMPLAUSIBLE = 1e-4
"""A stress limit below this part of rho w^2 R2^2 is most likely in another unit."""
_OBJECTIVES: dict[Goal, tuple[str, str, bool]] = {
    "most_energy": ("energy", "energy", True),
    "least_mass": ("mass", "mass", False),
    "least_stress": ("stress_peak", "stress", False),
}


class FlywheelStudy:
    """Thickness of a rotating disc over its radius."""

    name = "flywheel"

    def check(self, document: Document) -> tuple[Finding, ...]:
        """Everything that is wrong with a document, and warnings."""
        case, problems = read_flywheel(document)
        return tuple(problems.found) if case is None else (*problems.found, *_warnings(case))

    def asked(self, document: Document) -> Mapping[str, Asked]:
        """The fields of a document by path, with their quantities and choices."""
        return read_flywheel(document)[1].asked

    def simulate(self, document: Document) -> Simulation:
        """Responses of the thickness; raises RefusedDesign."""
        case = _read(document)
        peak = _peak(case.present)
        mass = float(case.disc.mass_weights @ case.thickness)
        energy = float(case.disc.energy_weights @ case.thickness)
        scalars = (
            Scalar("mass", mass, "mass"),
            Scalar("energy", energy, "energy"),
            Scalar("inertia", 2.0 * energy / case.disc.speed**2, "inertia"),
            Scalar("stress_peak", peak[0], "stress"),
            Scalar("stress_peak_radius", peak[1], "length"),
        )
        return Simulation(scalars, _curves(case), _limits(case, mass, energy, peak), _warnings(case), _drawing(case))

    def problem(self, document: Document) -> DesignProblem:
        """The document as an optimisation problem; raises RefusedDesign."""
        case = _read(document)
        n = len(case.thickness)
        variables = tuple(
            Variable(f"thickness_{i + 1}", case.lower[i], case.upper[i], case.thickness[i], "length") for i in range(n)
        )
        length = UNITS["length"][unit_of("length", case.heading.units)]
        name, quantity, maximise = _OBJECTIVES[case.goal]
        smooth, front = _smooth(case), None
        if case.goal == "most_energy" and case.limits.mass is None:
            front = TwoObjectives((smooth,), _linear(case.disc.mass_weights))
        return DesignProblem(
            variables=variables,
            objective_name=name,
            objective_quantity=quantity,
            maximise=maximise,
            alternatives=(smooth,),
            apply=lambda x: patched(document, {"design": {"thickness": (x[:n] / length).tolist()}}),
            mixed=_mixed(case),
            front=front,
            front_names=("energy", "mass") if front else None,
        )


def _read(document: Document) -> FlywheelCase:
    case, problems = read_flywheel(document)
    problems.raise_any()
    if case is None:
        raise RefusedDesign(problems.found)
    return case


def _peak(solution: Solution) -> tuple[float, float]:
    """Largest equivalent stress and its radius."""
    found, _ = solution.peaks()
    best = max(found, key=lambda one: float(one.equivalent))
    return float(best.equivalent), float(best.r)


def _linear(weights: FloatArray, sign: float = 1.0) -> Objective:
    def objective(x: FloatArray) -> tuple[float, FloatArray]:
        slope = np.zeros(len(x))
        slope[: len(weights)] = sign * weights
        return float(slope @ x), slope

    return objective


def _smooth(case: FlywheelCase) -> SmoothProblem:
    """The problem with slopes; least stress has one more variable, a bound of the stress in Pa."""
    lower, upper, start = case.lower, case.upper, np.clip(case.thickness, case.lower, case.upper)
    if case.goal == "least_stress":
        scale = case.disc.density * (case.disc.speed * case.limits.overspeed * case.disc.radii[-1]) ** 2
        lower, upper = np.append(lower, 0.01 * scale), np.append(upper, 10.0 * scale)
        start = np.append(start, scale)
        objective: Objective = _last
    elif case.goal == "least_mass":
        objective = _linear(case.disc.mass_weights)
    else:
        objective = _linear(case.disc.energy_weights, -1.0)
    stress_counts = case.goal == "least_stress" or case.limits.stress is not None
    return SmoothProblem(
        lower,
        upper,
        objective,
        _constraints(case, stress=stress_counts),
        start[None],
        convex=not stress_counts,
        labels=tuple(name for name, _, _ in _linear_limits(case)) + ("stress",) * stress_counts,
    )


def _last(x: FloatArray) -> tuple[float, FloatArray]:
    slope = np.zeros(len(x))
    slope[-1] = 1.0
    return float(x[-1]), slope


def _linear_limits(case: FlywheelCase) -> list[tuple[str, FloatArray, float]]:
    """Limits that are linear in the thickness: name, row and level with row t - level <= 0."""
    found = []
    if case.limits.mass is not None:
        found.append(("mass", case.disc.mass_weights / case.limits.mass, 1.0))
    if case.limits.energy is not None:
        found.append(("energy", -case.disc.energy_weights / case.limits.energy, -1.0))
    return found


def _constraints(case: FlywheelCase, *, stress: bool) -> Constraints:
    """Mass and energy, and stress at the nodes and at the largest of every segment."""
    rows = np.array([row for _, row, _ in _linear_limits(case)]).reshape(-1, len(case.thickness))
    levels = np.array([level for _, _, level in _linear_limits(case)])
    n = len(case.thickness)

    def constraints(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        g, slopes = rows @ x[:n] - levels, np.zeros((len(rows), len(x)))
        slopes[:, :n] = rows
        if not stress:
            return g, slopes
        solution = case.solved(x[:n])
        peaks, _ = solution.peaks()
        nodes = solution.at_nodes()
        values = np.concatenate([np.array([float(one.equivalent) for one in peaks]), nodes.equivalent.ravel()])
        by_t = np.concatenate([np.stack([one.slopes for one in peaks]), nodes.slopes.reshape(-1, n)])
        bound = x[-1] if case.goal == "least_stress" else case.limits.stress or 1.0
        by_x = np.zeros((len(values), len(x)))
        by_x[:, :n] = by_t / bound
        if case.goal == "least_stress":
            by_x[:, -1] = -values / bound**2
        return np.concatenate([g, values / bound - 1.0]), np.concatenate([slopes, by_x])

    return constraints


def _mixed(case: FlywheelCase) -> MixedProblem:
    """The same problem for searches that use values alone; populations (members, n)."""
    limits = _linear_limits(case)
    weights = {"most_energy": -case.disc.energy_weights, "least_mass": case.disc.mass_weights}.get(case.goal)

    def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        g = [x @ row - level for _, row, level in limits]
        if case.limits.stress is not None or weights is None:
            peaks = np.array([_peak(case.solved(one))[0] for one in x])
            if case.limits.stress is not None:
                g.append(peaks / case.limits.stress - 1.0)
            if weights is None:
                return peaks, np.stack(g, axis=1) if g else np.zeros((len(x), 1))
        assert weights is not None  # noqa: S101  the goal is one of the two others
        return x @ weights, np.stack(g, axis=1) if g else np.zeros((len(x), 1))

    bounds = zip(case.lower.tolist(), case.upper.tolist(), strict=True)
    return MixedProblem(tuple(Continuous(low, high) for low, high in bounds), evaluate)


def _limits(case: FlywheelCase, mass: float, energy: float, peak: tuple[float, float]) -> tuple[LimitCheck, ...]:
    found, limits = [], case.limits
    if limits.mass is not None:
        found.append(limit_check("mass", mass, limits.mass, "at_most", "mass"))
    if limits.energy is not None:
        found.append(limit_check("energy", energy, limits.energy, "at_least", "energy"))
    if limits.stress is not None:
        length = unit_of("length", case.heading.units)
        where = f"r = {peak[1] / UNITS['length'][length]:.4g} {length}"
        found.append(limit_check("stress", peak[0], limits.stress, "at_most", "stress", where))
    for i, value in enumerate(case.thickness.tolist()):
        name = f"thickness_{i + 1}"
        found.append(limit_check("lower_bound", value, float(case.lower[i]), "at_least", "length", name))
        found.append(limit_check("upper_bound", value, float(case.upper[i]), "at_most", "length", name))
    return tuple(found)


def _profile(case: FlywheelCase) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Radius, thickness and slope of the thickness along the curve."""
    n = len(case.thickness)
    u = np.linspace(0.0, segments(n), SHOWN_POINTS)
    along, along_u = basis(n, u), basis(n, u, 1)
    return along @ case.disc.radii, along @ case.thickness, (along_u @ case.thickness) / (along_u @ case.disc.radii)


def _curves(case: FlywheelCase) -> tuple[Curve, ...]:
    nodes = case.present.at_nodes()
    r = nodes.r.ravel()
    radius, thickness, _ = _profile(case)
    stresses: list[tuple[str, Callable[[], FloatArray]]] = [
        ("stress_radial", nodes.radial.ravel),
        ("stress_hoop", nodes.hoop.ravel),
        ("stress_equivalent", nodes.equivalent.ravel),
    ]
    return (
        Curve("thickness", radius, thickness, "length", "length"),
        *(Curve(name, r, values(), "length", "stress") for name, values in stresses),
    )


def _warnings(case: FlywheelCase) -> tuple[Finding, ...]:
    found = []
    _, thickness, slope = _profile(case)
    width = float(case.disc.radii[-1] - case.disc.radii[0])
    typical = case.disc.density * (case.disc.speed * float(case.disc.radii[-1])) ** 2
    if case.limits.stress is not None and case.limits.stress < IMPLAUSIBLE * typical:
        found.append(
            warning(
                Message("flywheel_limit_implausible", field="limits.stress", value=case.limits.stress, typical=typical)
            )
        )
    steepest, thickest = float(np.abs(slope).max()), 2.0 * float(thickness.max()) / width
    if steepest > STEEP:
        found.append(warning(Message("flywheel_not_thin.steep", field="design.thickness", value=steepest)))
    if thickest > 1.0:
        found.append(warning(Message("flywheel_not_thin.thick", field="design.thickness", value=thickest)))
    return tuple(found)


def _drawing(case: FlywheelCase) -> dict[str, object]:
    radius, thickness, _ = _profile(case)
    return {
        "kind": "profile",
        "radius": radius.round(9).tolist(),
        "thickness": thickness.round(9).tolist(),
        "controls": [case.disc.radii.tolist(), case.thickness.tolist()],
    }
