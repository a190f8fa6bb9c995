"""Named peers on the product's own selection problems: what each finds, and what it says it has proved.

A peer's word is never taken for a value: its selection is rated by the product, and against every limit.
"""

from __future__ import annotations

import importlib
import importlib.util
import time
from typing import Any

import numpy as np

from service.balancing.selection.objectives import evaluate
from service.balancing.selection.placements import broken_limit, vectors_of
from service.balancing.selection.problem import SelectionProblem
from service.bench.selection.coding import Coded
from service.bench.selection.hsbalance import HSBALANCE
from service.bench.selection.linear import cannot_state, linear
from service.bench.selection.peer import Abilities, Found, Peer
from service.bench.selection.scip import SCIP
from service.messages import render

POPULATION = 50
WORKERS = 2
LARGEST = 1e7
"""CP-SAT takes whole numbers: coefficients are rounded to this part of the greatest."""


def rated(problem: SelectionProblem, found: Found) -> tuple[float, str | None]:
    """Value of a peer's selection, and the limit that it breaks."""
    if found.selection is None:
        return float("inf"), None
    value = float(evaluate(problem.objective, vectors_of(problem, found.selection)))
    broken = broken_limit(problem, found.selection)
    return value, None if broken is None else render(broken)


def solve_cp_sat(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
    """OR-Tools CP-SAT on the linear form, coefficients rounded to whole numbers."""
    cp_model: Any = importlib.import_module("ortools.sat.python.cp_model")
    begun = time.perf_counter()
    form = linear(problem)
    scale = LARGEST / max(float(np.abs(form.C).max()), float(np.abs(form.d).max()))
    model = cp_model.CpModel()
    n = [model.new_int_var(0, int(most), "") for most in form.most]
    far = int(2 * LARGEST * (1 + sum(plane.max_pieces for plane in problem.planes)))
    t = [model.new_int_var(0, far, "") for _ in range(int(form.of.max()) + 1)]
    rounded = np.rint(scale * form.C).astype(np.int64)
    for row, constant, of in zip(rounded, np.rint(scale * form.d).astype(np.int64), form.of, strict=True):
        model.add(cp_model.LinearExpr.weighted_sum(n, row.tolist()) + int(constant) <= t[of])
    for limits, limit in zip(np.rint(1000.0 * form.G).astype(np.int64), form.h, strict=True):
        model.add(cp_model.LinearExpr.weighted_sum(n, limits.tolist()) <= round(1000.0 * float(limit)))
    model.minimize(sum(t))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers, solver.parameters.random_seed = WORKERS, seed
    solver.parameters.max_time_in_seconds = budget_s
    status = solver.solve(model)
    # Each row may be off by half a unit for every piece and the constant.
    slack = 0.5 * len(t) * (1 + sum(plane.max_pieces for plane in problem.planes))
    bound = max(0.0, (solver.best_objective_bound - slack) / scale)
    selection = None
    if status in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        selection = form.selection(np.array([solver.value(v) for v in n]), len(problem.planes))
    return Found(selection, bound, status == cp_model.OPTIMAL, time.perf_counter() - begun)


def solve_highs(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
    """HiGHS through scipy.optimize.milp on the linear form; it has no seed to set."""
    del seed
    from scipy.optimize import Bounds, LinearConstraint, milp

    begun = time.perf_counter()
    form = linear(problem)
    k, costs = len(form.most), int(form.of.max()) + 1
    pick = np.zeros((len(form.of), costs))
    pick[np.arange(len(form.of)), form.of] = -1.0
    rows = [LinearConstraint(np.hstack([form.C, pick]), -np.inf, -form.d)]
    if len(form.h):
        rows.append(LinearConstraint(np.hstack([form.G, np.zeros((len(form.G), costs))]), -np.inf, form.h))
    answer: Any = milp(
        np.concatenate([np.zeros(k), np.ones(costs)]),
        integrality=np.concatenate([np.ones(k), np.zeros(costs)]),
        bounds=Bounds(np.zeros(k + costs), np.concatenate([form.most, np.full(costs, np.inf)])),
        constraints=rows,
        options={"time_limit": budget_s, "mip_rel_gap": 0.0},
    )
    selection = None
    if answer.x is not None:
        selection = form.selection(np.rint(answer.x[:k]).astype(np.int64), len(problem.planes))
    bound = 0.0 if answer.mip_dual_bound is None else max(0.0, float(answer.mip_dual_bound))
    return Found(selection, bound, answer.status == 0, time.perf_counter() - begun)


def solve_pymoo(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
    """The mixed-variable GA of pymoo: masses as whole numbers, positions as choices, limits as a constraint."""
    core: Any = importlib.import_module("pymoo.core.problem")
    variables: Any = importlib.import_module("pymoo.core.variable")
    mixed: Any = importlib.import_module("pymoo.core.mixed")
    optimize: Any = importlib.import_module("pymoo.optimize")
    by_time: Any = importlib.import_module("pymoo.termination.max_time")
    begun = time.perf_counter()
    coded = Coded.of(problem)
    names = [f"x{k:03}" for k in range(len(coded.highest))]
    kinds = {
        name: variables.Integer(bounds=(0, int(high)))
        if k % 2 == 0
        else variables.Choice(options=list(range(int(high) + 1)))
        for k, (name, high) in enumerate(zip(names, coded.highest, strict=True))
    }

    def rate(_: object, x: dict[str, int], out: dict[str, float], *args: object, **kwargs: object) -> None:
        del args, kwargs
        out["F"], out["G"] = coded.rate([x[name] for name in names])

    posed = type("Posed", (core.ElementwiseProblem,), {"_evaluate": rate})(vars=kinds, n_obj=1, n_ieq_constr=1)
    answer = optimize.minimize(
        posed, mixed.MixedVariableGA(pop_size=POPULATION), by_time.TimeBasedTermination(budget_s), seed=seed
    )
    selection = None if answer.X is None else coded.selection([answer.X[name] for name in names])
    return Found(selection, 0.0, False, time.perf_counter() - begun)


def solve_mealpy(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
    """The Jaya of mealpy (`JA.OriginalJA`): whole numbers, limits by penalty."""
    mealpy: Any = importlib.import_module("mealpy")
    begun = time.perf_counter()
    coded = Coded.of(problem)
    posed = {
        "bounds": mealpy.IntegerVar(lb=[0] * len(coded.highest), ub=coded.highest.tolist()),
        "obj_func": coded.penalised,
        "minmax": "min",
        "log_to": None,
    }
    model = mealpy.JA.OriginalJA(epoch=100_000, pop_size=POPULATION)
    best = model.solve(posed, termination={"max_time": max(budget_s, 0.1)}, seed=seed)
    return Found(coded.selection(best.solution), 0.0, False, time.perf_counter() - begun)


def _anything(problem: SelectionProblem) -> None:
    del problem


POLYGON = "components; sum and max as polygons of 32 sides; no rms"
CP_SAT = Abilities("yes", "yes", "pieces and grams", POLYGON, "of coefficients rounded to 7 digits")
HIGHS = Abilities("yes", "yes", "pieces and grams", POLYGON, "within its tolerances")
PYMOO = Abilities("yes", "as a constraint", "as a constraint", "all", "no")
MEALPY = Abilities("yes", "by penalty", "by penalty", "all", "no")


def peers() -> tuple[Peer, ...]:
    """All peers, installed or not."""
    return (
        Peer("OR-Tools CP-SAT", "ortools", solve_cp_sat, cannot_state, True, CP_SAT),
        Peer("HiGHS (scipy)", "scipy", solve_highs, cannot_state, True, HIGHS),
        Peer("pymoo mixed GA", "pymoo", solve_pymoo, _anything, False, PYMOO),
        Peer("mealpy Jaya", "mealpy", solve_mealpy, _anything, False, MEALPY),
        SCIP,
        HSBALANCE,
    )
