"""The documents: every link leads somewhere, every page is in the index, examples in Python are valid."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.messages.sources import ROOT

DOCUMENTS = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"")
MAX_README_LINES = 130
names = pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))


def prose(path: Path) -> str:
    """A document without its code."""
    return re.sub(r"(?ms)^```.*?^```|`[^`\n]*`", "", path.read_text(encoding="utf-8"))


def anchors(path: Path) -> set[str]:
    """What may stand behind # in a link to this page."""
    heads = re.findall(r"(?m)^#+ (.+)$", path.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


@names
def test_every_link_leads_to_a_file_and_a_heading(path: Path) -> None:
    for found in LINK.findall(prose(path)):
        target, _, anchor = (found[0] or found[1]).partition("#")
        if "://" in target or target.startswith("mailto:"):
            continue
        file = (path.parent / target).resolve() if target else path
        assert file.exists(), target
        assert not anchor or anchor in anchors(file), f"{target}#{anchor}"


@names
def test_examples_in_python_are_valid(path: Path) -> None:
    for example in re.findall(r"(?ms)^```python\n(.*?)^```", path.read_text(encoding="utf-8")):
        ast.parse(example)


def test_every_page_is_in_the_index() -> None:
    listed = {found[0].partition("#")[0] for found in LINK.findall(prose(ROOT / "docs" / "index.md"))}
    listed |= {f"decisions/{found[0]}" for found in LINK.findall(prose(ROOT / "docs" / "decisions" / "index.md"))}
    pages = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    assert pages - {"index.md"} <= listed


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= MAX_README_LINES
