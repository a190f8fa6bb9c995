"""Which selections survive the uncertainty: their objective, limits and rank over many draws of the coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.balancing.rotor.phasors import ComplexArray, FloatArray
from service.balancing.selection.batch.regions import Objectives
from service.balancing.selection.batch.solver import solve_batch
from service.balancing.selection.batch.tables import Shared
from service.balancing.selection.problem import SelectionPlane

QUANTILE = 0.95
SAME = 1e-9
"""Relative difference below which a selection is as good as a draw's best."""


@dataclass(frozen=True)
class Survival:
    """Of each candidate (C,), over the draws.

    quantile_95: objective that 95 % of the draws stay below. within: share of the draws in which every limit is kept;
    None without limits. best: share of the draws in which no selection has a smaller objective; None where the planes
    cannot be listed.
    """

    quantile_95: FloatArray
    within: FloatArray | None
    best: FloatArray | None


def survival(
    objectives: Objectives,
    candidates: ComplexArray,
    limited: Objectives | None,
    *,
    planes: Sequence[SelectionPlane] = (),
    shared: Shared | None = None,
) -> Survival:
    """Rate candidates, vector sums (C, P) in g, over the draws of an objective (D, S, P).

    limited: what has a limit, weighted so that the limit is 1, norm max. planes, shared: of the problem, from
    `tables.shared_rows`.
    """
    values = values_of(objectives, candidates)
    within = best = None
    if limited is not None:
        kept = values_of(limited, candidates) <= 1.0
        within = np.asarray(kept.mean(axis=0), dtype=np.float64)
    if shared is not None:
        least = solve_batch(shared, tuple(planes), objectives).value
        best = np.asarray((values <= least[:, None] * (1.0 + SAME)).mean(axis=0), dtype=np.float64)
    quantile = np.asarray(np.quantile(values, QUANTILE, axis=0), dtype=np.float64)
    return Survival(quantile_95=quantile, within=within, best=best)


def values_of(objectives: Objectives, candidates: ComplexArray) -> FloatArray:
    """Objective (D, C) of every candidate in every draw."""
    draws = np.arange(len(objectives))
    out = np.empty((len(draws), len(candidates)))
    for number, vectors in enumerate(candidates):
        out[:, number] = objectives.values(draws, np.repeat(vectors[None], len(draws), axis=0))
    return out
