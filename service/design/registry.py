"""The kinds of study by name; a document says which one it is."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from service.design.findings import Finding, RefusedDesign, refusal
from service.design.flywheel.study import FlywheelStudy
from service.design.gear_pair.study import GearPairStudy
from service.design.linkage.study import LinkageStudy
from service.design.reading import listed, told
from service.design.shaft_set.study import ShaftSetStudy
from service.design.study import Document, Study
from service.messages import Message

_KINDS: tuple[Study, ...] = (LinkageStudy(), FlywheelStudy(), GearPairStudy(), ShaftSetStudy())
STUDIES: Mapping[str, Study] = MappingProxyType({study.name: study for study in _KINDS})


def study_of(document: Document) -> Study:
    """The study that a document asks for. Raises RefusedDesign for one that there is not."""
    name = document.get("study")
    if not isinstance(name, str) or name not in STUDIES:
        raise refusal(Message("design_study_unknown", field="study", value=told(name), known=listed(STUDIES)))
    return STUDIES[name]


def check(document: Document) -> tuple[Finding, ...]:
    """Everything that is wrong with a document of any study, and warnings; never raises for bad values."""
    try:
        study = study_of(document)
    except RefusedDesign as refused:
        return refused.findings
    return study.check(document)
