"""The words of docstrings, messages and documents: none that a reader abroad must look up."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from service.messages.catalogue import SOURCE, entries
from tests.messages.sources import ROOT

FORBIDDEN = re.compile(r"\b(whoever|till|nobody|so many|in words)\b", re.IGNORECASE)
"""Say: anyone who, until, no one, this many, as text."""
IN_MESSAGES = re.compile(
    FORBIDDEN.pattern + r"|(?<!there )\bis no (?!longer\b|more\b|stand-by\b|worse\b)", re.IGNORECASE
)
"""A message states the rule: X must be Y, got Z."""
DOCUMENTS = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]


def docstrings(source: str) -> Iterator[tuple[int, str]]:
    """Texts that stand alone in a module, with their lines."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, node.value.value


@pytest.mark.parametrize("package", ["service", "drivers", "db"])
def test_docstrings_are_plain(package: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {word.group()}"
        for path in sorted((ROOT / package).rglob("*.py"))
        for line, text in docstrings(path.read_text(encoding="utf-8"))
        if (word := FORBIDDEN.search(text))
    ]
    assert found == []


def test_messages_are_plain() -> None:
    texts = {
        key: text
        for key, entry in entries(SOURCE).items()
        for form in (entry.message, entry.advice)
        if form is not None
        for text in form.forms.values()
    }
    assert {key: text for key, text in texts.items() if IN_MESSAGES.search(text)} == {}


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_documents_are_plain(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if FORBIDDEN.search(line)] == []


def test_a_forbidden_word_is_found() -> None:
    assert list(docstrings('"""One."""\nx = 1\n"""Two."""\ny = "three"')) == [(1, "One."), (3, "Two.")]
    assert FORBIDDEN.search("Held till then") is not None
    assert FORBIDDEN.search("a tiller") is None
    assert IN_MESSAGES.search("x is no number") is not None
    assert IN_MESSAGES.search("there is no token") is None
