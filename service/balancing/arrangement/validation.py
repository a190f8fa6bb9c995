"""What an arrangement problem must satisfy before a search starts."""

from __future__ import annotations

import numpy as np

from service.balancing.arrangement.problem import EMPTY, ArrangementProblem
from service.errors import NumericsError
from service.messages import Message


def validate(problem: ArrangementProblem) -> None:
    """Raise NumericsError for arrays of the wrong shape or values that are not finite."""
    if problem.effects.ndim != 3 or 0 in problem.effects.shape[1:]:
        raise NumericsError(Message("numerics.effects_shape", shape=problem.effects.shape), field="effects")
    parts, places, size = problem.effects.shape
    for name, array, shape in (
        ("offset", problem.objective.offset, (size,)),
        ("weights", problem.objective.weights, (size,)),
        ("allowed", problem.allowed, (parts, places)),
        ("may_be_empty", problem.may_be_empty, (places,)),
        ("present", problem.present, (places,)),
        ("new", problem.new, (parts,)),
        ("masses_g", problem.masses_g, (parts,)),
    ):
        if array.shape != shape:
            raise NumericsError(
                Message("numerics.array_shape", name=name, wanted=shape, shape=array.shape),
                field=name,
                value=array.shape,
            )
    if not (np.isfinite(problem.effects).all() and np.isfinite(problem.objective.offset).all()):
        raise NumericsError(Message("numerics.effects_not_finite"), field="effects")
    _check_present(problem)
    for name, limit in (("max_moves", problem.max_moves), ("max_new", problem.max_new)):
        if limit is not None and limit < 0:
            raise NumericsError(Message("numerics.below_lower_limit", name=name, lower=limit), field=name, value=limit)


def _check_present(problem: ArrangementProblem) -> None:
    mounted = problem.present[problem.present != EMPTY]
    if len(mounted) and (int(mounted.min()) < 0 or int(mounted.max()) >= problem.parts):
        raise NumericsError(Message("numerics.present_not_a_part", most=problem.parts), field="present")
    if len(np.unique(mounted)) != len(mounted):
        raise NumericsError(Message("part_in_two_places"), field="present")
