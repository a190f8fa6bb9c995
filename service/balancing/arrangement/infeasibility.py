"""Why no arrangement keeps the limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from service.balancing.arrangement.exact.enumeration import every_arrangement
from service.balancing.arrangement.problem import ArrangementProblem

NO_PART_FITS = "no_part_fits"
TOO_FEW_PARTS = "too_few_parts"
MAX_MOVES = "max_moves_excludes"
MAX_NEW = "max_new_parts_excludes"
GROUPS = "group_limits_exclude"
SETS = "sets_exclude"
TOGETHER = "limits_exclude_each_other"
"""Codes of reasons; the last: no single one of the limits is to blame."""


def unfillable(problem: ArrangementProblem) -> tuple[str, dict[str, float | str]] | None:
    """Reason why the places cannot be filled with parts that fit, with its parameters; None where they can."""
    must = np.flatnonzero(~problem.may_be_empty)
    fits = problem.allowed[:, must]
    lonely = np.flatnonzero(~fits.any(axis=0))
    if len(lonely):
        return NO_PART_FITS, {"place": float(must[lonely[0]])}
    if len(must) and len(fits):
        matched = maximum_bipartite_matching(csr_array(fits.T), perm_type="column")
        filled = int((matched >= 0).sum())
        if filled < len(must):
            return TOO_FEW_PARTS, {"places": float(len(must)), "parts": float(filled)}
    return None


def excluded(problem: ArrangementProblem) -> tuple[str, dict[str, float | str]]:
    """Reason why a small problem whose places can be filled has no arrangement: the limit without which it has one."""
    without: tuple[tuple[str, ArrangementProblem, float | None], ...] = (
        (MAX_MOVES, replace(problem, max_moves=None), problem.max_moves),
        (MAX_NEW, replace(problem, max_new=None), problem.max_new),
        (GROUPS, replace(problem, groups=()), float(len(problem.groups)) or None),
        (SETS, replace(problem, sets=()), float(len(problem.sets)) or None),
    )
    for code, relaxed, limit in without:
        if limit is not None and any(len(some) for some in every_arrangement(relaxed)):
            return code, {"limit": float(limit)}
    return TOGETHER, {}
