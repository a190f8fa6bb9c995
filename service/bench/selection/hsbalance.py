"""hsbalance's split, where the user has it with its solver: one plane at a time, in a process that can be ended.

Its solver (XPRESS) is proprietary; nothing here needs it. The split matches the continuous correction of each plane by
|sum - target|; it knows neither the box's counts nor a greatest number of pieces, so its answer may break the limits.
"""

from __future__ import annotations

import importlib
import importlib.util
import multiprocessing
import time
from typing import Any

import numpy as np

from service.balancing.selection.placements import Selection, effective_g
from service.balancing.selection.problem import Piece, SelectionProblem
from service.bench.selection.peer import Abilities, Found, Peer


def solve_hsbalance(problem: SelectionProblem, seed: int, budget_s: float) -> Found:
    """Split every plane's continuous correction; None where it does not answer in time."""
    del seed
    begun = time.perf_counter()
    selection, trouble = None, None
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        try:
            selection = pool.apply_async(split, (problem,)).get(budget_s)
        except multiprocessing.TimeoutError:
            trouble = "no answer in time"
        except Exception as error:  # whatever its solver refuses, such as a size beyond its licence
            trouble = str(error) or type(error).__name__
    return Found(selection, 0.0, False, time.perf_counter() - begun, trouble)


def split(problem: SelectionProblem) -> Selection:
    """Each plane by itself, through hsbalance."""
    hsbalance: Any = importlib.import_module("hsbalance")
    objective = problem.objective
    target = np.linalg.lstsq(objective.matrix, -objective.offset, rcond=None)[0]
    alpha = hsbalance.Alpha()
    alpha.add(direct_matrix=np.eye(len(target), dtype=np.complex128))
    fitted = hsbalance.LeastSquares(-target[:, None], alpha)
    fitted.W = target[:, None]
    chosen = []
    for p, plane in enumerate(problem.planes):
        task = fitted.create_split()
        degrees = np.rad2deg(plane.angles).tolist()
        most = int(min(plane.capacity.max(), plane.max_pieces))
        task.split_setup(p, degrees, effective_g(problem.stock).tolist(), max_number_weights_per_hole=most)
        counts = np.asarray(task.split_solve())
        pieces = [Piece(int(h), int(i)) for i, h in np.argwhere(counts > 0) for _ in range(int(counts[i, h]))]
        chosen.append(tuple(sorted(pieces)))
    return tuple(chosen)


def cannot_run(problem: SelectionProblem) -> str | None:
    """Why it has no answer; None where it may have one."""
    del problem
    if importlib.util.find_spec("cvxpy") is None:
        return "cvxpy is not installed"
    cvxpy: Any = importlib.import_module("cvxpy")
    return None if "XPRESS" in cvxpy.installed_solvers() else "its solver XPRESS is not installed"


HSBALANCE = Peer(
    name="hsbalance split",
    package="hsbalance",
    solve=solve_hsbalance,
    cannot=cannot_run,
    proves=True,
    abilities=Abilities(
        joint="no, plane by plane",
        stock="no",
        capacity="pieces a position; no greatest number a plane",
        norms="distance to a continuous correction only",
        proof="of each plane's split, not of the whole",
    ),
)
