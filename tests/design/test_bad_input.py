"""Bad documents: every kind is refused by name, nothing raises anything else, and `check` agrees with the rest."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.design.documents import MAX_BYTES, patched, preset, presets, read_document
from service.design.findings import RefusedDesign
from service.design.registry import check, study_of

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
}


@pytest.mark.parametrize(("document", "code"), CASES.values(), ids=CASES.keys())
def test_bad_documents_are_refused_by_name(document: dict[str, Any], code: str) -> None:
    found = check(document)
    assert code in [one.code for one in found if one.severity == "refusal"]
    for one in found:
        assert one.message
        assert one.advice
    with pytest.raises(RefusedDesign) as refused:
        study_of(document).simulate(document)
    assert refused.value.code in [one.code for one in found]
    with pytest.raises(RefusedDesign):
        study_of(document).problem(document)


def test_dyads_must_come_in_an_order_in_which_they_can_be_placed() -> None:
    document = copy.deepcopy(SIXBAR)
    document["linkage"]["dyad"].reverse()
    assert [one.code for one in check(document)] == ["linkage_dyad_support"]


def test_a_linkage_that_does_not_turn_tells_where_it_closes() -> None:
    document = link(CLEANING, "1", points={"o1": [0, 0], "o2": [0.15, 0]})
    (refused,) = [one for one in check(document) if one.severity == "refusal"]
    assert refused.advice.startswith("it closes for crank angles of ")
    assert "dyad o3 must close over the whole turn" in refused.message


@pytest.mark.parametrize(
    ("document", "code"),
    [
        (patched(FLYWHEEL, {"limits": {"stress": 0.0000064}}), "flywheel_limit_implausible"),
        (
            patched(FLYWHEEL, {"design": {"thickness": [0.06, 0.01, 0.5, 0.01, 0.01, 0.01, 0.01, 0.06]}}),
            "flywheel_not_thin",
        ),
        (patched(GEAR, {"gear": {"hardness": 149.0}}), "gear_hardness_unit"),
        (patched(GEAR, {"design": {"module": 2.25}}), "gear_module_not_standard"),
        (patched(GEAR, {"design": {"teeth": 12}}), "gear_undercut"),
        (patched(GEAR, {"gear": {"ratio": 3.3}}), "gear_teeth_ratio"),
        (patched(SHAFT, {"aim": {"weights": [0.1, 0.1, 0.8]}}), "shaft_spread_dominates"),
        (patched(SHAFT, {"aim": {"best": {"spread": 1.0}, "worst": {"spread": 1.0 + 1e-13}}}), "shaft_nothing_to_gain"),
        (CLEANING, "linkage_no_three_points"),
    ],
)
def test_what_is_only_doubtful_is_warned_of(document: dict[str, Any], code: str) -> None:
    found = check(document)
    assert code in [one.code for one in found]
    assert all(one.severity == "warning" for one in found)
    assert code in [one.code for one in study_of(document).simulate(document).warnings]


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if isinstance(value, dict):
        for name, inner in value.items():
            if name != "published":
                yield from paths(inner, (*path, name))
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from paths(inner, (*path, k))
    yield path


ANYTHING = st.one_of(
    st.none(), st.booleans(), st.integers(-3, 10**6), st.floats(), st.text(max_size=4), st.just([]), st.just({}),
    st.just([1.0, 2.0]), st.just([-1.0]), st.just(10**400),
)  # fmt: skip


@given(st.data())
@settings(max_examples=80)
def test_no_value_anywhere_raises_anything_but_a_refusal(data: st.DataObject) -> None:
    document = copy.deepcopy(PRESETS[data.draw(st.sampled_from(sorted(PRESETS)))])
    path = data.draw(st.sampled_from([one for one in paths(document) if one]))
    held: Any = document
    for name in path[:-1]:
        held = held[name]
    held[path[-1]] = data.draw(ANYTHING)
    found = check(document)
    refused = any(one.severity == "refusal" for one in found)
    try:
        study_of(document).simulate(document)
    except RefusedDesign:
        assert refused
    else:
        assert not refused


@pytest.mark.parametrize("text", ["", "= 1", "{", "[]", "{} {}", '{"a": ' * 50_000, "study = 'linkage'\nstudy = 1"])
def test_text_that_holds_no_document_is_refused(text: str) -> None:
    if text == "":
        assert check(read_document(text))[0].code == "design_study_unknown"
        return
    with pytest.raises(RefusedDesign) as refused:
        read_document(text)
    assert refused.value.code == "design_not_a_document"


def test_a_document_that_is_too_long_is_refused() -> None:
    with pytest.raises(RefusedDesign, match="at most"):
        read_document("#" * (MAX_BYTES + 1))
