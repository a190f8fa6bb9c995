"""What the documents of every study have in common: format, title, units and published designs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from service.design.documents import VERSION
from service.design.reading import Problems, Table, read_units
from service.messages import Message

MAX_PUBLISHED = 50


@dataclass(frozen=True)
class Published:
    """A published design. claims: response -> published value, in the document's units; patch: of the document.

    problem: whether the patch states another problem, whose optimum is asked for, instead of a design.
    """

    name: str
    claims: Mapping[str, float]
    patch: Mapping[str, Any]
    problem: bool = False


@dataclass(frozen=True)
class Heading:
    """The common part of a document."""

    study: str
    title: str
    units: Mapping[str, str]
    published: tuple[Published, ...]


def begin(document: Mapping[str, Any]) -> tuple[Table, Problems, Heading]:
    """The document as a table to go on reading, its problems so far, and its heading."""
    problems = Problems()
    root = Table(document, "", problems)
    study = root.text("study")
    version = root.whole("version", least=1, most=1_000_000)
    if version != VERSION and "version" in root:
        problems.add(Message("design_version_unknown", field="version", value=version, known=VERSION))
    title = root.text("title", default="")
    root.text("note", default="")
    read_units(root)
    published = tuple(_published(one) for one in root.tables("published", most=MAX_PUBLISHED))
    return root, problems, Heading(study, title or study, problems.units, published)


def _published(table: Table) -> Published:
    name = table.text("name")
    claims_table = table.table("claims", optional=True)
    claims: dict[str, float] = {}
    if claims_table is not None:
        claims = {str(response): claims_table.number(str(response)) for response in claims_table.values}
    patch = table.table("set", optional=True)
    problem = table.flag("problem", default=False)
    table.close()
    return Published(name, claims, {} if patch is None else patch.values, problem)
