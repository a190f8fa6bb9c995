"""Numerics of balancing: arrays in, frozen dataclasses out; no I/O, clock, logging or global random state.

One complex convention throughout: a vector is magnitude * exp(1j * angle), angles in radians, masses counted
against the rotation and phases as lag, so that v = v0 + A u holds (`phasor` mirrors whatever is stated otherwise).
Masses in g, unbalance in g.mm, velocities as the sensor states them.

=============== =================================================================
rotor           conventions, units, reactions, tolerances, intervals
influence       from runs to continuous correction masses, and what is wrong with runs
selection       which stock masses go into which positions, with the exact search
arrangement     which part goes into which place
=============== =================================================================

The names below are the door for other programs; each is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from service.balancing.influence.analysis import analyse, diagnose
    from service.balancing.influence.corrections import least_squares, minimax
    from service.balancing.influence.fit import InfluenceFit, RunSet, fit_influence, predict
    from service.balancing.influence.trial_mass import centrifugal_force
    from service.balancing.influence.uncertainty import ellipses
    from service.balancing.rotor.phasors import phasor, polar, to_degrees, to_radians
    from service.balancing.rotor.reactions import bearing_reactions
    from service.balancing.rotor.tolerance import permissible, vibration_zone
    from service.balancing.rotor.units import Scale, angular_speed, convert
    from service.balancing.selection.alternatives import best_selections, front, solve_fewest
    from service.balancing.selection.brute_force import solve_exhaustive
    from service.balancing.selection.certified import solve_certified
    from service.balancing.selection.exact.search import solve_exact
    from service.balancing.selection.objectives import bearing_force, components, evaluate, residual_vibration
    from service.balancing.selection.problem import (
        UNLIMITED,
        Objective,
        SelectionPlane,
        SelectionProblem,
        SelectionResult,
        Stock,
    )

_HOMES = {
    "service.balancing.rotor.phasors": ("phasor", "polar", "to_degrees", "to_radians"),
    "service.balancing.rotor.units": ("Scale", "angular_speed", "convert"),
    "service.balancing.rotor.tolerance": ("permissible", "vibration_zone"),
    "service.balancing.rotor.reactions": ("bearing_reactions",),
    "service.balancing.influence.fit": ("InfluenceFit", "RunSet", "fit_influence", "predict"),
    "service.balancing.influence.corrections": ("least_squares", "minimax"),
    "service.balancing.influence.analysis": ("analyse", "diagnose"),
    "service.balancing.influence.uncertainty": ("ellipses",),
    "service.balancing.influence.trial_mass": ("centrifugal_force",),
    "service.balancing.selection.problem": (
        "UNLIMITED",
        "Objective",
        "SelectionPlane",
        "SelectionProblem",
        "SelectionResult",
        "Stock",
    ),
    "service.balancing.selection.objectives": ("bearing_force", "components", "evaluate", "residual_vibration"),
    "service.balancing.selection.certified": ("solve_certified",),
    "service.balancing.selection.alternatives": ("best_selections", "front", "solve_fewest"),
    "service.balancing.selection.exact.search": ("solve_exact",),
    "service.balancing.selection.brute_force": ("solve_exhaustive",),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "UNLIMITED",
    "InfluenceFit",
    "Objective",
    "RunSet",
    "Scale",
    "SelectionPlane",
    "SelectionProblem",
    "SelectionResult",
    "Stock",
    "analyse",
    "angular_speed",
    "bearing_force",
    "bearing_reactions",
    "best_selections",
    "centrifugal_force",
    "components",
    "convert",
    "diagnose",
    "ellipses",
    "evaluate",
    "fit_influence",
    "front",
    "least_squares",
    "minimax",
    "permissible",
    "phasor",
    "polar",
    "predict",
    "residual_vibration",
    "solve_certified",
    "solve_exact",
    "solve_exhaustive",
    "solve_fewest",
    "to_degrees",
    "to_radians",
    "vibration_zone",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module. Raises AttributeError for any other."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
