"""Documents that break a rule, by what is wrong with them, each with the code of its refusal."""

from __future__ import annotations

import copy
import math
from typing import Any

from service.design.documents import patched, preset, presets

PRESETS = {name: preset(name) for name in presets()}
SIXBAR, CLEANING, EIGHTBAR = PRESETS["sixbar"], PRESETS["cleaning"], PRESETS["eightbar"]
FLYWHEEL, GEAR, SHAFT = PRESETS["flywheel_thresher"], PRESETS["gear_pair"], PRESETS["shaft_set_conflict"]


def link(document: dict[str, Any], name: str, **fields: Any) -> dict[str, Any]:
    return patched(document, {"linkage": {"link": [{"name": name, **fields}]}})


def without(document: dict[str, Any], *path: str) -> dict[str, Any]:
    changed = copy.deepcopy(document)
    held = changed
    for name in path[:-1]:
        held = held[name]
    del held[path[-1]]
    return changed


CASES: dict[str, tuple[dict[str, Any], str]] = {
    "no study": (without(SIXBAR, "study"), "design_study_unknown"),
    "another version": (patched(SIXBAR, {"version": 2}), "design_version_unknown"),
    "unit unknown": (patched(SIXBAR, {"units": {"length": "furlong"}}), "design_not_a_choice"),
    "unit not stated": (without(SIXBAR, "units", "mass"), "design_unit_missing"),
    "field unknown": (patched(SIXBAR, {"linkage": {"sped": 1.0}}), "design_field_unknown"),
    "field missing": (without(SIXBAR, "linkage", "speed"), "design_field_missing"),
    "NaN": (patched(SIXBAR, {"linkage": {"speed": math.nan}}), "design_not_finite"),
    "text for a number": (patched(SIXBAR, {"linkage": {"speed": "fast"}}), "design_not_a_number"),
    "at rest": (patched(SIXBAR, {"linkage": {"speed": 0.0}}), "design_speed_zero"),
    "links too long to close": (link(SIXBAR, "4", points={"D": [0, 0], "G": [0.9, 0]}), "linkage_does_not_close"),
    "crank does not turn": (link(CLEANING, "1", points={"o1": [0, 0], "o2": [0.15, 0]}), "linkage_does_not_close"),
    "loop three cannot close": (link(EIGHTBAR, "9", points={"H": [0, 0], "G": [100, 0]}), "linkage_does_not_close"),
    "in line at some angle": (
        patched(
            link(CLEANING, "2", points={"o2": [0, 0], "o3": [0.1, 0]}), {"linkage": {"ground": {"o4": [0.2593, 0]}}}
        ),
        "linkage_does_not_close",
    ),
    "length zero": (link(SIXBAR, "2", points={"A": [0, 0], "C": [0, 0]}), "linkage_zero_length"),
    "negative mass": (link(SIXBAR, "2", mass=-1.0), "design_out_of_range"),
    "negative inertia": (link(SIXBAR, "2", inertia=-1.0), "design_out_of_range"),
    "inertia below that of the centre": (link(SIXBAR, "2", inertia=1e-5), "body_inertia_impossible"),
    "link never placed": (
        patched(SIXBAR, {"linkage": {"link": [{**SIXBAR["linkage"]["link"][3], "name": "6"}]}}),
        "linkage_link_unplaced",
    ),
    "crank without a pivot": (patched(SIXBAR, {"linkage": {"crank": "4"}}), "linkage_crank_pivot"),
    "bounds crossed": (patched(SIXBAR, {"design": {"x_bounds": [0.1, -0.1]}}), "design_bounds_crossed"),
    "weights all zero": (patched(SIXBAR, {"aim": {"weights": {"force": 0.0, "moment": 0.0}}}), "design_weights"),
    "weight negative": (patched(SIXBAR, {"aim": {"weights": {"force": -1.0}}}), "design_weights"),
    "front of one thing": (patched(SIXBAR, {"aim": {"front": ["force", "force"]}}), "design_name_unknown"),
    "counterweight on no link": (
        {
            **SIXBAR,
            "design": {**SIXBAR["design"], "counterweight": [{"link": "7", "x": 0.0, "y": 0.0, "thickness": 0.01}]},
        },
        "design_name_unknown",
    ),
    "hub of no radius": (patched(FLYWHEEL, {"disc": {"inner_radius": 0.0}}), "design_out_of_range"),
    "rim inside the hub": (patched(FLYWHEEL, {"disc": {"outer_radius": 0.05}}), "design_out_of_range"),
    "thickness negative": (patched(FLYWHEEL, {"design": {"thickness": [0.02] * 7 + [-0.05]}}), "disc_thickness"),
    "thickness bounds at zero": (
        patched(FLYWHEEL, {"design": {"thickness_bounds": [0.0, 0.05]}}),
        "design_out_of_range",
    ),
    "three control points": (patched(FLYWHEEL, {"design": {"thickness": [0.02] * 3}}), "design_count_out_of_range"),
    "radii unsorted": (
        patched(
            without(without(FLYWHEEL, "disc", "inner_radius"), "disc", "outer_radius"),
            {"disc": {"radii": [0.06, 0.2, 0.1, 0.3, 0.35, 0.4, 0.45, 0.5]}},
        ),
        "design_not_rising",
    ),
    "Poisson's ratio": (patched(FLYWHEEL, {"disc": {"poisson": 0.5}}), "design_out_of_range"),
    "flywheel at rest": (patched(FLYWHEEL, {"disc": {"speed": 0.0}}), "design_speed_zero"),
    "lighter than the bounds": (patched(FLYWHEEL, {"limits": {"mass": 50.0}}), "design_infeasible_bounds"),
    "helix of 45 degrees": (patched(GEAR, {"gear": {"helix": 45.0}}), "gear_helix"),
    "ratio below one": (patched(GEAR, {"gear": {"ratio": 0.5}}), "design_out_of_range"),
    "overlap below one": (patched(GEAR, {"gear": {"overlap_ratio": 0.9}}), "gear_overlap"),
    "no power": (patched(GEAR, {"gear": {"power": 0.0}}), "design_out_of_range"),
    "teeth not whole": (patched(GEAR, {"design": {"teeth": 17.5}}), "design_not_whole"),
    "widths below twenty modules": (
        patched(GEAR, {"design": {"width_bounds": [5.0, 15.0]}}),
        "design_infeasible_bounds",
    ),
    "widths crossed": (patched(GEAR, {"design": {"width_bounds": [200.0, 20.0]}}), "design_bounds_crossed"),
    "modules unsorted": (patched(GEAR, {"design": {"modules": [2.0, 1.0]}}), "design_not_rising"),
    "shaft weights": (patched(SHAFT, {"aim": {"weights": [0.0, 0.0, 0.0]}}), "design_weights"),
    "fewer sensors than planes": (
        patched(
            SHAFT,
            {
                "shaft_set": {
                    "sensors": ["1X", "1Y"],
                    "initial": SHAFT["shaft_set"]["initial"][:2],
                    "influence": SHAFT["shaft_set"]["influence"][:2],
                }
            },
        ),
        "shaft_too_few_sensors",
    ),
    "planes alike": (
        patched(
            SHAFT, {"shaft_set": {"influence": [[row[0], row[0], row[2]] for row in SHAFT["shaft_set"]["influence"]]}}
        ),
        "shaft_planes_alike",
    ),
    "influence of another shape": (patched(SHAFT, {"shaft_set": {"influence": [[[1.0, 0.0]]]}}), "design_not_a_list"),
    "NaN in the vibration": (patched(SHAFT, {"shaft_set": {"initial": [[math.nan, 0.0]] * 8}}), "design_not_finite"),
    "worst better than best": (
        patched(SHAFT, {"aim": {"best": {"largest": 9.0}, "worst": {"largest": 5.0}}}),
        "design_bounds_crossed",
    ),
    "mass zero": (link(SIXBAR, "2", mass=0.0), "design_out_of_range"),
    "inertia zero": (link(SIXBAR, "2", inertia=0.0), "design_out_of_range"),
    "coupler and rocker within half a degree of a line": (
        patched(CLEANING, {"linkage": {"ground": {"o4": [0.358999, 0.0]}}}),
        "linkage_singular",
    ),
    "infinite speed": (patched(SIXBAR, {"linkage": {"speed": math.inf}}), "design_not_finite"),
    "flywheel's bounds crossed": (
        patched(FLYWHEEL, {"design": {"thickness_bounds": [0.06, 0.01]}}),
        "design_bounds_crossed",
    ),
    "no gear speed": (patched(GEAR, {"gear": {"speed": 0.0}}), "design_out_of_range"),
    "gear's NaN": (patched(GEAR, {"gear": {"hardness": math.nan}}), "design_not_finite"),
    "shaft weight negative": (patched(SHAFT, {"aim": {"weights": [1.0, -0.1, 0.1]}}), "design_weights"),
}
