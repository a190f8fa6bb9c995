"""Bad documents: every kind is refused by name, nothing raises anything else, and `check` agrees with the rest."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from service.design.documents import MAX_BYTES, patched, read_document
from service.design.findings import RefusedDesign
from service.design.registry import check, study_of
from tests.design.bad_documents import CASES, CLEANING, FLYWHEEL, GEAR, PRESETS, SHAFT, SIXBAR, link


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
