"""The mass that the part in one place should have, all others staying."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar

from service.balancing.arrangement.problem import ArrangementProblem
from service.balancing.arrangement.rating import residuals
from service.balancing.rotor.phasors import ComplexArray, IntArray
from service.balancing.selection.objectives import norm_of


def wanted_mass(problem: ArrangementProblem, others: IntArray, gain: ComplexArray) -> tuple[float, float]:
    """Mass in g, at least 0, with the least objective, and that objective.

    others: (P,) arrangement with the place empty. gain: (S,) residual per gram of a part there. The objective is convex
    in the mass, so that its least value is found between 0 and twice the mass that any component alone would ask for.
    """
    r = residuals(problem, others[None, :])[0]
    size = np.abs(gain)
    if not size.max() > 0.0:
        return 0.0, float(norm_of(problem.objective, r))
    most = 2.0 * float((np.abs(r)[size > 0.0] / size[size > 0.0]).max()) + 1.0
    found = minimize_scalar(
        lambda mass: float(norm_of(problem.objective, r + mass * gain)),
        bounds=(0.0, most),
        method="bounded",
        options={"xatol": 1e-6 * most},
    )
    none = float(norm_of(problem.objective, r))
    return (0.0, none) if none <= found.fun else (float(found.x), float(found.fun))
