"""Which weighed part goes into which place: the arrangement with the least unbalance, proved.

Arrays in, frozen dataclasses out; angles in radians in the internal sense, masses in g, unbalance in g.mm.

=============== =================================================================
problem         parts, places and limits; states and results of a search
unbalance       what a part in a place does, carried to the planes
validation      what a problem must satisfy
rating          residual, value, moves and limits of many arrangements
exact           complete searches and bounds, a room of its own
local_search    swaps, and two swaps at once, from many starts
record          the best so far, and how equals are told apart
solve           the searches: least objective, fewest moves, front
results         a search run to its end, and how it ended
infeasibility   why no arrangement keeps the limits
uncertainty     what the scale cannot tell
replacement     the mass that a part in one place should have
with_masses     parts and stock masses as one problem
makers_rule     the heaviest parts opposite each other
=============== =================================================================
"""

from service.balancing.arrangement.makers_rule import opposite_pairs
from service.balancing.arrangement.problem import (
    EMPTY,
    ArrangementProblem,
    ArrangementResult,
    ArrangementState,
    GroupLimit,
    none_mounted,
)
from service.balancing.arrangement.rating import moves, new_parts, residuals, values, within_limits
from service.balancing.arrangement.replacement import wanted_mass
from service.balancing.arrangement.results import solve_best, solve_fewest
from service.balancing.arrangement.solve import search_best, search_fewest, search_front
from service.balancing.arrangement.unbalance import end_gains, part_effects, plane_shares
from service.balancing.arrangement.uncertainty import objective_deviation, residual_covariance, scale_deviation
from service.balancing.arrangement.with_masses import JointResult, MassChoice, solve_with_masses

__all__ = [
    "EMPTY",
    "ArrangementProblem",
    "ArrangementResult",
    "ArrangementState",
    "GroupLimit",
    "JointResult",
    "MassChoice",
    "end_gains",
    "moves",
    "new_parts",
    "none_mounted",
    "objective_deviation",
    "opposite_pairs",
    "part_effects",
    "plane_shares",
    "residual_covariance",
    "residuals",
    "scale_deviation",
    "search_best",
    "search_fewest",
    "search_front",
    "solve_best",
    "solve_fewest",
    "solve_with_masses",
    "values",
    "wanted_mass",
    "within_limits",
]
