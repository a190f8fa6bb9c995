"""SCIP as a peer: it takes the norms as they are, as second-order cones, instead of polygons."""

from __future__ import annotations

import importlib
import time
from typing import Any

import numpy as np

from service.balancing.selection.problem import SelectionProblem
from service.bench.selection.linear import Linear, linear_without_costs
from service.bench.selection.peer import Abilities, Found, Peer


def solve_scip(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
    """SCIP on whole numbers of pieces and cones |r| <= t; within its feasibility tolerance."""
    scip: Any = importlib.import_module("pyscipopt")
    begun = time.perf_counter()
    form = linear_without_costs(problem)
    model = scip.Model()
    model.hideOutput()
    model.setParam("limits/time", budget_s)
    model.setParam("limits/gap", 0.0)
    model.setParam("randomization/randomseedshift", seed)
    counts = [model.addVar(vtype="I", lb=0, ub=float(most)) for most in form.most]
    for row, limit in zip(form.G, form.h, strict=True):
        model.addCons(scip.quicksum(float(row[k]) * counts[k] for k in np.flatnonzero(row)) <= float(limit))
    model.setObjective(_cost(scip, model, problem, form, counts), "minimize")
    model.optimize()
    bound = max(0.0, float(model.getDualbound()))
    selection = None
    if model.getNSols() > 0:
        best = model.getBestSol()
        chosen = np.rint([model.getSolVal(best, count) for count in counts]).astype(np.int64)
        selection = form.selection(chosen, len(problem.planes))
    return Found(selection, bound, model.getStatus() == "optimal", time.perf_counter() - begun)


def _cost(scip: Any, model: Any, problem: SelectionProblem, form: Linear, counts: list[Any]) -> Any:
    """The norm as an expression in new variables t >= |r|, each bounded by a cone or by both signs."""
    objective = problem.objective
    vector = objective.weights[:, None] * objective.matrix[:, form.plane] * form.vector
    fixed = np.array([plane.fixed for plane in problem.planes])
    start = objective.weights * (objective.offset + objective.matrix @ fixed)
    parts = []
    for row, begin in zip(vector, start, strict=True):
        re, im = model.addVar(lb=None), model.addVar(lb=None)
        model.addCons(scip.quicksum(float(c) * n for c, n in zip(row.real, counts, strict=True)) + begin.real == re)
        model.addCons(scip.quicksum(float(c) * n for c, n in zip(row.imag, counts, strict=True)) + begin.imag == im)
        parts.append((re, im))
    if objective.norm == "components":
        return scip.quicksum(_at_least(model, part, -part) for pair in parts for part in pair)
    if objective.norm == "rms":
        t = model.addVar(lb=0)
        model.addCons(scip.quicksum(re * re + im * im for re, im in parts) <= len(parts) * t * t)
        return t
    one = model.addVar(lb=0)
    each = [one if objective.norm == "max" else model.addVar(lb=0) for _ in parts]
    for t, (re, im) in zip(each, parts, strict=True):
        model.addCons(re * re + im * im <= t * t)
    return one if objective.norm == "max" else scip.quicksum(each)


def _at_least(model: Any, *values: Any) -> Any:
    t = model.addVar(lb=0)
    for value in values:
        model.addCons(t >= value)
    return t


def _anything(problem: SelectionProblem) -> None:
    del problem


ABILITIES = Abilities("yes", "yes", "pieces and grams", "all", "within its tolerances")
SCIP = Peer("SCIP", "pyscipopt", solve_scip, _anything, True, ABILITIES)
